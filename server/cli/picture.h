#pragma once

#include <filesystem>
#include <optional>

#include "core/film/encode.h"

namespace photond {

/// The format a file's name asks for: .exr (float), .png, .jpg or .jpeg, in any case.
std::optional<ImageFormat> format_of(const std::filesystem::path& file);

/// Encodes by the file's name, which must have a format, and writes it. Errors: io, and those of encode.
Status write_picture(const std::filesystem::path& file, const Image& image);

/// Reads an EXR picture.
Result<Image> read_picture(const std::filesystem::path& file);

}  // namespace photond
