#include "server/jobs/frames.h"

#include <string>
#include <utility>

namespace photond {

namespace {

constexpr std::size_t kKept = 3;  // the newest, and what viewers may still be fetching

Result<std::vector<std::byte>> encode_frame(const Image& image, const std::optional<ErrorLayers>& error,
                                            FrameFormat format, const std::stop_token& stop = {}) {
  if (format == FrameFormat::png) return encode(image, ImageFormat::png, {}, stop);
  if (format == FrameFormat::jpg) return encode(image, ImageFormat::jpeg, {}, stop);
  return error ? encode_exr(image, *error, stop) : encode(image, ImageFormat::exr_half, {}, stop);
}

Result<std::vector<std::byte>> encode_layer(const Image& error, FrameFormat format) {
  if (format == FrameFormat::png) return encode(error, ImageFormat::png, {kErrorStops});
  if (format == FrameFormat::jpg) return encode(error, ImageFormat::jpeg, {kErrorStops});
  return encode(error, ImageFormat::exr_float);
}

const Image& part(const ErrorLayers& error, FrameLayer layer) {
  if (layer == FrameLayer::noise) return error.noise;
  return layer == FrameLayer::bias ? error.bias : error.bound;
}

Error not_kept(std::uint32_t revision) {
  return {ErrorCode::not_found, "revision " + std::to_string(revision) + " is not kept; ask for latest", ""};
}

Result<Frames::Bytes> shared(Result<std::vector<std::byte>> encoded) {
  if (!encoded) return encoded.error();
  return std::make_shared<const std::vector<std::byte>>(std::move(*encoded));
}

}  // namespace

const char* layer_name(FrameLayer layer) {
  static constexpr const char* kNames[kFrameLayers] = {"", "error.noise", "error.bias", "error.bound"};
  return kNames[static_cast<int>(layer)];
}

void Frames::publish(std::uint32_t revision, Image image, std::optional<ErrorLayers> error) {
  auto frame = std::make_shared<Frame>();
  frame->revision = revision;
  frame->image = std::move(image);
  const std::size_t keep = error ? 1 : kKept - 1;
  frame->error = std::move(error);
  const std::lock_guard lock(mutex_);
  std::erase_if(frames_, [revision](const auto& other) { return other->revision == revision; });
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

Result<Frames::Bytes> Frames::get(std::uint32_t revision, FrameFormat format, FrameLayer layer,
                                  const std::stop_token& stop) const {
  const std::shared_ptr<Frame> frame = find(revision);
  asked_ = true;
  if (!frame) return not_kept(revision);
  if (layer != FrameLayer::radiance && !frame->error) {
    return Error{ErrorCode::not_found,
                 "revision " + std::to_string(revision) + " was kept without its error; the next one comes with it", ""};
  }
  const std::lock_guard lock(frame->encoding);
  Bytes& bytes = frame->bytes(format, layer);
  if (!bytes) {
    if (frame->closed[static_cast<std::size_t>(format)]) return not_kept(revision);
    Result<Bytes> encoded = shared(layer == FrameLayer::radiance ? encode_frame(frame->image, frame->error, format, stop)
                                                                 : encode_layer(part(*frame->error, layer), format));
    if (!encoded) return encoded.error();
    bytes = std::move(*encoded);
  }
  return bytes;
}

Result<Frames::Bytes> Frames::quick_exr(std::uint32_t revision) const {
  const std::shared_ptr<Frame> frame = find(revision);
  if (!frame) return not_kept(revision);
  const std::lock_guard lock(frame->encoding);
  Bytes& bytes = frame->bytes(FrameFormat::exr);
  if (!bytes) {
    Result<Bytes> encoded = shared(encode(frame->image, ImageFormat::exr_half_raw));
    if (!encoded) return encoded.error();
    bytes = std::move(*encoded);
  }
  return bytes;
}

Frames::Bytes Frames::close(std::uint32_t revision, FrameFormat format) {
  const std::shared_ptr<Frame> frame = find(revision);
  if (!frame) return nullptr;
  const std::lock_guard lock(frame->encoding);
  frame->closed[static_cast<std::size_t>(format)] = true;
  return frame->bytes(format);
}

void Frames::clear() {
  const std::lock_guard lock(mutex_);
  frames_.clear();
}

Result<Frames::Bytes> picture_from_exr(const std::vector<std::byte>& exr, FrameLayer layer, FrameFormat format) {
  const Result<Image> image = decode_exr(exr, layer_name(layer));
  if (!image) return image.error();
  return shared(layer == FrameLayer::radiance ? encode_frame(*image, std::nullopt, format)
                                              : encode_layer(*image, format));
}

}  // namespace photond
