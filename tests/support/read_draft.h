#pragma once

#include <gtest/gtest.h>

#include <utility>

#include "core/scene/gltf.h"
#include "tests/support/glb.h"

namespace photond::test {

/// The scene of a file that must be read.
inline Scene read(const GlbDraft& draft) {
  Result<Scene> scene = read_gltf(draft.pack(), no_resources());
  EXPECT_TRUE(scene.ok()) << scene.error().where << ": " << scene.error().message;
  return scene ? std::move(*scene) : Scene{};
}

/// Why a file is refused that must be.
inline Error refusal(const GlbDraft& draft, const SceneLimits& limits = {}) {
  const Result<Scene> scene = read_gltf(draft.pack(), no_resources(), limits);
  EXPECT_FALSE(scene.ok());
  return scene ? Error{} : scene.error();
}

/// The first primitive of the first mesh.
inline nlohmann::json& primitive(GlbDraft& draft) { return draft.json["meshes"][0]["primitives"][0]; }

}  // namespace photond::test
