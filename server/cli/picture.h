#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/film/encode.h"

namespace photond {

/// The format a file's name asks for: .exr (float), .png, .jpg or .jpeg, in any case.
std::optional<ImageFormat> format_of(const std::filesystem::path& file);

/// Writes the film's mean in the format that the file's name asks for and must have; EXR with the error layers
/// beside it, and a `note` as its description. Errors: io, and those of encode.
Status write_picture(const std::filesystem::path& file, const Film& film, const std::string& note);

/// Refuses what write_picture cannot write to: usage errors where a name has no format, failures where a file cannot
/// be written. `report` may be empty. Prints the error and returns the exit code.
int check_outputs(const std::vector<std::string>& outputs, const std::string& report);

/// Reads an EXR picture.
Result<Image> read_picture(const std::filesystem::path& file);

}  // namespace photond
