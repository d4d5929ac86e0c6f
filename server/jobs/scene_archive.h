#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/scene/gltf.h"

namespace photond {

/// What an archive may unpack to before it is refused.
struct ArchiveLimits {
  std::uint64_t max_entries = 4'096;
  std::uint64_t max_bytes = 1ull << 30;  ///< all entries together, unpacked; also all that a reader gives out
  std::uint64_t max_ratio = 200;         ///< unpacked over packed; above 1 MiB unpacked only
};

/// An unpacked zip: exactly one .gltf or .glb and what it refers to.
struct SceneArchive {
  std::map<std::string, std::vector<std::byte>> files;  ///< by path inside the archive
  std::string root;                                     ///< path of the .gltf or .glb
  std::uint64_t max_bytes = ArchiveLimits{}.max_bytes;  ///< that one reader gives out

  const std::vector<std::byte>& root_bytes() const { return files.at(root); }
  /// Reads resources beside the root file, from this archive only: a file counts each time it is read. Refers to this
  /// object. Errors: not_found, limit_exceeded.
  ResourceReader reader() const;
};

/// Unpacks in memory. Errors: invalid_input (no zip, no or several glTF files, encrypted, names that leave the
/// archive), limit_exceeded.
Result<SceneArchive> read_archive(std::span<const std::byte> zip, const ArchiveLimits& limits = {});

}  // namespace photond
