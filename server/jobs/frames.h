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

namespace photond {

enum class FrameFormat : std::uint8_t { png, jpg, exr };

/// The newest few pictures of one job. Each is encoded when first asked for, once per format, and shared.
class Frames {
 public:
  using Bytes = std::shared_ptr<const std::vector<std::byte>>;

  /// Adds a picture; the oldest beyond three, or beyond two with the result of a job, are dropped. With `error` it is
  /// the result, which is encoded as 32-bit EXR with the error layers, earlier pictures as 16-bit.
  void publish(std::uint32_t revision, Image image, std::optional<ErrorLayers> error);
  /// Errors: not_found (never published, or no longer kept), or the encoder's own.
  Result<Bytes> get(std::uint32_t revision, FrameFormat format) const;
  /// What the kept pictures take, without their encodings.
  std::uint64_t memory_bytes() const;

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
