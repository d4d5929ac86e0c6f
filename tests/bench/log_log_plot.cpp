#include "tests/bench/log_log_plot.h"

#include <algorithm>
#include <cassert>
#include <cstdarg>
#include <cstdio>
#include <limits>

namespace photond::bench {
namespace {

constexpr double kWidth = 860, kHeight = 460;
constexpr double kLeft = 78, kRight = 220, kTop = 44, kBottom = 58;  // margins; the legend stands in the right one

// The lines' colours are apart in lightness as well as in hue, so that they differ for the colour-blind and in print.
constexpr const char* kStyle = R"(<style>
  svg { font: 13px system-ui, sans-serif; background: #fff; color: #222;
        --grid: #d8d8d8; --c0: #0060b0; --c1: #d05000; --c2: #00805c; --c3: #8a3fa0; --c4: #7a6a00; }
  @media (prefers-color-scheme: dark) {
    svg { background: #16181c; color: #ddd;
          --grid: #383c44; --c0: #58b0ff; --c1: #ff9550; --c2: #3fd0a0; --c3: #d090e8; --c4: #dcc840; }
  }
  text { fill: currentColor; }
  .title { font-weight: 600; font-size: 15px; }
  .grid { stroke: var(--grid); stroke-width: 1; }
  .level { stroke: currentColor; stroke-width: 1.5; stroke-dasharray: 6 5; }
  .line { fill: none; stroke-width: 2; stroke-linejoin: round; }
</style>
)";

[[gnu::format(printf, 1, 2)]] std::string text(const char* format, ...) {
  char buffer[512];
  std::va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(buffer, sizeof buffer, format, arguments);
  va_end(arguments);
  return buffer;
}

std::string escaped(const std::string& plain) {
  std::string out;
  for (const char c : plain) out += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : std::string(1, c);
  return out;
}

// A logarithmic axis from `low` to `high`, drawn from `begin` to `end`.
struct Axis {
  double low, high, begin, end;
  double operator()(double value) const {
    return begin + (end - begin) * std::log(value / low) / std::log(high / low);
  }
};

struct Tick {
  double value;
  std::string label;
};

std::vector<Tick> ticks(const Axis& axis, std::initializer_list<int> digits) {
  std::vector<Tick> out;
  for (int decade = static_cast<int>(std::floor(std::log10(axis.low))); std::pow(10, decade) <= axis.high; ++decade) {
    for (const int digit : digits) {
      const std::string label = text("%de%d", digit, decade);
      const double value = std::stod(label);
      if (value >= axis.low && value <= axis.high) out.push_back({value, text("%g", value)});
    }
  }
  return out;
}

// Smallest and largest of what `of` reads from the points, never equal.
template <class Of>
std::pair<double, double> range(const LogLogPlot& plot, const Of& of) {
  double low = std::numeric_limits<double>::infinity(), high = 0;
  for (const PlotLine& line : plot.lines) {
    for (const TimePoint& p : line.points) low = std::min(low, of(p)), high = std::max(high, of(p));
  }
  if (!(high > 0)) return {0.1, 10};  // no point at all
  return low < high ? std::pair(low, high) : std::pair(low / 2, high * 2);
}

Axis time_axis(const LogLogPlot& plot) {
  const auto [low, high] = range(plot, [](const TimePoint& p) { return p.seconds; });
  return {low / 1.1, high * 1.1, kLeft, kWidth - kRight};
}

Axis value_axis(const LogLogPlot& plot) {
  auto [low, high] = range(plot, [](const TimePoint& p) { return p.value; });
  if (plot.level) {
    low = std::min(low, plot.level->value);
    high = std::max(high, plot.level->value);
  }
  return {low / 1.5, high * 1.5, kHeight - kBottom, kTop};
}

std::string marker(std::size_t line, double x, double y) {
  static constexpr const char* kShapes[kPlotLines] = {
      "M-4,0a4,4 0 1,0 8,0a4,4 0 1,0 -8,0z", "M-4,-4h8v8h-8z", "M0,-5l5,9h-10z", "M0,-5.5l5.5,5.5l-5.5,5.5l-5.5,-5.5z",
      "M0,5l5,-9h-10z"};
  return text("<path d=\"%s\" transform=\"translate(%.1f %.1f)\" fill=\"var(--c%zu)\"/>\n", kShapes[line], x, y, line);
}

std::string grid(const Axis& x, const Axis& y) {
  std::string out;
  for (const Tick& t : ticks(x, {1, 2, 5})) {
    const double at = x(t.value);
    out += text("<line class=\"grid\" x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\"/>\n", at, y.begin, at, y.end);
    out += text("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%s</text>\n", at, y.begin + 20, t.label.c_str());
  }
  // Fewer digits where the axis spans many decades.
  const bool wide = y.high / y.low > 1e3;
  for (const Tick& t : wide ? ticks(y, {1}) : ticks(y, {1, 2, 5})) {
    const double at = y(t.value);
    out += text("<line class=\"grid\" x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\"/>\n", x.begin, at, x.end, at);
    out += text("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">%s</text>\n", x.begin - 8, at + 4.5, t.label.c_str());
  }
  return out;
}

std::string labels(const LogLogPlot& plot, const Axis& x, const Axis& y) {
  const double middle_x = (x.begin + x.end) / 2, middle_y = (y.begin + y.end) / 2;
  return text("<text class=\"title\" x=\"%.1f\" y=\"26\" text-anchor=\"middle\">", middle_x) + escaped(plot.title) +
         text("</text>\n<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">", middle_x, kHeight - 16) +
         escaped(plot.x_label) +
         text("</text>\n<text transform=\"translate(18 %.1f) rotate(-90)\" text-anchor=\"middle\">", middle_y) +
         escaped(plot.y_label) + "</text>\n";
}

std::string curve(const PlotLine& line, std::size_t index, const Axis& x, const Axis& y) {
  std::string points, markers;
  for (const TimePoint& p : line.points) {
    points += text("%.1f,%.1f ", x(p.seconds), y(p.value));
    markers += marker(index, x(p.seconds), y(p.value));
  }
  return text("<polyline class=\"line\" stroke=\"var(--c%zu)\" points=\"", index) + points + "\"/>\n" + markers;
}

std::string legend(const LogLogPlot& plot, const Axis& x, const Axis& y) {
  std::string out;
  const double left = x.end + 20;
  double row = y.end + 10;
  const auto entry = [&](const std::string& sample, const std::string& name) {
    out += sample + text("<text x=\"%.1f\" y=\"%.1f\">", left + 38, row + 4.5) + escaped(name) + "</text>\n";
    row += 20;
  };
  const auto stroke = [&](const char* attributes) {
    return text("<line x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\" %s/>\n", left, row, left + 30, row, attributes);
  };
  for (std::size_t i = 0; i < plot.lines.size(); ++i) {
    const std::string colour = text("class=\"line\" stroke=\"var(--c%zu)\"", i);
    entry(stroke(colour.c_str()) + marker(i, left + 15, row), plot.lines[i].name);
  }
  if (plot.level) entry(stroke("class=\"level\""), plot.level->name);
  return out;
}

}  // namespace

std::string to_svg(const LogLogPlot& plot) {
  assert(plot.lines.size() <= kPlotLines);
  const Axis x = time_axis(plot), y = value_axis(plot);
  std::string svg =
      text("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %g %g\" width=\"%g\" height=\"%g\">\n", kWidth,
           kHeight, kWidth, kHeight);
  svg += kStyle + grid(x, y) + labels(plot, x, y);
  if (plot.level) {
    const double at = y(plot.level->value);
    svg += text("<line class=\"level\" x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\"/>\n", x.begin, at, x.end, at);
  }
  for (std::size_t i = 0; i < plot.lines.size(); ++i) svg += curve(plot.lines[i], i, x, y);
  return svg + legend(plot, x, y) + "</svg>\n";
}

}  // namespace photond::bench
