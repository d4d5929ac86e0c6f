#include "core/scene/gltf/parse.h"

#include <exception>
#include <optional>

#include "core/scene/gltf/check.h"
#include "core/scene/gltf/extensions.h"
#include "core/scene/gltf/json_scan.h"
#include "core/scene/gltf/schema.h"
#include "core/scene/gltf/uri.h"

namespace photond::gltf {
namespace {


/// What tinygltf's callbacks need: which buffer it is at, and where to ask.
struct LoadState {
  const tinygltf::Model& model;
  const std::vector<BufferDeclaration>& buffers;
  const ResourceReader& resources;
  std::optional<Error> error;

  /// tinygltf reads all buffers first; external images are read later, by us, when something uses them.
  bool at_buffers() const { return model.buffers.size() < buffers.size(); }
};

bool read_buffer(std::vector<unsigned char>* out, const std::string& path, LoadState& state) {
  const std::size_t index = state.model.buffers.size();
  const std::string where = place("buffers", index) + ".uri";
  const std::uint64_t wanted = state.buffers[index].byte_length;
  Result<std::string> clean = check_relative_path(path, where);
  if (!clean) return state.error = clean.error(), false;
  Result<std::vector<std::byte>> bytes = state.resources(*clean);
  if (!bytes) {
    state.error = Error{bytes.error().code, bytes.error().message, where};
    return false;
  }
  if (bytes->size() < wanted) {
    state.error = invalid_input("the resource is shorter than byteLength", place("buffers", index));
    return false;
  }
  const auto* first = reinterpret_cast<const unsigned char*>(bytes->data());
  out->assign(first, first + wanted);
  return true;
}

tinygltf::FsCallbacks file_callbacks(LoadState& state) {
  tinygltf::FsCallbacks callbacks{};
  callbacks.user_data = &state;
  callbacks.FileExists = [](const std::string&, void* user) {
    return static_cast<LoadState*>(user)->at_buffers();
  };
  callbacks.ExpandFilePath = [](const std::string& path, void*) { return path; };
  callbacks.ReadWholeFile = [](std::vector<unsigned char>* out, std::string*, const std::string& path,
                               void* user) { return read_buffer(out, path, *static_cast<LoadState*>(user)); };
  callbacks.WriteWholeFile = [](std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
    return false;
  };
  return callbacks;
}

/// Keeps the encoded bytes of a data URI. The bytes of a buffer view are not looked at here: their range has
/// not been checked yet.
bool keep_encoded(tinygltf::Image* image, int, std::string*, std::string*, int, int,
                  const unsigned char* bytes, int size, void*) {
  if (image->bufferView < 0) image->image.assign(bytes, bytes + size);
  return true;
}

Status check_buffers(const std::vector<BufferDeclaration>& buffers, const Container& container) {
  for (std::size_t i = 0; i < buffers.size(); ++i) {
    const std::string where = place("buffers", i);
    if (!buffers[i].uri.empty()) continue;
    if (!container.binary) return invalid_input("buffer has no uri", where);
    // Only the first buffer may stand for the BIN chunk; tinygltf would copy it for every one.
    if (i > 0) return invalid_input("only the first buffer of a GLB may lack a uri", where);
    if (buffers[i].byte_length > container.bin.size()) {
      return invalid_input("byteLength exceeds the BIN chunk", where);
    }
  }
  return Done{};
}

Status run_tinygltf(std::span<const std::byte> bytes, const Container& container, LoadState& state,
                    tinygltf::Model& model) {
  tinygltf::TinyGLTF loader;
  loader.SetFsCallbacks(file_callbacks(state));
  loader.SetImageLoader(keep_encoded, nullptr);
  std::string error, warning;
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  const auto size = static_cast<unsigned>(bytes.size());
  const bool loaded =
      container.binary
          ? loader.LoadBinaryFromMemory(&model, &error, &warning, data, size)
          : loader.LoadASCIIFromString(&model, &error, &warning, container.json.data(), size, "");
  if (loaded) return Done{};
  if (state.error) return *state.error;
  if (state.at_buffers()) error = "cannot be loaded: " + error;
  while (!error.empty() && (error.back() == '\n' || error.back() == '.')) error.pop_back();
  if (error.size() > 300) error.resize(300);
  return invalid_input(error.empty() ? "the file cannot be parsed" : error,
                       state.at_buffers() ? place("buffers", model.buffers.size()) : "");
}

}  // namespace

Result<Parsed> parse_model(std::span<const std::byte> bytes, const ResourceReader& resources,
                           const SceneLimits& limits) {
  const Result<Container> container = open_container(bytes);
  if (!container) return container.error();
  const JsonLimits json_limits{.max_depth = limits.max_json_depth, .max_nodes = limits.max_nodes};
  const Result<JsonScan> scan = scan_json(container->json, gltf_schema(), json_limits);
  if (!scan) return scan.error();
  if (Status status = check_required_extensions(scan->extensions_required); !status) return status.error();
  if (Status status = check_buffers(scan->buffers, *container); !status) return status.error();

  Parsed parsed{.binary = container->binary};
  LoadState state{parsed.model, scan->buffers, resources, {}};
  try {
    if (Status status = run_tinygltf(bytes, *container, state, parsed.model); !status) return status.error();
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::limit_exceeded, "the file needs more memory than there is", {}};
  } catch (const std::exception& exception) {
    return invalid_input(std::string("the file cannot be parsed: ") + exception.what());
  }
  return parsed;
}

}  // namespace photond::gltf
