#include "server/cli/picture.h"

#include <algorithm>
#include <cctype>

#include "core/film/reconstruct.h"
#include "server/cli/cli.h"
#include "server/cli/commands.h"
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

Status write_picture(const std::filesystem::path& file, const Film& film, const std::string& note) {
  const ImageFormat format = *format_of(file);
  Image mean = film_picture(film);
  mean.note = note;
  const auto bytes = format == ImageFormat::exr_float ? encode_exr(mean, error_layers(film)) : encode(mean, format);
  if (!bytes) return bytes.error();
  return write_file(file, *bytes);
}

int check_pictures(const std::vector<std::string>& pictures, const std::string& report,
                   std::vector<std::string> inputs) {
  for (const std::string& picture : pictures) {
    if (!format_of(picture)) return print_usage_error(picture + ": a picture's name ends in .exr, .png or .jpg");
  }
  std::vector<std::string> outputs = pictures;
  if (!report.empty()) outputs.push_back(report);
  std::erase(inputs, "");
  return print_refusal(check_outputs(outputs, inputs));
}

Result<Image> read_picture(const std::filesystem::path& file) {
  constexpr std::uint64_t kMaxBytes = 16ull << 30;  // 16384² pixels of twelve floats are 12 GiB
  const auto bytes = read_file(file, kMaxBytes);
  if (!bytes) return bytes.error();
  return decode_exr(*bytes);
}

}  // namespace photond
