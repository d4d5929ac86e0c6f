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

int check_outputs(const std::vector<std::string>& outputs, const std::string& report) {
  for (const std::string& output : outputs) {
    if (!format_of(output)) return print_usage_error(output + ": a picture's name ends in .exr, .png or .jpg");
  }
  std::vector<std::string> files = outputs;
  if (!report.empty()) files.push_back(report);
  for (const std::string& file : files) {
    if (const auto writable = check_writable(file); !writable) return print_failure(file, writable.error());
  }
  return kExitOk;
}

Result<Image> read_picture(const std::filesystem::path& file) {
  constexpr std::uint64_t kMaxBytes = 4ull << 30;  // 16384² pixels of three floats are 3 GiB
  const auto bytes = read_file(file, kMaxBytes);
  if (!bytes) return bytes.error();
  return decode_exr(*bytes);
}

}  // namespace photond
