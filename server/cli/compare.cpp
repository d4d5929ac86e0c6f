#include "core/film/compare.h"

#include <cstdio>
#include <iostream>

#include "server/cli/cli.h"
#include "server/cli/commands.h"
#include "server/cli/picture.h"
#include "server/cli/report_json.h"

namespace photond {
namespace {

Json comparison_json(const Comparison& c) {
  return {{"mse", c.mse},
          {"rel_mse", c.rel_mse},
          {"rel_mse_trimmed", c.rel_mse_trimmed},
          {"mean_ratio", {c.mean_ratio.x, c.mean_ratio.y, c.mean_ratio.z}},
          {"max_block_deviation", c.max_block_deviation},
          {"median_block_deviation", c.median_block_deviation}};
}

void print_comparison(const Comparison& c) {
  std::printf("MSE                     %.6g\n", c.mse);
  std::printf("relMSE                  %.6g\n", c.rel_mse);
  std::printf("relMSE without worst    %.6g   (0.1 %% of the pixels left out)\n", c.rel_mse_trimmed);
  std::printf("mean ratio R G B        %.6f %.6f %.6f\n", c.mean_ratio.x, c.mean_ratio.y, c.mean_ratio.z);
  std::printf("8x8 blocks, largest     %.4f %%\n", 100 * c.max_block_deviation);
  std::printf("8x8 blocks, median      %.4f %%\n", 100 * c.median_block_deviation);
}

}  // namespace

int run_compare(const CompareCommand& command) {
  const auto image = read_picture(command.image);
  if (!image) return print_failure(command.image, image.error());
  const auto reference = read_picture(command.reference);
  if (!reference) return print_failure(command.reference, reference.error());
  const auto comparison = compare_images(*image, *reference);
  if (!comparison) return print_failure(command.image + " against " + command.reference, comparison.error());
  if (command.json)
    std::cout << indented(comparison_json(*comparison));
  else
    print_comparison(*comparison);
  return finish_output();
}

}  // namespace photond
