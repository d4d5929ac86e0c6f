#pragma once

#include <vector>

#include "core/scene/scene.h"
#include "core/trace/aim.h"

namespace photond {

/// Lowest roughness where the material is metal to `metallic` or more, by its texture's texels where it has one (a million
/// of them); infinite where it nowhere is.
float lowest_roughness(const Scene& scene, const Material& material, float metallic);

/// Whether a surface of the material can bundle light by itself: glass, or metal too polished for photons to be
/// gathered on it. Coats do not count: what they reflect is a small share everywhere.
bool bundles_light(const Scene& scene, const Material& material);

/// Whether what the surface throws on others may be a caustic: it transmits, or is a metal with a narrow highlight.
bool casts_caustics(const Scene& scene, const Material& material);

/// Whether the surface mirrors a little, by a smooth coat or as metal by a part: paths never find points by way of it.
bool mirrors_points(const Scene& scene, const Material& material);

/// Whether it transmits through facets, at least in part.
bool frosts(const Material& material);

/// Whether light that it transmits, or reflects as a metal, may go on in one direction.
bool mirrors(const Scene& scene, const Material& material);

/// Whether the scene has glass, or a mirror, and beside it gloss: paths from there find light by way of it too seldom,
/// and that of points never.
bool lights_gloss(const Scene& scene);

/// Whether the environment is so uneven that such surfaces make caustics of it that paths find too seldom.
bool environment_casts(const Scene& scene);

/// Balls around all triangles of such materials, at most `most`, small where they lie apart. The scene is prepared.
std::vector<Ball> caster_balls(const Scene& scene, std::size_t most);

}  // namespace photond
