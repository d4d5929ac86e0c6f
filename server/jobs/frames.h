#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "core/base/result.h"
#include "core/film/encode.h"
#include "core/film/error.h"
#include "core/film/image.h"
#include "server/store/records.h"

namespace photond {

/// The newest few pictures of one job that runs. Each is encoded when first asked for, once per format, and shared.
/// Once a job rests, its newest picture is on the disk (JobFiles) and these are dropped.
class Frames {
 public:
  using Bytes = std::shared_ptr<const std::vector<std::byte>>;

  /// Adds a picture; the oldest beyond three, or beyond two with the result of a job, are dropped. With `error` it is
  /// the result, which is encoded as 32-bit EXR with the error layers, earlier pictures as 16-bit.
  void publish(std::uint32_t revision, Image image, std::optional<ErrorLayers> error);
  /// Errors: not_found (never published, or no longer kept), or the encoder's own.
  Result<Bytes> get(std::uint32_t revision, FrameFormat format) const;
  void clear();

 private:
  struct Frame {
    std::uint32_t revision = 0;
    Image image;
    std::optional<ErrorLayers> error;  ///< of the result
    std::mutex encoding;           ///< one encoder per picture at a time
    std::array<Bytes, 3> encoded;  ///< by FrameFormat
  };
  std::shared_ptr<Frame> find(std::uint32_t revision) const;

  mutable std::mutex mutex_;
  std::vector<std::shared_ptr<Frame>> frames_;
};

}  // namespace photond
