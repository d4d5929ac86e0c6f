// The photon map's index beside a kd-tree, a sorted grid and an implicit octree: for each kind of query on the maps of a
// scene, at the points its camera sees, pixel by pixel.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "core/photon/nearest.h"
#include "core/photon/photon_maps.h"
#include "tests/bench/bench.h"
#include "tests/bench/point_indices.h"

namespace photond::bench {
namespace {

// The core's index behind the others' interface. Its building includes what the others leave out: normals, directions
// and packed fluxes in the index's order.
class MapIndex {
 public:
  MapIndex(std::span<const Photon> photons, const Execution& execution) : map_(photons, execution) {}
  std::uint64_t memory_bytes() const { return map_.tree().memory_bytes() + 12ull * map_.size(); }
  void query(const Vec3& center, float radius_sq, const auto& visit) const {
    map_.tree().query(center, radius_sq, [&](std::span<const std::uint32_t> leaves) {
      for (const std::uint32_t leaf : leaves) visit(map_.leaf(leaf).distances_sq(center), radius_sq);
    });
  }
  float nearest_radius_sq(const Vec3& center, std::uint32_t k) const {
    return photond::nearest_radius_sq(map_, center, k, kInfinity);
  }

 private:
  PhotonMap map_;
};

struct Query {
  Vec3 center;
  float radius_sq;
};

// Of each sort of queries; `k` where the radius is what is asked for.
struct Workload {
  const char* name;
  std::vector<Query> queries;
  std::uint32_t k = 0;
};

struct Row {
  const char* name;
  std::vector<double> build;                       // seconds
  std::vector<std::vector<double>> queries;        // seconds, of each workload
  std::vector<double> answers;
  double bytes = 0;
};

std::vector<Vec3> visible_points(const PreparedScene& scene, std::uint32_t side) {
  std::vector<Vec3> points;
  for (std::uint32_t i = 0; i < side * side; ++i) {
    const Vec2 film{(static_cast<float>(i % side) + 0.5f) / side, (static_cast<float>(i / side) + 0.5f) / side};
    const Ray ray = camera_ray(scene.scene.cameras.front(), film, 1);
    const Hit hit = scene.accel.intersect(ray);
    if (hit.found()) points.push_back(ray.origin + hit.t * ray.direction);
  }
  return points;
}

std::vector<Workload> workloads(std::span<const Photon> photons, std::span<const Vec3> points,
                                const Execution& execution) {
  const PhotonMap map(photons, execution);
  std::vector<Workload> result{{"10 nearest", {}, 10}, {"50 nearest", {}, 50}, {"r of 10"},
                               {"r of 30"},            {"r of 100"},           {"r varies"}};
  const auto radii = [&](std::uint32_t k) {
    std::vector<double> r;
    for (const Vec3& p : points) r.push_back(nearest_radius_sq(map, p, k, kInfinity));
    return r;
  };
  for (auto& nearest : {&result[0], &result[1]}) {
    for (const Vec3& p : points) nearest->queries.push_back({p, 0});
  }
  for (const auto& [i, k] : {std::pair(2, 10u), {3, 30u}, {4, 100u}}) {
    const auto radius_sq = static_cast<float>(median(radii(k)));
    for (const Vec3& p : points) result[i].queries.push_back({p, radius_sq});
  }
  const std::vector<double> own = radii(30);
  Rng rng(1, RngPurpose::pilot, 0, 0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    result[5].queries.push_back({points[i], static_cast<float>(own[i]) * (0.25f + rng.next())});
  }
  return result;
}

// The sum of the kernel over all queries, or of the k-th distances.
template <class Index>
double run(const Index& index, const Workload& workload) {
  double total = 0;
  for (const auto& [center, radius_sq] : workload.queries) {
    if (workload.k > 0) {
      total += index.nearest_radius_sq(center, workload.k);
      continue;
    }
    std::array<float, 8> sums{};
    index.query(center, radius_sq, [&sums, inverse = 1 / radius_sq](const std::array<float, 8>& d, float) {
      for (int i = 0; i < 8; ++i) sums[i] += std::max(1 - d[i] * inverse, 0.0f);
    });
    for (const float sum : sums) total += sum;
  }
  return total;
}

template <class Index>
void measure(Row& row, std::span<const Photon> photons, const std::vector<Workload>& work, const Execution& execution) {
  std::unique_ptr<const Index> index;
  row.build.push_back(seconds([&] { index = std::make_unique<const Index>(photons, execution); }));
  row.bytes = static_cast<double>(index->memory_bytes()) / photons.size();
  row.queries.resize(work.size());
  row.answers.resize(work.size());
  for (std::size_t i = 0; i < work.size(); ++i) {
    row.queries[i].push_back(seconds([&] { row.answers[i] = run(*index, work[i]); }));
  }
}

bool same(const Row& a, const Row& b) {
  for (std::size_t i = 0; i < a.answers.size(); ++i) {
    // Float sums in different orders, and distances whose products are contracted differently.
    if (std::abs(a.answers[i] - b.answers[i]) > 1e-4 * std::abs(b.answers[i])) return false;
  }
  return true;
}

bool compare(const char* name, std::span<const Photon> photons, std::span<const Vec3> points, int rounds,
             const Execution& execution) {
  const std::vector<Workload> work = workloads(photons, points, execution);
  std::vector<Row> rows{{"photon map"}, {"kd-tree"}, {"sorted grid"}, {"octree"}};
  for (int round = 0; round < rounds; ++round) {
    measure<MapIndex>(rows[0], photons, work, execution);
    measure<KdTree>(rows[1], photons, work, execution);
    measure<SortedGrid>(rows[2], photons, work, execution);
    measure<ImplicitOctree>(rows[3], photons, work, execution);
  }
  std::printf("\n%s: %zu photons, %zu queries\n%-12s %10s %8s", name, photons.size(), points.size(), "", "build", "bytes/");
  for (const Workload& w : work) std::printf(" %10s", w.name);
  std::printf("\n%-12s %10s %8s %10s\n", "", "ns/photon", "photon", "µs/query");
  for (const Row& row : rows) {
    std::printf("%-12s %10.1f %8.1f", row.name, median(row.build) / photons.size() * 1e9, row.bytes);
    for (const auto& times : row.queries) std::printf(" %10.2f", median(times) / points.size() * 1e6);
    std::printf("%s\n", same(row, rows[0]) ? "" : "  DIFFERENT ANSWERS");
  }
  return std::all_of(rows.begin(), rows.end(), [&](const Row& row) { return same(row, rows[0]); });
}

// The photons of a map, as it was given them but for the order.
std::vector<Photon> photons_of(const PhotonMap& map) {
  std::vector<Photon> photons;
  for (std::uint32_t i = 0; i < map.size(); ++i) {
    // A multiplier that shares no factor with most sizes scatters them again.
    const auto j = static_cast<std::uint32_t>(i * 2'654'435'761ull % map.size());
    photons.push_back({map.position(j), encode_direction(map.direction(j)), encode_normal(map.normal(j)), nearest_flux(map.flux(j))});
  }
  return photons;
}

}  // namespace
}  // namespace photond::bench

int main(int argc, char** argv) {
  using namespace photond;
  using namespace photond::bench;
  CLI::App app{"The photon map's index and its rivals (medians of interleaved rounds; queries on one thread)"};
  std::vector<std::string> scenes;
  std::uint32_t photons = 262'144;
  std::uint32_t side = 128;
  int rounds = 5;
  app.add_option("scenes", scenes, "GLB files; default: the samples");
  app.add_option("--photons", photons, "paths emitted")->check(CLI::Range(1024, 100'000'000));
  app.add_option("--side", side, "pixels along a side of the picture whose points are queried")->check(CLI::Range(1, 4096));
  app.add_option("--rounds", rounds)->check(CLI::Range(1, 1000));
  CLI11_PARSE(app, argc, argv);
  std::vector<std::filesystem::path> paths(scenes.begin(), scenes.end());
  if (paths.empty()) paths = samples();

  const Workers workers;
  bool agree = true;
  for (const auto& path : paths) {
    const auto scene = load(path, workers.execution());
    if (!scene) {
      std::fprintf(stderr, "%s: %s\n", path.c_str(), scene.error().message.c_str());
      return 1;
    }
    const auto maps = build_photon_maps(**scene, {(*scene)->digest, {photons, 0}, 0}, workers.execution());
    const std::vector<Vec3> points = visible_points(**scene, side);
    const std::string name = path.stem().string();
    for (const auto& [map, kind] : {std::pair(&(*maps)->global, " global"), {&(*maps)->caustic, " caustic"}}) {
      if (map->size() < 1000) continue;
      agree &= compare((name + kind).c_str(), photons_of(*map), points, rounds, workers.execution());
    }
  }
  return agree ? 0 : 1;
}
