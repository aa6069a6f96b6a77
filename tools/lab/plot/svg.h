// Charts as SVG text: line and point series over two linear axes, several panels in one file.
// The same figure gives the same bytes on every machine.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace gw::plot {

enum class Style { kLine, kPoints, kLineAndPoints };

struct Series {
  std::string label;      // of the legend; empty: not in the legend
  std::vector<double> x;  // as many as y
  std::vector<double> y;  // a value that is not finite interrupts the line
  Style style = Style::kLine;
  std::string color = "";  // SVG colour; empty: the next one of the palette
  bool dashed = false;
  double width = 1.5;  // px, of lines
};

// A vertical band from x_begin to x_end, behind the series.
struct Span {
  double x_begin = 0;
  double x_end = 0;
  std::string label;              // of the legend; spans with equal labels share one entry
  std::string color = "#d62728";  // drawn pale
};

struct Panel {
  std::string title;
  std::string x_label;
  std::string y_label;
  bool equal_aspect = false;                         // one unit is as long on x as on y (maps)
  std::optional<std::pair<double, double>> x_range;  // otherwise from the data
  std::optional<std::pair<double, double>> y_range;
  std::vector<Series> series;
  std::vector<Span> spans;
};

struct Figure {
  std::string title;
  int columns = 1;
  int panel_width = 640;  // px, with axes and labels
  int panel_height = 400;
  std::vector<Panel> panels;        // row by row
  std::vector<std::string> footer;  // small lines below: where the data comes from
};

std::string RenderSvg(const Figure& figure);

}  // namespace gw::plot
