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

/// Refuses pictures that write_picture cannot write to and whatever check_outputs refuses: a usage error where a name
/// has no format, or is named twice or among `inputs`, a failure where a file cannot be written. Names may be empty:
/// none. Prints the error and returns the exit code.
int check_pictures(const std::vector<std::string>& pictures, const std::string& report, std::vector<std::string> inputs);

/// Reads an EXR picture.
Result<Image> read_picture(const std::filesystem::path& file);

}  // namespace photond
