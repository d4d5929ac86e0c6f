#include "tests/bench/error_series.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/scenes.h"

namespace photond::bench {
namespace {

TEST(MeasuredTimes, AreRootTwoApartAndEndWithTheLast) {
  const std::vector<double> times = measured_times(160);
  EXPECT_EQ(times.back(), 160);
  for (const double t : {2.5, 5.0, 10.0, 20.0, 40.0, 80.0}) {
    EXPECT_EQ(std::count(times.begin(), times.end(), t), 1) << t;
  }
  for (std::size_t i = 1; i < times.size(); ++i) EXPECT_NEAR(times[i] / times[i - 1], std::sqrt(2), 1e-9);
  EXPECT_EQ(measured_times(0.1), std::vector<double>{0.1});
  EXPECT_EQ(measured_times(3).back(), 3);
}

TEST(ErrorSeries, MeasuresThePassesThatWereDoneInTime) {
  // A camera that sees nothing but an emitter of radiance 2: every picture is 2, and from a reference of 1 its relMSE
  // is (2 − 1)²/(1 + 0.01).
  Scene scene = test::empty_scene();
  test::add_mesh(scene, test::parallelogram({-50, -50, -1}, {100, 0, 0}, {0, 100, 0}),
                 test::add_material(scene, test::emitter(Rgb(2))));
  const auto prepared = test::prepared(std::move(scene));
  RenderSettings settings;
  settings.method = Method::path;
  settings.width = settings.height = 16;
  const auto task = make_render_task(prepared, look_at({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 0.7f), {}, settings, {});
  ASSERT_TRUE(task.ok());
  Image reference(16, 16);
  for (Rgb& pixel : reference.pixels) pixel = Rgb(1);
  const auto records = error_series(*task, reference, {0.05, 0.1, 0.3}, {});
  ASSERT_TRUE(records.ok());
  ASSERT_FALSE(records->empty());                               // a busy machine may miss the first times
  EXPECT_EQ(records->back().seconds, 0.3);
  ErrorRecord before;
  for (const ErrorRecord& record : *records) {
    EXPECT_NEAR(record.rel_mse, 1 / 1.01, 1e-6);                // the picture is of floats
    EXPECT_NEAR(record.median_block_deviation, 1, 1e-6);
    EXPECT_NEAR(record.estimated, 0, 1e-12);                    // no pass differs from another
    EXPECT_GT(record.seconds, before.seconds);
    EXPECT_GE(record.passes, std::max(1u, before.passes));
    before = record;
  }
}

TEST(ErrorSeries, SaysWhatCannotBeCompared) {
  const auto prepared = test::prepared(test::empty_scene());
  RenderSettings settings;
  settings.method = Method::path;
  settings.width = settings.height = 16;
  const auto task = make_render_task(prepared, look_at({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 0.7f), {}, settings, {});
  ASSERT_TRUE(task.ok());
  EXPECT_FALSE(error_series(*task, Image(8, 8), {0.01}, {}).ok());
}

}  // namespace
}  // namespace photond::bench
