#include "server/cli/picture.h"

#include <algorithm>
#include <cctype>

#include "server/cli/files.h"

namespace photond {

std::optional<ImageFormat> format_of(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".exr") return ImageFormat::exr_float;
  if (extension == ".png") return ImageFormat::png;
  if (extension == ".jpg" || extension == ".jpeg") return ImageFormat::jpeg;
  return std::nullopt;
}

Status write_picture(const std::filesystem::path& file, const Image& image) {
  const auto bytes = encode(image, *format_of(file));
  if (!bytes) return bytes.error();
  return write_file(file, *bytes);
}

Result<Image> read_picture(const std::filesystem::path& file) {
  constexpr std::uint64_t kMaxBytes = 4ull << 30;  // 16384² pixels of three floats are 3 GiB
  const auto bytes = read_file(file, kMaxBytes);
  if (!bytes) return bytes.error();
  return decode_exr(*bytes);
}

}  // namespace photond
