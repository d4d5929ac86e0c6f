#include "core/scene/gltf/parse.h"

#include <exception>
#include <optional>
#include <type_traits>

#include "core/base/trial.h"
#include "core/scene/gltf/check.h"
#include "core/scene/gltf/decompress.h"
#include "core/scene/gltf/extensions.h"
#include "core/scene/gltf/json_scan.h"
#include "core/scene/gltf/plain_json.h"
#include "core/scene/gltf/schema.h"
#include "core/scene/gltf/uri.h"

namespace photond::gltf {
namespace {

/// What tinygltf's callbacks need: which buffer it is at, and where to ask.
struct LoadState {
  const tinygltf::Model& model;
  const Container& container;
  const JsonScan& scan;
  const ResourceReader& resources;
  std::optional<Error> error;

  /// tinygltf reads all buffers first; external images are read later, by us, when something uses them.
  bool at_buffers() const { return model.buffers.size() < scan.buffers.size(); }
};

Result<std::vector<std::byte>> buffer_bytes(const std::string& uri, const ResourceReader& resources,
                                            const std::string& where) {
  if (is_data_uri(uri)) {
    if (!uri.starts_with("data:application/octet-stream;") &&
        !uri.starts_with("data:application/gltf-buffer;")) {
      return invalid_input("media type of the data URI is not that of a buffer", where);
    }
    return decode_data_uri(uri, where);
  }
  const Result<std::string> decoded = percent_decode(uri, where);
  if (!decoded) return decoded.error();
  const Result<std::string> path = check_relative_path(*decoded, where);
  if (!path) return path.error();
  Result<std::vector<std::byte>> bytes = resources(*path);
  return bytes ? std::move(bytes) : Error{bytes.error().code, bytes.error().message, where};
}

/// Answers tinygltf's wish for the file of the buffer it is at. The URI is taken from the scan, as the file has
/// it, and not from tinygltf, which has decoded it in its own way. A buffer without a URI is the BIN chunk.
bool read_buffer(std::vector<unsigned char>* out, LoadState& state) {
  const std::size_t index = state.model.buffers.size();
  const BufferDeclaration& wanted = state.scan.buffers[index];
  if (wanted.uri.empty()) {
    const auto* first = reinterpret_cast<const unsigned char*>(state.container.bin.data());
    out->assign(first, first + wanted.byte_length);
    return true;
  }
  const Result<std::vector<std::byte>> bytes =
      buffer_bytes(wanted.uri, state.resources, place("buffers", index) + ".uri");
  if (!bytes) {
    state.error = bytes.error();
  } else if (bytes->size() < wanted.byte_length) {
    state.error = invalid_input("the resource is shorter than byteLength", place("buffers", index));
  } else {
    const auto* first = reinterpret_cast<const unsigned char*>(bytes->data());
    out->assign(first, first + wanted.byte_length);
  }
  return !state.error;
}

/// From 2.9 on tinygltf asks for a file's size, too.
template <class Callbacks>
void set_size_callback(Callbacks& callbacks) {
  if constexpr (requires { callbacks.GetFileSizeInBytes; }) {
    callbacks.GetFileSizeInBytes = [](std::size_t* size, std::string*, const std::string&, void* user) {
      const LoadState& state = *static_cast<LoadState*>(user);
      *size = state.scan.buffers[state.model.buffers.size()].byte_length;
      return true;
    };
  }
}

tinygltf::FsCallbacks file_callbacks(LoadState& state) {
  tinygltf::FsCallbacks callbacks{};
  callbacks.user_data = &state;
  callbacks.FileExists = [](const std::string&, void* user) {
    return static_cast<LoadState*>(user)->at_buffers();
  };
  callbacks.ExpandFilePath = [](const std::string& path, void*) { return path; };
  callbacks.ReadWholeFile = [](std::vector<unsigned char>* out, std::string*, const std::string&, void* user) {
    return read_buffer(out, *static_cast<LoadState*>(user));
  };
  callbacks.WriteWholeFile = [](std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
    return false;
  };
  set_size_callback(callbacks);
  return callbacks;
}

/// False where tinygltf does not take the callbacks and would look at the disk itself; 2.7 takes all.
template <class Loader>
bool set_callbacks(Loader& loader, LoadState& state) {
  if constexpr (std::is_void_v<decltype(loader.SetFsCallbacks(file_callbacks(state)))>) {
    loader.SetFsCallbacks(file_callbacks(state));
    return true;
  } else {
    return loader.SetFsCallbacks(file_callbacks(state));
  }
}

/// Keeps the encoded bytes of a data URI. The bytes of a buffer view are not looked at here: their range has
/// not been checked yet.
bool keep_encoded(tinygltf::Image* image, int, std::string*, std::string*, int, int, const unsigned char* bytes,
                  int size, void*) {
  if (image->bufferView < 0) image->image.assign(bytes, bytes + size);
  return true;
}

Status check_buffers(const JsonScan& scan, const Container& container) {
  for (std::size_t i = 0; i < scan.buffers.size(); ++i) {
    const std::string where = place("buffers", i);
    if (!scan.buffers[i].uri.empty() || is_placeholder(scan, i, container.binary)) continue;
    if (!container.binary) return invalid_input("buffer has no uri", where);
    // Only the first buffer may stand for the BIN chunk; tinygltf would copy it for every one.
    if (i > 0) return invalid_input("only the first buffer of a GLB may lack a uri", where);
    if (scan.buffers[i].byte_length > container.bin.size()) {
      return invalid_input("byteLength exceeds the BIN chunk", where);
    }
  }
  return Done{};
}

/// The indices that tinygltf refuses a file for once it has loaded the meshes: those whose accessor has no buffer view.
std::optional<Error> indices_without_data(const tinygltf::Model& model) {
  for (std::size_t m = 0; m < model.meshes.size(); ++m) {
    for (std::size_t p = 0; p < model.meshes[m].primitives.size(); ++p) {
      const tinygltf::Primitive& primitive = model.meshes[m].primitives[p];
      if (primitive.indices < 0) continue;
      const std::string where = place("meshes", m) + "." + place("primitives", p);
      if (Status s = check_index(primitive.indices, model.accessors.size(), where + ".indices"); !s) return s.error();
      const int view = model.accessors[primitive.indices].bufferView;
      if (view >= 0 && static_cast<std::size_t>(view) < model.bufferViews.size()) continue;
      return invalid_input("the accessor has no buffer view that exists", where + ".indices");
    }
  }
  return std::nullopt;
}

/// Where tinygltf gave up: the first element it did not load, in its order of reading; the lights come last, after all
/// extensions.
std::string failing_place(const tinygltf::Model& model, const JsonScan& scan) {
  if (!model.extensions.empty()) return "extensions.KHR_lights_punctual." + place("lights", model.lights.size());
  const auto declared = [&scan](std::string_view section) {
    const auto found = scan.counts.find(section);
    return found != scan.counts.end() ? found->second : 0;
  };
  const std::pair<std::string_view, std::size_t> sections[] = {
      {"buffers", model.buffers.size()},       {"bufferViews", model.bufferViews.size()},
      {"accessors", model.accessors.size()},   {"meshes", model.meshes.size()},
      {"nodes", model.nodes.size()},           {"materials", model.materials.size()},
      {"images", model.images.size()},         {"textures", model.textures.size()},
      {"animations", model.animations.size()}, {"skins", model.skins.size()},
      {"samplers", model.samplers.size()},     {"cameras", model.cameras.size()}};
  for (const auto& [section, loaded] : sections) {
    if (loaded < declared(section)) return place(section, loaded);
  }
  return {};
}

Status run_tinygltf(std::span<const std::byte> bytes, const Container& container, LoadState& state,
                    tinygltf::Model& model) {
  tinygltf::TinyGLTF loader;
  if (!set_callbacks(loader, state)) return Error{ErrorCode::internal, "tinygltf refuses its callbacks", {}};
  loader.SetImageLoader(keep_encoded, nullptr);
  std::string error, warning;
  const bool compressed = state.scan.draco || state.scan.meshopt;
  const std::string plain = compressed ? plain_json(container, state.scan) : "";
  const std::string_view json = compressed ? plain : container.json;
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  const bool loaded =
      container.binary && !compressed
          ? loader.LoadBinaryFromMemory(&model, &error, &warning, data, static_cast<unsigned>(bytes.size()))
          : loader.LoadASCIIFromString(&model, &error, &warning, json.data(), static_cast<unsigned>(json.size()), "");
  if (loaded) return Done{};
  if (state.error) return *state.error;
  if (const auto missing = indices_without_data(model)) return *missing;
  while (!error.empty() && (error.back() == '\n' || error.back() == '.')) error.pop_back();
  if (error.size() > 300) error.resize(300);
  return invalid_input(error.empty() ? "cannot be parsed" : error, failing_place(model, state.scan));
}

/// Makes ordinary data of compressed data.
Status decompress(tinygltf::Model& model, const JsonScan& scan, const Container& container, const SceneLimits& limits) {
  DecompressionBudget budget{limits.max_decompressed_bytes};
  for (std::size_t i = 0; i < scan.buffers.size(); ++i) {
    if (is_placeholder(scan, i, container.binary)) model.buffers[i].data.clear();
  }
  if (scan.meshopt) {
    if (Status s = decompress_views(model, scan.buffers, budget); !s) return s;
  }
  if (!scan.draco) return Done{};
  if (Status s = check_model(model, limits); !s) return s;
  // Streams can be made for which Draco takes the square of their length, or seconds for two hundred bytes.
  const auto trial = [&model, budget]() mutable { (void)decompress_primitives(model, budget); };
  if (!ends_within(limits.max_decompression_seconds, trial)) {
    return Error{ErrorCode::limit_exceeded, "decompression fails or takes too long", "meshes"};
  }
  return decompress_primitives(model, budget);
}

}  // namespace

Result<Parsed> parse_model(std::span<const std::byte> bytes, const ResourceReader& resources,
                           const SceneLimits& limits) {
  const Result<Container> container = open_container(bytes);
  if (!container) return container.error();
  const JsonLimits json_limits{
      .max_depth = limits.max_json_depth, .max_nodes = limits.max_nodes, .max_objects = limits.max_json_objects};
  const Result<JsonScan> scan = scan_json(container->json, gltf_schema(), json_limits);
  if (!scan) return scan.error();
  const auto materials = scan->counts.find("materials");
  if (materials != scan->counts.end() && materials->second > limits.max_materials)
    return Error{ErrorCode::limit_exceeded, "the file has too many materials", "materials"};
  if (Status status = check_required_extensions(scan->extensions_required); !status) return status.error();
  if (Status status = check_buffers(*scan, *container); !status) return status.error();

  Parsed parsed{.binary = container->binary};
  LoadState state{parsed.model, *container, *scan, resources, {}};
  try {
    if (Status status = run_tinygltf(bytes, *container, state, parsed.model); !status) return status.error();
    if (Status status = decompress(parsed.model, *scan, *container, limits); !status) return status.error();
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::limit_exceeded, "the file needs more memory than there is", {}};
  } catch (const std::exception& exception) {
    return invalid_input(std::string("the file cannot be parsed: ") + exception.what());
  }
  return parsed;
}

}  // namespace photond::gltf
