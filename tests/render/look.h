#pragma once

#include <array>
#include <memory>
#include <vector>

#include "core/render/render.h"
#include "tests/render/hard_case.h"

namespace photond::test {

/// The methods that every case is measured with where it makes sense. A new method is entered here.
inline const std::vector<Method> kMethods = {Method::path, Method::progressive, Method::photon_map, Method::hybrid};
/// Those that find light of a point through mirrors and glass: all but the path tracer.
std::vector<Method> photon_methods();
inline constexpr std::array<std::uint64_t, 2> kSeeds = {1, 2};

/// "progressive, seed 2".
std::string run_name(Method method, std::uint64_t seed);

/// A look at one place, through a camera so narrow that all its pixels see the same, in independent passes.
struct Look {
  Vec3 from{0};
  Vec3 at{0};
  float radius = 0.1f;             ///< of the density estimate, metres
  std::uint32_t photons = 20'000;  ///< paths a pass
  int passes = 30;
  int side = 4;  ///< side² camera samples a pass
  std::uint32_t max_depth = 65'536;
};

/// The radiance seen, per channel, with its spread over the passes. Each pass has photons of its own
/// (photon_map too) and the radius of the first pass.
std::array<Sample, 3> see(const std::shared_ptr<const PreparedScene>& scene, Method method, std::uint64_t seed,
                          const Look& look);

/// Adds to `quantity` what `methods` see with every seed: `scale` times one channel of the radiance.
void look_at_with(Quantity& quantity, const std::shared_ptr<const PreparedScene>& scene, const Look& look,
                  const std::vector<Method>& methods = kMethods, double scale = 1, int channel = 0);

/// The sample of `factor` times the values.
Sample scaled(Sample sample, double factor);

/// Photon maps of one pass.
std::shared_ptr<const PhotonMaps> shoot_maps(const PreparedScene& scene, std::uint32_t photons,
                                             std::uint64_t seed, std::uint32_t pass = 0);

/// Flux of a map's photons in W, of all paths together.
double total_flux(const PhotonMap& map);

/// What paths of other seeds than the cases' measure, with its standard error.
struct Measured {
  double mean;
  double error;
};
Measured by_paths(const std::shared_ptr<const PreparedScene>& room, const Look& look);

}  // namespace photond::test
