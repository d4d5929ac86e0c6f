#include "core/scene/gltf/value.h"

namespace photond::gltf {

const tinygltf::Value* extension(const tinygltf::ExtensionMap& extensions, const char* name) {
  const auto found = extensions.find(name);
  return found != extensions.end() ? &found->second : nullptr;
}

double number(const tinygltf::Value* object, const char* name, double otherwise) {
  const tinygltf::Value* value = member(object, name);
  return value && value->IsNumber() ? value->GetNumberAsDouble() : otherwise;
}

std::string text(const tinygltf::Value* object, const char* name, std::string otherwise) {
  const tinygltf::Value* value = member(object, name);
  return value && value->IsString() ? value->Get<std::string>() : otherwise;
}

std::vector<double> numbers(const tinygltf::Value* object, const char* name, std::vector<double> otherwise) {
  const tinygltf::Value* value = member(object, name);
  if (!value || !value->IsArray()) return otherwise;
  std::vector<double> out;
  for (std::size_t i = 0; i < value->ArrayLen(); ++i) {
    out.push_back(value->Get(static_cast<int>(i)).GetNumberAsDouble());
  }
  return out;
}

const tinygltf::Value* member(const tinygltf::Value* object, const char* name) {
  return object && object->IsObject() && object->Has(name) ? &object->Get(name) : nullptr;
}

}  // namespace photond::gltf
