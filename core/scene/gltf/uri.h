#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace photond::gltf {

/// True where `uri` carries its data itself.
bool is_data_uri(std::string_view uri);

/// The bytes of `data:[media type];base64,…`.
Result<std::vector<std::byte>> decode_data_uri(std::string_view uri, const std::string& where);

/// Percent-decodes once. An incomplete escape is an error.
Result<std::string> percent_decode(std::string_view uri, const std::string& where);

/// `path` without segments that are `.`, where it is a plain relative path: no scheme, no leading slash, no backslash,
/// no `..` or empty segment, no control characters; an error otherwise.
Result<std::string> check_relative_path(std::string_view path, const std::string& where);

}  // namespace photond::gltf
