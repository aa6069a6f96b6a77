#include "tools/lab/plot/svg.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/core/random.h"
#include "tools/lab/plot/elements.h"

namespace gw::plot {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

int Count(const std::string& text, const std::string& part) {
  int count = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

// Every element that opens also closes, and no text breaks out of it.
void ExpectWellFormed(const std::string& svg) {
  EXPECT_EQ(Count(svg, "<svg"), 1);
  EXPECT_EQ(Count(svg, "<g"), Count(svg, "</g>"));
  EXPECT_EQ(Count(svg, "<text"), Count(svg, "</text>"));
  EXPECT_EQ(Count(svg, "\"") % 2, 0);
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_THAT(svg, Not(HasSubstr("inf")));
}

Figure OnePanel(Panel panel) {
  Figure figure;
  figure.panels.push_back(std::move(panel));
  return figure;
}

TEST(NiceTicks, AreRoundAndInside) {
  EXPECT_THAT(NiceTicks(0, 10, 5), ElementsAre(0, 2, 4, 6, 8, 10));
  EXPECT_THAT(NiceTicks(-0.6, 0.7, 3), ElementsAre(-0.5, 0, 0.5));
}

TEST(NiceTicks, SweepStaysInRangeNearTheAskedNumber) {
  for (int i = 0; i < 500; ++i) {
    CounterRng rng(1, 0, i);
    const double size = std::pow(10.0, rng.Uniform(-6, 6));
    const double low = rng.Uniform(-3, 3) * size;
    const double high = low + size;
    const std::vector<double> ticks = NiceTicks(low, high, 6);
    ASSERT_GE(ticks.size(), 2u) << low << " " << high;
    ASSERT_LE(ticks.size(), 8u) << low << " " << high;
    for (const double tick : ticks) {
      EXPECT_GE(tick, low - 1e-9 * size);
      EXPECT_LE(tick, high + 1e-9 * size);
    }
  }
}

TEST(Svg, SameFigureGivesSameBytes) {
  Panel panel;
  panel.title = "a < b & c";
  panel.series.push_back({"one", {0, 1, 2}, {0, 1, 4}});
  panel.spans.push_back({0.5, 1, "gap"});
  const std::string svg = RenderSvg(OnePanel(panel));
  EXPECT_EQ(svg, RenderSvg(OnePanel(panel)));
  ExpectWellFormed(svg);
  EXPECT_THAT(svg, HasSubstr("a &lt; b &amp; c"));
}

TEST(Svg, ValueThatIsNotFiniteInterruptsTheLine) {
  Panel panel;
  panel.series.push_back({"", {0, 1, 2, 3, 4}, {0, 1, std::nan(""), 1, 0}});
  const std::string svg = RenderSvg(OnePanel(panel));
  const size_t path = svg.find("<path d=\"");
  ASSERT_NE(path, std::string::npos);
  EXPECT_EQ(Count(svg.substr(path, svg.find("fill", path) - path), "M"), 2);
  ExpectWellFormed(svg);
}

TEST(Svg, EqualAspectDrawsASquareAsASquare) {
  Panel panel;
  panel.equal_aspect = true;
  panel.series.push_back({"", {0, 3, 3, 0}, {0, 0, 3, 3}, Style::kPoints});
  const std::string svg = RenderSvg(OnePanel(panel));
  std::vector<double> x;
  std::vector<double> y;
  for (size_t at = svg.find("cx=\""); at != std::string::npos; at = svg.find("cx=\"", at + 1)) {
    x.push_back(std::stod(svg.substr(at + 4)));
    y.push_back(std::stod(svg.substr(svg.find("cy=\"", at) + 4)));
  }
  ASSERT_EQ(x.size(), 4u);
  EXPECT_NEAR(x[1] - x[0], y[1] - y[2], 0.2);
  EXPECT_GT(x[1] - x[0], 100);
}

TEST(Svg, PanelsWithoutUsableDataAreStillDrawn) {
  Figure figure;
  figure.title = "nothing";
  figure.columns = 2;
  figure.panels.resize(3);
  const double infinity = std::numeric_limits<double>::infinity();
  figure.panels[1].series.push_back({"constant", {5, 5}, {7, 7}, Style::kLineAndPoints});
  figure.panels[2].series.push_back({"bad", {1, infinity}, {infinity, 2}});
  figure.panels[2].spans.push_back({0, infinity, "bad"});
  const std::string svg = RenderSvg(figure);
  ExpectWellFormed(svg);
  EXPECT_THAT(svg, HasSubstr("width=\"1280\" height=\"834\""));
}

}  // namespace
}  // namespace gw::plot
