#include "server/cli/progress.h"

#include <gtest/gtest.h>

namespace photond::test {
namespace {

Progress progress(std::uint32_t passes, double seconds, double relative = 0) {
  return {.passes = passes,
          .seconds = seconds,
          .error = {.rmse = relative, .relative = relative, .known = relative > 0}};
}

TEST(StopRuleTest, EndsAtWhicheverComesFirst) {
  const StopRule stop{.passes = 20, .seconds = 5.0, .relative_error = 0.1};
  EXPECT_EQ(rule_met(stop, progress(19, 4.9, 0.11)), nullptr);
  EXPECT_STREQ(rule_met(stop, progress(20, 1, 0.5)), "passes");
  EXPECT_STREQ(rule_met(stop, progress(1, 5, 0.5)), "seconds");
  EXPECT_STREQ(rule_met(stop, progress(10, 1, 0.1)), "relative_error");
  EXPECT_EQ(rule_met(stop, progress(2, 1, 0.01)), nullptr) << "the spread of two passes proves nothing";
  EXPECT_EQ(rule_met(stop, progress(10, 1)), nullptr) << "an unknown error is not a small one";
}

TEST(StopRuleTest, ExpectsTheErrorToFallWithTheRootOfTime) {
  EXPECT_DOUBLE_EQ(*remaining_seconds({.relative_error = 0.1}, progress(10, 2, 0.2)), 6);
  EXPECT_DOUBLE_EQ(*remaining_seconds({.passes = 40}, progress(10, 2)), 6);
  EXPECT_DOUBLE_EQ(*remaining_seconds({.seconds = 5.0, .relative_error = 0.1}, progress(10, 2, 0.2)), 3);
  EXPECT_DOUBLE_EQ(*remaining_seconds({.seconds = 5.0}, progress(10, 7)), 0);
  EXPECT_FALSE(remaining_seconds({.passes = 40}, progress(0, 2)));
  EXPECT_FALSE(remaining_seconds({.relative_error = 0.1}, progress(10, 2)));
}

TEST(ProgressLine, ShowsPartPassesTimeErrorAndRest) {
  const std::string line = progress_line({.passes = 40}, progress(10, 2, 0.05), 100);
  EXPECT_EQ(line, "[#######-----------------------]   25 %  pass 10  2.0 s  error 0.0500  ETA 6.0 s");
}

TEST(ProgressLine, FitsIntoTheTerminal) {
  for (int columns = 1; columns < 120; ++columns) {
    const auto line = progress_line({.passes = 40}, progress(10, 2, 0.05), columns);
    EXPECT_LE(static_cast<int>(line.size()), columns) << line;
  }
}

TEST(StageLine, FitsIntoTheTerminal) {
  EXPECT_EQ(stage_line("loading a.glb", 80), "loading a.glb …");
  EXPECT_EQ(stage_line("loading a.glb", 9), "loading …");
  EXPECT_EQ(stage_line("größer", 5), "grö …") << "characters, not bytes";
}

TEST(LossesText, TellsOnlyOfWhatIsLost) {
  Film film(1, 1);
  EXPECT_EQ(losses_text(film), "");
  film.rejected = 3;
  film.truncated = 2;
  EXPECT_EQ(losses_text(film),
            ", 3 samples rejected (not finite or too bright: they count as black), 2 paths cut at the depth limit");
}

TEST(DurationText, ChoosesItsUnit) {
  EXPECT_EQ(duration_text(0), "0.0 s");
  EXPECT_EQ(duration_text(99.94), "99.9 s");
  EXPECT_EQ(duration_text(99.96), "1:40 min");
  EXPECT_EQ(duration_text(247), "4:07 min");
  EXPECT_EQ(duration_text(3599.6), "1:00 h");
  EXPECT_EQ(duration_text(7500), "2:05 h");
}

}  // namespace
}  // namespace photond::test
