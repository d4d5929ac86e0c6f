#include "tests/support/scene_files.h"

#include <cstdlib>
#include <fstream>
#include <iterator>

namespace photond::test {

std::optional<std::filesystem::path> shared_scenes() {
  const char* chosen = std::getenv("PHOTOND_SCENES");
  const std::filesystem::path folder = chosen ? chosen : PHOTOND_SHARED_SCENES;
  return std::filesystem::is_directory(folder) ? std::optional(folder) : std::nullopt;
}

std::vector<std::byte> read_file(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  return {first, first + text.size()};
}

ResourceReader folder_reader(const std::filesystem::path& folder, std::vector<std::string>* asked) {
  return [folder, asked](const std::string& path) -> Result<std::vector<std::byte>> {
    if (asked) asked->push_back(path);
    if (!std::filesystem::is_regular_file(folder / path)) {
      return Error{ErrorCode::not_found, "there is no file " + path, {}};
    }
    return read_file(folder / path);
  };
}

}  // namespace photond::test
