// What tracing photons costs beside intersecting their rays, and what a map costs to index and to query.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "core/photon/nearest.h"
#include "core/photon/shoot.h"
#include "tests/bench/bench.h"

namespace photond::bench {
namespace {

constexpr std::uint64_t kBlock = 2048;

struct Row {
  std::vector<double> shoot, bare, ratio, index, query;
  std::uint64_t rays = 0;
  std::uint32_t photons = 0;
  double bytes_per_photon = 0;
};

// The paths of a pass, block by block.
template <class Body>
void for_blocks(const PreparedScene& scene, const MapKey& key, const Execution& execution, const Body& body) {
  const std::uint64_t paths = paths_of_pass(scene, key.settings);
  parallel_for(execution, (paths + kBlock - 1) / kBlock, 1,
               [&](std::size_t i) { body(i, i * kBlock, std::min(paths, (i + 1) * kBlock)); });
}

// Their rays.
std::vector<std::vector<Ray>> record(const PreparedScene& scene, const MapKey& key, const Execution& execution) {
  std::vector<std::vector<Ray>> rays((paths_of_pass(scene, key.settings) + kBlock - 1) / kBlock);
  for_blocks(scene, key, execution, [&](std::size_t block, std::uint64_t first, std::uint64_t last) {
    shoot(scene, key, first, last, &rays[block]);
  });
  return rays;
}

double bare_intersection(const Accel& accel, const std::vector<std::vector<Ray>>& rays,
                         const Execution& execution) {
  std::vector<float> sums(rays.size(), 0);  // keeps the compiler from dropping the work
  const double time = seconds([&] {
    parallel_for(execution, rays.size(), 1, [&](std::size_t i) {
      for (const Ray& ray : rays[i]) sums[i] += accel.intersect(ray).u;
    });
  });
  return std::isfinite(sums[0]) ? time : 0;
}

double shooting(const PreparedScene& scene, const MapKey& key, const Execution& execution) {
  return seconds([&] {
    for_blocks(scene, key, execution,
               [&](std::size_t, std::uint64_t first, std::uint64_t last) { shoot(scene, key, first, last); });
  });
}

// Fixed-radius visits of about thirty photons each around photons of the map, per second.
double queries_per_second(const PhotonMaps& maps, const Execution& execution) {
  const PhotonMap& map = maps.global.size() > maps.caustic.size() ? maps.global : maps.caustic;
  if (map.size() < 100) return 0;
  constexpr std::size_t kQueries = 50'000;
  std::vector<float> sums(kQueries, 0);
  const double time = seconds([&] {
    parallel_for(execution, kQueries, 256, [&](std::size_t i) {
      const Vec3 center = map.position(static_cast<std::uint32_t>(mix64(i) % map.size()));
      const float radius_sq = nearest_radius_sq(map, center, 30, kInfinity);
      map.tree().query(center, radius_sq, [&](std::span<const std::uint32_t> leaves) {
        for (const std::uint32_t leaf : leaves) sums[i] += map.leaf(leaf).distances_sq(center)[0];
      });
    });
  });
  return kQueries / time;
}

Row measure(const PreparedScene& scene, std::uint32_t photons, int rounds, const Execution& execution) {
  MapKey key{scene.digest, {}, 0};
  key.settings.photons_per_pass = photons;
  const auto rays = record(scene, key, execution);
  const Result<Accel> tree = Accel::build(scene.scene, {});   // one for all triangles
  Row row;
  for (const auto& block : rays) row.rays += block.size();
  for (int round = 0; round < rounds; ++round) {
    // Interleaved, so that a noisy neighbour hits both.
    const double bare = bare_intersection(*tree, rays, execution);
    const double shot = shooting(scene, key, execution);
    const double built = seconds([&] { (void)build_photon_maps(scene, key, execution); });
    row.bare.push_back(static_cast<double>(row.rays) / bare / 1e6);
    row.shoot.push_back(static_cast<double>(row.rays) / shot / 1e6);
    row.ratio.push_back(bare / shot);
    row.index.push_back(std::max(0.0, built - shot) / shot);
  }
  const auto maps = build_photon_maps(scene, key, execution);
  row.photons = (*maps)->global.size() + (*maps)->caustic.size();
  row.bytes_per_photon = static_cast<double>((*maps)->memory_bytes) / std::max(1u, row.photons);
  for (int round = 0; round < rounds; ++round) row.query.push_back(queries_per_second(**maps, execution) / 1e6);
  return row;
}

}  // namespace
}  // namespace photond::bench

int main(int argc, char** argv) {
  using namespace photond;
  using namespace photond::bench;
  CLI::App app{"Photon tracing against bare rtcIntersect1 on the rays of the same run (medians of interleaved rounds)"};
  std::vector<std::string> scenes;
  std::uint32_t photons = 262'144;
  int rounds = 7;
  int threads = 0;
  app.add_option("scenes", scenes, "GLB files; default: the samples");
  app.add_option("--photons", photons, "photons_per_pass of a round")->check(CLI::Range(2048, 100'000'000));
  app.add_option("--rounds", rounds)->check(CLI::Range(1, 1000));
  app.add_option("--threads", threads)->check(CLI::Range(0, 1024));
  CLI11_PARSE(app, argc, argv);
  std::vector<std::filesystem::path> paths(scenes.begin(), scenes.end());
  if (paths.empty()) paths = samples();

  const Workers workers(threads);
  std::printf("%-18s %10s %10s %7s %10s %9s %8s %8s\n", "scene", "shoot", "bare", "ratio", "index/", "gather", "photons",
              "bytes/");
  std::printf("%-18s %10s %10s %7s %10s %9s %8s %8s\n", "", "Mrays/s", "Mrays/s", "", "shoot", "Mquery/s", "stored",
              "photon");
  for (const auto& path : paths) {
    const auto scene = load(path, workers.execution());
    if (!scene) {
      std::fprintf(stderr, "%s: %s\n", path.c_str(), scene.error().message.c_str());
      return 1;
    }
    const Row row = measure(**scene, photons, rounds, workers.execution());
    std::printf("%-18s %10.2f %10.2f %7.2f %10.2f %9.2f %8u %8.1f\n", path.stem().c_str(), median(row.shoot),
                median(row.bare), median(row.ratio), median(row.index), median(row.query), row.photons,
                row.bytes_per_photon);
  }
  return 0;
}
