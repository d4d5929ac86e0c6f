#pragma once

#include "core/scene/gltf/json_scan.h"

namespace photond::gltf {

/// The shape of a glTF 2.0 file as far as photond reads it: types, required members and plain ranges, so that
/// the parser cannot take a default where the file said something else. References are checked later.
const Schema& gltf_schema();

}  // namespace photond::gltf
