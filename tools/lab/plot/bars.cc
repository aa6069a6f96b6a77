#include "tools/lab/plot/bars.h"

#include <algorithm>
#include <cmath>

#include "common/core/format.h"
#include "tools/lab/plot/elements.h"

namespace gw::plot {
namespace {

constexpr double kMarginTop = 30;
constexpr double kMarginBottom = 42;
constexpr double kBarPitch = 22;
constexpr double kBarHeight = 14;
constexpr double kGap = 8;  // between labels and axes
constexpr double kTickSpacing = 80;

double PanelHeight(const BarPanel& panel) {
  const double markers = panel.marker ? kBarPitch : 0;
  return kMarginTop + kBarPitch * static_cast<double>(panel.bars.size()) + markers + kMarginBottom;
}

double TextWidth(const std::string& text) {
  return kCharWidth * static_cast<double>(text.size());
}

std::string RenderPanel(const BarPanel& panel, double left, double top, double width, int index) {
  double label_width = 0;
  double note_width = 0;
  double max = panel.marker.value_or(0);
  for (const Bar& bar : panel.bars) {
    // Bold letters are wider.
    label_width = std::max(label_width, (bar.bold ? 1.1 : 1.0) * TextWidth(bar.label));
    note_width = std::max(note_width, TextWidth(bar.note));
    max = std::max(max, bar.value.value_or(0));
  }
  if (panel.x_max) max = *panel.x_max;
  if (!(max > 0)) max = 1;
  const double x0 = left + label_width + 2 * kGap;
  const double bars_width = left + width - note_width - 2 * kGap - x0;
  const auto x_of = [&](double value) { return x0 + std::min(value / max, 1.0) * bars_width; };
  const double y0 = top + kMarginTop;
  const double y1 = top + PanelHeight(panel) - kMarginBottom;

  std::string out =
      Text(left + 0.5 * width, top + 18, panel.title, " text-anchor=\"middle\" font-size=\"13\"");
  const int ticks = std::max(2, static_cast<int>(bars_width / kTickSpacing));
  const double step = TickStep(max, ticks);
  for (const double tick : NiceTicks(0, max, ticks)) {
    out += Line(x_of(tick), y0, x_of(tick), y1, "stroke=\"#e0e0e0\"");
    out += Text(x_of(tick), y1 + 15, TickLabel(tick, step), " text-anchor=\"middle\"");
  }
  out += Line(x0, y0, x0, y1, "stroke=\"#404040\"");
  out += Line(x0, y1, x0 + bars_width, y1, "stroke=\"#404040\"");
  out += Text(x0 + 0.5 * bars_width, y1 + 33, panel.x_label, " text-anchor=\"middle\"");

  for (size_t i = 0; i < panel.bars.size(); ++i) {
    const Bar& bar = panel.bars[i];
    const double y = y0 + kBarPitch * (static_cast<double>(i) + 0.5);
    const std::string weight = bar.bold ? " font-weight=\"bold\"" : "";
    out += Text(x0 - kGap, y + 4, bar.label, " text-anchor=\"end\"" + weight);
    const double end = bar.value ? x_of(*bar.value) : x0;
    if (bar.value) {
      const std::string color = bar.color.empty() ? kPalette[0] : Escaped(bar.color);
      std::string fill = color;
      if (bar.hatched) {
        const std::string id = "hatch" + std::to_string(index) + "_" + std::to_string(i);
        out += "<pattern id=\"" + id +
               "\" width=\"6\" height=\"6\" patternUnits=\"userSpaceOnUse\" "
               "patternTransform=\"rotate(45)\"><rect width=\"6\" height=\"6\" fill=\"white\"/>"
               "<rect width=\"3\" height=\"6\" fill=\"" +
               color + "\"/></pattern>\n";
        fill = "url(#" + id + ")";
      }
      out += "<rect x=\"" + Px(x0) + "\" y=\"" + Px(y - 0.5 * kBarHeight) + "\" width=\"" +
             Px(std::max(1.0, end - x0)) + "\" height=\"" + Px(kBarHeight) + "\" fill=\"" + fill +
             "\" stroke=\"" + color + "\"/>\n";
    }
    out += Text(end + kGap, y + 4, bar.note, weight);
  }
  if (panel.marker) {
    const double x = x_of(*panel.marker);
    out += Line(x, y0, x, y1,
                "stroke=\"" + std::string(kPalette[1]) +
                    "\" stroke-width=\"1.5\" stroke-dasharray=\"6 4\"");
    out += Text(x + kGap, y1 - 7, panel.marker_label, " fill=\"" + std::string(kPalette[1]) + "\"");
  }
  return out;
}

}  // namespace

std::string RenderBars(const BarFigure& figure) {
  const int columns = std::max(1, figure.columns);
  const int panels = static_cast<int>(figure.panels.size());
  const double width = columns * figure.panel_width;
  double y = figure.title.empty() ? 0 : kHeaderHeight;
  std::string body = Header(width, figure.title);
  for (int row = 0; row * columns < panels; ++row) {
    double height = 0;
    for (int i = row * columns; i < std::min(panels, (row + 1) * columns); ++i) {
      const double x = (i % columns) * figure.panel_width;
      body += RenderPanel(figure.panels[i], x, y, figure.panel_width, i);
      height = std::max(height, PanelHeight(figure.panels[i]));
    }
    y += height;
  }
  const double height = y + kFooterLine * static_cast<double>(figure.footer.size()) + 4;
  return SvgBegin(width, height) + body + Footer(y, figure.footer) + "</svg>\n";
}

}  // namespace gw::plot
