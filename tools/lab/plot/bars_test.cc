#include "tools/lab/plot/bars.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace gw::plot {
namespace {

using testing::HasSubstr;
using testing::Not;

size_t CountOf(const std::string& text, const std::string& part) {
  size_t count = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(Bars, EachBarHasItsLabelAndNoteAndLengthInProportion) {
  BarFigure figure;
  figure.title = "a < b";
  figure.footer = {"log X"};
  BarPanel panel;
  panel.x_label = "m";
  panel.bars = {{"full", 1.0, "1.00", false, true}, {"none", 2.0, "2.00 (50 %)", true}};
  panel.marker = 1.5;
  panel.marker_label = "DR alone";
  figure.panels = {panel};
  const std::string svg = RenderBars(figure);
  for (const char* text : {">full<", ">1.00<", ">2.00 (50 %)<", "a &lt; b", ">DR alone<", ">log X<",
                           "font-weight=\"bold\""}) {
    EXPECT_THAT(svg, HasSubstr(text));
  }
  EXPECT_EQ(CountOf(svg, "<pattern"), 1u);
  // The longest bar defines the axis; the other is half as long.
  const auto width_after = [&](const std::string& mark) {
    const size_t rect = svg.find("height=\"14.00\"", svg.find(mark));
    const size_t width = svg.rfind("width=\"", rect);
    return std::stod(svg.substr(width + 7));
  };
  EXPECT_NEAR(width_after(">none<") / width_after(">full<"), 2.0, 1e-3);
}

TEST(Bars, WithoutAValueThereIsOnlyTheNote) {
  BarFigure figure;
  figure.panels = {{"t", "m", {{"none", std::nullopt, "failed"}}, {}, {}, ""}};
  const std::string svg = RenderBars(figure);
  EXPECT_THAT(svg, HasSubstr(">failed<"));
  EXPECT_THAT(svg, Not(HasSubstr("height=\"14.00\"")));
}

}  // namespace
}  // namespace gw::plot
