#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <vector>

#include "core/base/result.h"
#include "core/film/encode.h"
#include "core/film/error.h"
#include "core/film/image.h"
#include "server/store/records.h"

namespace photond {

/// What a picture shows: radiance, or a part of its error (ErrorLayers). PNG and JPEG show an error kErrorStops brighter
/// than the picture.
enum class FrameLayer : std::uint8_t { radiance, noise, bias, bound };
inline constexpr int kFrameLayers = 4;
inline constexpr float kErrorStops = 3;  // an error of a hundredth of white is a dark grey, of an eighth white
const char* layer_name(FrameLayer layer);  ///< as of the channels in EXR: "error.noise"; of radiance empty

/// The newest few pictures of one job that runs. Each is encoded when first asked for, once per format, and shared.
/// Once a job rests, its newest picture is on the disk (JobFiles) and these are dropped.
class Frames {
 public:
  using Bytes = std::shared_ptr<const std::vector<std::byte>>;

  /// Adds a picture, in place of one of the same revision, of which no record could be stored; the oldest beyond three,
  /// or beyond two where one comes with its `error`, are dropped. With `error` it is encoded as 32-bit EXR with the error
  /// layers, as the result of a job always is, else as 16-bit.
  void publish(std::uint32_t revision, Image image, std::optional<ErrorLayers> error);
  /// Errors: not_found (never published, without its error, or no longer kept), the encoder's own,
  /// cancelled, as soon as `stop` asks.
  Result<Bytes> get(std::uint32_t revision, FrameFormat format, FrameLayer layer = FrameLayer::radiance,
                    const std::stop_token& stop = {}) const;
  /// Whether any picture was ever asked for.
  bool asked() const { return asked_; }
  /// The picture as EXR: what `get` has made already, else one that is large but takes little time to make; from now on
  /// `get` answers the same. Errors: as get.
  Result<Bytes> quick_exr(std::uint32_t revision) const;
  /// What `get` has made already, null where it has not; from now on it makes none of this format: not_found.
  Bytes close(std::uint32_t revision, FrameFormat format);
  void clear();

 private:
  struct Frame {
    std::uint32_t revision = 0;
    Image image;
    std::optional<ErrorLayers> error;
    std::mutex encoding;  ///< one encoder per picture at a time
    std::array<std::array<Bytes, kFrameFormats>, kFrameLayers> encoded;
    std::array<bool, kFrameFormats> closed{};

    Bytes& bytes(FrameFormat format, FrameLayer layer = FrameLayer::radiance) {
      return encoded[static_cast<std::size_t>(layer)][static_cast<std::size_t>(format)];
    }
  };
  std::shared_ptr<Frame> find(std::uint32_t revision) const;

  mutable std::atomic<bool> asked_ = false;
  mutable std::mutex mutex_;
  std::vector<std::shared_ptr<Frame>> frames_;
};

/// A picture, or a layer of its error, from its EXR. Errors: not_found where that has no such layer; those of decoder and
/// encoder.
Result<Frames::Bytes> picture_from_exr(const std::vector<std::byte>& exr, FrameLayer layer, FrameFormat format);

}  // namespace photond
