#include "server/jobs/frames.h"

#include <string>
#include <utility>

namespace photond {

namespace {

constexpr std::size_t kKept = 3;  // the newest, and what viewers may still be fetching

Result<std::vector<std::byte>> encode_frame(const Image& image, const std::optional<ErrorLayers>& error,
                                            FrameFormat format) {
  if (format == FrameFormat::png) return encode(image, ImageFormat::png);
  if (format == FrameFormat::jpg) return encode(image, ImageFormat::jpeg);
  return error ? encode_exr(image, *error) : encode(image, ImageFormat::exr_half);
}

}  // namespace

void Frames::publish(std::uint32_t revision, Image image, std::optional<ErrorLayers> error) {
  auto frame = std::make_shared<Frame>();
  frame->revision = revision;
  frame->image = std::move(image);
  const std::size_t keep = error ? 1 : kKept - 1;
  frame->error = std::move(error);
  const std::lock_guard lock(mutex_);
  while (frames_.size() > keep) frames_.erase(frames_.begin());
  frames_.push_back(std::move(frame));
}

std::shared_ptr<Frames::Frame> Frames::find(std::uint32_t revision) const {
  const std::lock_guard lock(mutex_);
  for (const auto& frame : frames_) {
    if (frame->revision == revision) return frame;
  }
  return nullptr;
}

Result<Frames::Bytes> Frames::get(std::uint32_t revision, FrameFormat format) const {
  const std::shared_ptr<Frame> frame = find(revision);
  if (!frame) {
    return Error{ErrorCode::not_found, "revision " + std::to_string(revision) + " is not kept; ask for latest",
                 ""};
  }
  const std::lock_guard lock(frame->encoding);
  Bytes& bytes = frame->encoded[static_cast<int>(format)];
  if (!bytes) {
    Result<std::vector<std::byte>> encoded = encode_frame(frame->image, frame->error, format);
    if (!encoded) return encoded.error();
    bytes = std::make_shared<const std::vector<std::byte>>(std::move(*encoded));
  }
  return bytes;
}

void Frames::clear() {
  const std::lock_guard lock(mutex_);
  frames_.clear();
}

}  // namespace photond
