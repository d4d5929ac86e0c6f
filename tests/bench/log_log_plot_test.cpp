#include "tests/bench/log_log_plot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace photond::bench {
namespace {

// Whether every element is closed in order and every quotation mark and ampersand has its counterpart.
testing::AssertionResult is_well_formed(const std::string& xml) {
  std::vector<std::string> open;
  int elements = 0;
  for (std::size_t at = xml.find('<'); at != std::string::npos; at = xml.find('<', at + 1)) {
    const std::size_t end = xml.find('>', at);
    if (end == std::string::npos) return testing::AssertionFailure() << "a tag without end";
    const std::string tag = xml.substr(at + 1, end - at - 1);
    if (tag.find('<') != std::string::npos) return testing::AssertionFailure() << "a tag inside of " << tag;
    if (std::count(tag.begin(), tag.end(), '"') % 2 != 0) return testing::AssertionFailure() << "quotes of " << tag;
    const std::string name = tag.substr(tag[0] == '/', tag.find_first_of(" /", 1) - (tag[0] == '/'));
    if (tag[0] == '/') {
      if (open.empty() || open.back() != name) return testing::AssertionFailure() << name << " is not open";
      open.pop_back();
    } else if (tag.back() != '/') {
      if (open.empty() && elements > 0) return testing::AssertionFailure() << name << " is a second root";
      open.push_back(name);
    }
    ++elements;
  }
  for (std::size_t at = xml.find('&'); at != std::string::npos; at = xml.find('&', at + 1)) {
    const auto is = [&](const std::string& entity) { return xml.compare(at, entity.size(), entity) == 0; };
    const bool entity = is("&amp;") || is("&lt;") || is("&gt;");
    if (!entity) return testing::AssertionFailure() << "a bare ampersand";
  }
  if (!open.empty()) return testing::AssertionFailure() << open.back() << " is not closed";
  return testing::AssertionSuccess();
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

LogLogPlot example() {
  return {"a & b < c", "seconds", "relMSE", {{"one", {{1, 0.1}, {10, 0.01}, {100, 0.001}}}, {"two", {{2, 0.5}}}},
          PlotLevel{"floor", 1e-4}};
}

TEST(LogLogPlot, IsWellFormedWhateverItsNames) {
  EXPECT_TRUE(is_well_formed(to_svg(example())));
  EXPECT_FALSE(is_well_formed("<svg><g></svg>"));
  EXPECT_FALSE(is_well_formed("<svg>a & b</svg>"));
}

TEST(LogLogPlot, DrawsEachLineItsPointsAndTheLevel) {
  const std::string svg = to_svg(example());
  EXPECT_EQ(count(svg, "<polyline"), 2u);
  EXPECT_EQ(count(svg, "<path"), 3u + 1u + 2u);                 // points, and one in the legend for each line
  EXPECT_EQ(count(svg, "<line class=\"level\""), 1u);
  for (const char* name : {">one<", ">two<", ">floor<", ">seconds<", ">relMSE<"}) {
    EXPECT_EQ(count(svg, name), 1u) << name;
  }
  EXPECT_EQ(count(svg, "prefers-color-scheme: dark"), 1u);
}

TEST(LogLogPlot, ShowsAPowerLawAsAStraightLine) {
  const std::string svg = to_svg(example());
  double x[3], y[3];
  const std::string points = svg.substr(svg.find("points=\"") + 8);
  ASSERT_EQ(std::sscanf(points.c_str(), "%lf,%lf %lf,%lf %lf,%lf", x, y, x + 1, y + 1, x + 2, y + 2), 6);
  // Coordinates are written with one decimal.
  EXPECT_NEAR(x[1] - x[0], x[2] - x[1], 0.11);
  EXPECT_NEAR(y[1] - y[0], y[2] - y[1], 0.11);
  EXPECT_GT(x[1], x[0]);
  EXPECT_GT(y[1], y[0]);                                        // y grows downwards
}

TEST(LogLogPlot, TakesNoPointsOrOne) {
  EXPECT_TRUE(is_well_formed(to_svg({"t", "x", "y", {}, {}})));
  const std::string one = to_svg({"t", "x", "y", {{"a", {{1, 1}}}}, {}});
  EXPECT_TRUE(is_well_formed(one));
  EXPECT_EQ(count(one, "nan") + count(one, "inf"), 0u);
}

}  // namespace
}  // namespace photond::bench
