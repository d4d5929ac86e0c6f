#pragma once

#include <tiny_gltf.h>

#include <string>
#include <vector>

namespace photond::gltf {

/// The object of an extension, or null where it is absent.
const tinygltf::Value* extension(const tinygltf::ExtensionMap& extensions, const char* name);

/// Members of a JSON object whose types the schema has checked; `object` may be null. The default stands for an
/// absent member.
double number(const tinygltf::Value* object, const char* member, double otherwise);
std::string text(const tinygltf::Value* object, const char* member, std::string otherwise);
std::vector<double> numbers(const tinygltf::Value* object, const char* member, std::vector<double> otherwise);

/// A member that is itself an object, or null.
const tinygltf::Value* member(const tinygltf::Value* object, const char* name);

}  // namespace photond::gltf
