// A figure in both of its forms: as SVG for documents, and as data for the charts of a report
// (tools/view/page/src/figures.js), which zoom and show values.
#pragma once

#include <string>

#include "tools/lab/plot/bars.h"
#include "tools/lab/plot/svg.h"

namespace gw::plot {

struct Drawing {
  std::string svg;
  std::string json;  // its text
};

Drawing Draw(const Figure& figure);
Drawing Draw(const BarFigure& figure);

}  // namespace gw::plot
