#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace photond::gltf {

/// True where photond reads the extension.
bool is_supported_extension(std::string_view name);

/// An ErrorCode::unsupported naming the first extension that the file requires and photond does not read.
Status check_required_extensions(const std::vector<std::string>& required);

}  // namespace photond::gltf
