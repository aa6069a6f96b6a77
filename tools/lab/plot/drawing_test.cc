#include "tools/lab/plot/drawing.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tools/data/files/json.h"

namespace gw::plot {
namespace {

TEST(Drawing, ValuesAreThoseOfTheFigureAndGapsAreNull) {
  Panel panel;
  panel.title = "error";
  panel.y_range = {-1, 2};
  panel.series = {{"a", {0, 1, 2}, {0.123456789, NAN, -1234567.8}}};
  panel.spans = {{0.5, 1.5, "blind"}};
  Figure figure;
  figure.panels = {panel};
  figure.footer = {"log x"};
  const Drawing drawing = Draw(figure);
  EXPECT_EQ(drawing.svg, RenderSvg(figure));
  const tools::Json json = tools::Json::parse(drawing.json);
  const tools::Json& first = json["panels"][0];
  EXPECT_EQ(first["series"][0]["y"], (tools::Json{0.123457, nullptr, -1234570.0}));
  EXPECT_EQ(first["series"][0]["x"], (tools::Json{0, 1.0, 2.0}));
  EXPECT_EQ(first["y_range"], (tools::Json{-1.0, 2.0}));
  EXPECT_TRUE(first["x_range"].is_null());
  EXPECT_EQ(first["spans"][0]["x_end"], 1.5);
  EXPECT_EQ(json["footer"][0], "log x");
}

TEST(Drawing, ABarWithoutAValueIsNull) {
  BarPanel panel;
  panel.bars = {{"full", 0.5, "0.5 m", false, true, ""}, {"none", std::nullopt, "-"}};
  panel.marker = 0.7;
  BarFigure figure;
  figure.panels = {panel};
  const Drawing drawing = Draw(figure);
  EXPECT_EQ(drawing.svg, RenderBars(figure));
  const tools::Json json = tools::Json::parse(drawing.json);
  const tools::Json& first = json["panels"][0];
  EXPECT_EQ(first["bars"][0]["value"], 0.5);
  EXPECT_TRUE(first["bars"][1]["value"].is_null());
  EXPECT_EQ(first["marker"], 0.7);
}

}  // namespace
}  // namespace gw::plot
