#include "tools/lab/plot/drawing.h"

#include <cmath>

#include "tools/data/files/json.h"

namespace gw::plot {
namespace {

using tools::Json;
using tools::ValueOrNull;

// Six digits are more than a screen shows. What is not finite becomes null, which lifts the pen.
Json Values(const std::vector<double>& values) {
  Json out = Json::array();
  for (const double v : values) {
    if (!std::isfinite(v) || v == 0) {
      out.push_back(std::isfinite(v) ? Json(0) : Json(nullptr));
      continue;
    }
    const double scale = std::pow(10, 5 - std::floor(std::log10(std::abs(v))));
    out.push_back(std::round(v * scale) / scale);
  }
  return out;
}

Json RangeOrNull(const std::optional<std::pair<double, double>>& range) {
  return range ? Json({range->first, range->second}) : Json(nullptr);
}

Json PanelJson(const Panel& panel) {
  Json series = Json::array(), spans = Json::array();
  for (const Series& s : panel.series) {
    series.push_back({{"label", s.label},
                      {"x", Values(s.x)},
                      {"y", Values(s.y)},
                      {"line", s.style != Style::kPoints},
                      {"points", s.style != Style::kLine},
                      {"color", s.color},
                      {"dashed", s.dashed},
                      {"width", s.width}});
  }
  for (const Span& s : panel.spans) {
    spans.push_back(
        {{"x_begin", s.x_begin}, {"x_end", s.x_end}, {"label", s.label}, {"color", s.color}});
  }
  return {{"title", panel.title},
          {"x_label", panel.x_label},
          {"y_label", panel.y_label},
          {"equal_aspect", panel.equal_aspect},
          {"x_range", RangeOrNull(panel.x_range)},
          {"y_range", RangeOrNull(panel.y_range)},
          {"series", std::move(series)},
          {"spans", std::move(spans)}};
}

Json PanelJson(const BarPanel& panel) {
  Json bars = Json::array();
  for (const Bar& bar : panel.bars) {
    bars.push_back({{"label", bar.label},
                    {"value", ValueOrNull(bar.value)},
                    {"note", bar.note},
                    {"hatched", bar.hatched},
                    {"bold", bar.bold},
                    {"color", bar.color}});
  }
  return {{"title", panel.title},
          {"x_label", panel.x_label},
          {"bars", std::move(bars)},
          {"x_max", ValueOrNull(panel.x_max)},
          {"marker", ValueOrNull(panel.marker)},
          {"marker_label", panel.marker_label}};
}

template <typename AnyFigure>
Json FigureJson(const AnyFigure& figure) {
  Json panels = Json::array();
  for (const auto& panel : figure.panels) panels.push_back(PanelJson(panel));
  return {{"title", figure.title}, {"panels", std::move(panels)}, {"footer", figure.footer}};
}

}  // namespace

Drawing Draw(const Figure& figure) {
  return {RenderSvg(figure), tools::JsonLine(FigureJson(figure))};
}

Drawing Draw(const BarFigure& figure) {
  return {RenderBars(figure), tools::JsonLine(FigureJson(figure))};
}

}  // namespace gw::plot
