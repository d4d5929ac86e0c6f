#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace photond::test {

/// The bytes of a text.
std::vector<std::byte> bytes_of(std::string_view text);

/// A GLB of the given JSON and BIN chunk (omitted where empty).
std::vector<std::byte> make_glb(const nlohmann::json& document, const std::string& bin = {});

/// Appends the raw bytes of `values` to `bin`, aligned to 4, and returns their offset.
template <class T>
std::size_t put(std::string& bin, const std::vector<T>& values) {
  bin.resize((bin.size() + 3) / 4 * 4, '\0');
  const std::size_t offset = bin.size();
  bin.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  return offset;
}

/// A file that a test changes before it is packed. It starts as one triangle (0,0,0), (1,0,0), (0,1,0) on one
/// node: accessor 0 holds the positions. Buffer 0 is the BIN chunk; a test may add others.
struct GlbDraft {
  nlohmann::json json;
  std::string bin;

  GlbDraft();
  /// Adds data as buffer view and accessor and returns the accessor's index.
  template <class T>
  int add_accessor(const std::vector<T>& values, int component_type, const std::string& type, int width) {
    const std::size_t offset = put(bin, values);
    json["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", values.size() * sizeof(T)}});
    json["accessors"].push_back({{"bufferView", json["bufferViews"].size() - 1},
                                 {"componentType", component_type},
                                 {"count", values.size() / static_cast<std::size_t>(width)},
                                 {"type", type}});
    return static_cast<int>(json["accessors"].size()) - 1;
  }
  std::vector<std::byte> pack() const;
};

}  // namespace photond::test
