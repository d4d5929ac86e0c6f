#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace photond::gltf {

/// Values the scan hands back, because they decide whether the file may be loaded at all.
enum class Role : std::uint8_t {
  none,
  buffer,
  buffer_uri,
  buffer_length,
  buffer_fallback,
  node,
  extension_required,
  draco,
  meshopt
};

struct Schema;

/// A named member of an object.
struct Field {
  std::string_view name;
  const Schema* schema;
  bool required = false;
};

/// What a JSON value must look like. Members that an object's `fields` do not name follow `others`.
struct Schema {
  enum class Kind : std::uint8_t { any, boolean, integer, number, string, array, object };

  Kind kind = Kind::any;
  Role role = Role::none;
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  /// number: tinygltf keeps integers inside extensions in 32 bits, so larger ones are refused.
  bool narrow_integers = false;
  const Schema* items = nullptr;  ///< array: every element; null: any
  std::size_t min_items = 0;
  std::size_t max_items = std::numeric_limits<std::size_t>::max();
  std::span<const Field> fields;   ///< object
  const Schema* others = nullptr;  ///< object: members not in `fields`; null: any
};

struct BufferDeclaration {
  std::string uri;
  std::uint64_t byte_length = 0;
  bool fallback = false;  ///< of EXT_meshopt_compression: for readers without that
};

/// What the scan found on its way.
struct JsonScan {
  std::vector<BufferDeclaration> buffers;
  std::vector<std::string> extensions_required;
  std::uint64_t nodes = 0;
  bool draco = false;    ///< a primitive is compressed by KHR_draco_mesh_compression
  bool meshopt = false;  ///< a buffer view is compressed by EXT_meshopt_compression
  std::map<std::string, std::size_t, std::less<>> counts;  ///< elements of each array at the top
};

struct JsonLimits {
  int max_depth = 128;
  std::uint64_t max_nodes = 1'000'000;
  /// Objects, and members whose names are free (attributes): each may cost the parser more than 1 kB.
  std::uint64_t max_objects = 3'000'000;
  /// Values that the schema does not describe cost the parser about 150 bytes each.
  std::uint64_t max_loose_values = 2'000'000;
};

/// Checks without building anything that `text` is one strict JSON value (RFC 8259, UTF-8 without byte order
/// mark, no repeated keys, finite numbers, nothing behind it) of the given shape. `where` of an error is the
/// path of the value ("nodes[3].mesh").
Result<JsonScan> scan_json(std::string_view text, const Schema& schema, const JsonLimits& limits);

}  // namespace photond::gltf
