#include "server/jobs/memory_need.h"

#include <gtest/gtest.h>

#include "tests/support/scenes.h"

namespace photond {
namespace {

TEST(MemoryNeed, APilotTellsHowManyPhotonsAPassLeaves) {
  const auto scene = test::busy_room();
  const PhotonSettings photons{200'000, 3};
  for (const Method method : {Method::progressive, Method::hybrid}) {
    RenderSettings settings;
    settings.method = method;
    const Execution execution = test::workers().execution();
    const auto task = make_render_task(scene, scene->scene.cameras[0], photons, settings, execution);
    ASSERT_TRUE(task.ok()) << task.error().message;
    const auto maps = build_photon_maps(*scene, map_key(scene->digest, photons, method, 0), execution);
    ASSERT_TRUE(maps.ok());
    const std::uint64_t stored = (*maps)->global.size() + (*maps)->caustic.size();
    const MemoryNeed need = memory_need(*task, settings);
    const double forecast = static_cast<double>(need.maps);
    // The lights of the hybrid's paths leave somewhat other photons than all lights do: 21 % here.
    EXPECT_NEAR(forecast, static_cast<double>(stored * sizeof(Photon)), 0.25 * forecast) << method_name(method);
    EXPECT_GT(forecast, 0) << method_name(method);
    settings.method = Method::progressive;
    EXPECT_EQ(need.film, memory_need(settings, photons).film) << "with what both gather";
  }
}

TEST(MemoryNeed, WhatTakesMoreIsNamed) {
  EXPECT_TRUE(check_memory({600, 400}, 1000).ok());
  EXPECT_EQ(check_memory({600, 400}, 999).error().where, "/film");
  EXPECT_EQ(check_memory({400, 600}, 999).error().where, "/photons_per_pass");
  EXPECT_EQ(check_memory({400, 600}, 999).error().code, ErrorCode::limit_exceeded);
  RenderSettings settings;
  settings.method = Method::path;
  EXPECT_EQ(memory_need(settings, {}).maps, 0u);
  settings.method = Method::photon_map;
  EXPECT_EQ(memory_need(settings, {.photons_per_pass = 100'000'000}).maps, 3'200'000'000u);
}

}  // namespace
}  // namespace photond
