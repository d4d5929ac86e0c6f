#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tests/bench/power_law.h"

namespace photond::bench {

struct PlotLine {
  std::string name;
  std::vector<TimePoint> points;  ///< ascending in time
};

struct PlotLevel {
  std::string name;
  double value;
};

/// Positive quantities against time, both axes logarithmic.
struct LogLogPlot {
  std::string title;
  std::string x_label;
  std::string y_label;
  std::vector<PlotLine> lines;     ///< at most kPlotLines
  std::optional<PlotLevel> level;  ///< drawn dashed from side to side
};
inline constexpr std::size_t kPlotLines = 5;

/// The plot as an SVG file that follows the reader's light or dark colour scheme.
std::string to_svg(const LogLogPlot& plot);

}  // namespace photond::bench
