// Horizontal bars as SVG text, several panels in one file.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace gw::plot {

struct Bar {
  std::string label;            // left of the bar
  std::optional<double> value;  // >= 0; none: no bar, only the note
  std::string note;             // behind the bar
  bool hatched = false;
  bool bold = false;
  std::string color = "";  // SVG colour; empty: the first of the palette
};

struct BarPanel {
  std::string title;
  std::string x_label;
  std::vector<Bar> bars;         // from top to bottom
  std::optional<double> x_max;   // longer bars are cut off there; otherwise from the data
  std::optional<double> marker;  // a dashed vertical line
  std::string marker_label;
};

struct BarFigure {
  std::string title;
  int columns = 1;
  int panel_width = 640;            // px
  std::vector<BarPanel> panels;     // row by row
  std::vector<std::string> footer;  // small lines below: where the data comes from
};

std::string RenderBars(const BarFigure& figure);

}  // namespace gw::plot
