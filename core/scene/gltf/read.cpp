#include <exception>

#include "core/scene/gltf.h"
#include "core/scene/gltf/build.h"
#include "core/scene/gltf/check.h"
#include "core/scene/gltf/parse.h"

namespace photond {
namespace {

/// The largest coordinate of anything in the world must still have a finite square.
Status check_extent(const Scene& scene) {
  const Bounds3 bounds = world_bounds(scene);
  const float largest = std::max(max_component(glm::abs(bounds.min)), max_component(glm::abs(bounds.max)));
  if (largest <= gltf::kMaxMagnitude) return Done{};
  return invalid_input("the scene is absurdly large", "nodes");
}

Result<Scene> build_scene(const gltf::Parsed& parsed, const ResourceReader& resources,
                          const SceneLimits& limits) {
  gltf::Build build{parsed.model, resources, limits};
  if (Status s = gltf::build_materials(build); !s) return s.error();
  if (Status s = gltf::build_nodes(build); !s) return s.error();
  if (build.scene.instances.empty()) return invalid_input("the scene contains no triangles", "scenes");
  if (Status s = check_extent(build.scene); !s) return s.error();
  gltf::warn_of_ignored(build);
  gltf::warn_of_far_scene(build);
  gltf::add_defaults(build);
  build.scene.warnings = build.warnings.lines();
  return std::move(build.scene);
}

}  // namespace

ResourceReader no_resources() {
  return [](const std::string& path) -> Result<std::vector<std::byte>> {
    return invalid_input("the file refers to another file, \"" + path.substr(0, 120) + "\"");
  };
}

Result<Scene> read_gltf(std::span<const std::byte> bytes, const ResourceReader& resources,
                        const SceneLimits& limits) {
  const Result<gltf::Parsed> parsed = gltf::parse_model(bytes, resources, limits);
  if (!parsed) return parsed.error();
  if (Status s = gltf::check_model(parsed->model, limits); !s) return s.error();
  try {
    return build_scene(*parsed, resources, limits);
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::limit_exceeded, "the file needs more memory than there is", {}};
  }
}

}  // namespace photond
