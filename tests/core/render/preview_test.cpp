#include "core/render/preview.h"

#include <gtest/gtest.h>

#include <cstring>

#include "core/film/reconstruct.h"
#include "tests/support/scenes.h"

namespace photond {
namespace {

class Preview : public ::testing::Test {
 protected:
  RenderTask task(int width, int height, Method method = Method::progressive) const {
    const RenderSettings settings{.method = method, .width = width, .height = height};
    return *make_render_task(scene_, scene_->scene.cameras[0], photons_, settings, test::workers().execution());
  }
  MapSource maps() {
    return [this](const MapKey& key, const Execution& execution) {
      ++asked_;
      EXPECT_EQ(key.pass, 0u);
      return build_photon_maps(*scene_, key, execution);
    };
  }

  std::shared_ptr<const PreparedScene> scene_ = test::busy_room();
  PhotonSettings photons_{20'000, 0};
  int asked_ = 0;
};

TEST_F(Preview, OnlyWhereItIsSoonerThanAPassOfPhotons) {
  EXPECT_TRUE(has_preview(task(512, 512)));
  EXPECT_FALSE(has_preview(task(128, 128)));
  EXPECT_FALSE(has_preview(task(512, 512, Method::path)));
}

TEST_F(Preview, HasTheSizeOfTheFilmAndDoesNotDependOnTheThreads) {
  const RenderTask odd = task(401, 203);
  const Image one = *render_preview(odd, maps(), Execution{});
  const Image many = *render_preview(odd, maps(), test::workers().execution());
  EXPECT_EQ(one.width, 401);
  EXPECT_EQ(one.height, 203);
  EXPECT_EQ(asked_, 2);
  EXPECT_EQ(std::memcmp(one.pixels.data(), many.pixels.data(), one.pixels.size() * sizeof(Rgb)), 0);
}

// The same view in the same light: blocks of 32² pixels have the means of a pass, but for the noise of some 16 samples
// each, whose spread is below the mean where the room is lit.
TEST_F(Preview, ShowsWhatThePassWillShow) {
  const RenderTask large = task(256, 256);
  const Image preview = *render_preview(large, maps(), test::workers().execution());
  Film film(256, 256);
  add_pass(film, 0, *render_pass(large, 0, maps(), test::workers().execution()));
  const Image pass = film_picture(film);
  double difference = 0, sum = 0;
  for (std::size_t block = 0; block < 64; ++block) {
    double a = 0, b = 0;
    for (std::size_t i = 0; i < 32 * 32; ++i) {
      const std::size_t pixel = (block / 8 * 32 + i / 32) * 256 + block % 8 * 32 + i % 32;
      a += preview.pixels[pixel].y;
      b += pass.pixels[pixel].y;
    }
    difference += std::abs(a - b);
    sum += b;
  }
  EXPECT_LT(difference / sum, 0.25);
}

TEST_F(Preview, IsCancelled) {
  std::stop_source stop;
  stop.request_stop();
  const auto image = render_preview(task(512, 512), maps(), Execution{nullptr, stop.get_token()});
  ASSERT_FALSE(image.ok());
  EXPECT_EQ(image.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace photond
