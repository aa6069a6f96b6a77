#include "tools/sim/demo/charts.h"

#include <algorithm>
#include <cmath>

#include "tools/robot/floorplan/contours.h"

namespace gw::demo {
namespace {

using plot::Panel;
using plot::Series;

constexpr double kWallTolerance = 1.45;  // cells, of outlines
constexpr int kLatencyBins = 60;

void Add(const Eigen::Vector2d& p, Series* series) {
  series->x.push_back(p.x());
  series->y.push_back(p.y());
}

void AddWalls(const floorplan::FloorMap& map, Panel* panel) {
  Series walls;
  walls.label = "walls of the map";
  walls.color = "#707070";
  walls.width = 1.2;
  for (const auto& contour : floorplan::TraceContours(map, kWallTolerance * map.resolution)) {
    for (const Eigen::Vector2d& p : contour.vertices) Add(p, &walls);
    Add(contour.vertices.front(), &walls);
    Add({NAN, NAN}, &walls);
  }
  panel->series.push_back(std::move(walls));
}

Panel OverTime(const RunAnalysis& run, const std::string& title, const std::string& unit) {
  Panel panel;
  panel.title = title;
  panel.x_label = "s";
  panel.y_label = unit;
  panel.x_range = {0, std::max(1.0, run.seconds())};
  for (const auto& [begin, end] : run.blind) panel.spans.push_back({begin, end, ""});
  return panel;
}

template <typename Value>
void AddSeries(const RunAnalysis& run, Value&& value, Panel* panel) {
  Series series;
  for (const FramePoint& frame : run.frames) {
    series.x.push_back(frame.t);
    series.y.push_back(value(frame));
  }
  panel->series.push_back(std::move(series));
}

}  // namespace

plot::Drawing FloorChart(const RunAnalysis& run, const std::optional<floorplan::FloorMap>& map) {
  plot::Figure figure;
  figure.panel_width = 1000;
  figure.panel_height = 720;
  Panel panel;
  panel.equal_aspect = true;
  panel.x_label = panel.y_label = "m";
  if (map && run.has_truth) AddWalls(*map, &panel);
  Series truth{"true way", {}, {}};
  truth.color = "#000000";
  truth.dashed = true;
  Series seen{"estimate, camera sees", {}, {}};
  seen.color = "#0072b2";
  seen.width = 2;
  Series blind{"estimate, camera blind", {}, {}};
  blind.color = "#d55e00";
  blind.width = 3.5;
  for (const FramePoint& frame : run.frames) {
    if (frame.truth) Add(*frame.truth, &truth);
    Add(IsBlind(frame.status) ? Eigen::Vector2d(NAN, NAN) : frame.position, &seen);
    Add(IsBlind(frame.status) ? frame.position : Eigen::Vector2d(NAN, NAN), &blind);
  }
  panel.series.push_back(std::move(seen));
  panel.series.push_back(std::move(blind));
  if (run.has_truth) panel.series.push_back(std::move(truth));
  figure.panels.push_back(std::move(panel));
  return Draw(figure);
}

plot::Drawing TimeChart(const RunAnalysis& run) {
  plot::Figure figure;
  figure.panel_width = 1000;
  figure.panel_height = 250;
  Panel quality = OverTime(run, "Q, health of tracking", "Q");
  quality.y_range = {-0.03, 1.03};
  AddSeries(
      run, [](const FramePoint& f) { return f.q; }, &quality);
  Panel alpha = OverTime(run, "alpha, weight of dead reckoning", "log10 alpha");
  alpha.y_range = {-1.5, 3.5};
  AddSeries(
      run, [](const FramePoint& f) { return f.alpha > 0 ? std::log10(f.alpha) : NAN; }, &alpha);
  figure.panels = {std::move(quality), std::move(alpha)};
  if (run.has_truth) {
    Panel error = OverTime(run, "distance of the estimate from the truth", "m");
    AddSeries(
        run, [](const FramePoint& f) { return f.error_m.value_or(NAN); }, &error);
    figure.panels.push_back(std::move(error));
  }
  return Draw(figure);
}

plot::Drawing LatencyChart(const RunAnalysis& run) {
  std::vector<double> sorted;
  for (const FramePoint& frame : run.frames) {
    if (frame.latency_ms > 0) sorted.push_back(frame.latency_ms);
  }
  std::sort(sorted.begin(), sorted.end());
  plot::Figure figure;
  figure.panel_width = 1000;
  figure.panel_height = 260;
  Panel panel;
  panel.title = "latency: image on the bus to pose on the bus";
  panel.x_label = "ms; the last 1 % are beyond the right edge";
  panel.y_label = "images";
  if (!sorted.empty()) {
    const double longest =
        sorted[static_cast<size_t>(0.99 * static_cast<double>(sorted.size() - 1))];
    const double width = std::max(0.1, longest) / kLatencyBins;
    std::vector<int> counts(kLatencyBins, 0);
    for (const double latency : sorted) {
      const int bin = static_cast<int>(latency / width);
      if (bin < kLatencyBins) ++counts[bin];
    }
    Series steps;
    for (int bin = 0; bin < kLatencyBins; ++bin) {
      for (const int edge : {bin, bin + 1}) Add({edge * width, counts[bin]}, &steps);
    }
    panel.series.push_back(std::move(steps));
    panel.x_range = {0, longest};
  }
  figure.panels.push_back(std::move(panel));
  return Draw(figure);
}

}  // namespace gw::demo
