#include "tools/lab/plot/svg.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "common/core/format.h"
#include "tools/lab/plot/elements.h"

namespace gw::plot {
namespace {

constexpr double kMarginLeft = 64;
constexpr double kMarginRight = 16;
constexpr double kMarginTop = 34;
constexpr double kMarginBottom = 46;
constexpr double kTickSpacingX = 80;  // px between ticks, about
constexpr double kTickSpacingY = 45;

struct Range {
  double low = 0;
  double high = 1;
  double size() const { return high - low; }
};

// The data's range with a little air; a usable one also for no data or a single value.
Range DataRange(const Panel& panel, bool of_x) {
  Range range{INFINITY, -INFINITY};
  const auto include = [&range](double v) {
    if (!std::isfinite(v)) return;
    range.low = std::min(range.low, v);
    range.high = std::max(range.high, v);
  };
  for (const Series& series : panel.series) {
    for (const double v : of_x ? series.x : series.y) include(v);
  }
  if (of_x) {
    for (const Span& span : panel.spans) {
      include(span.x_begin);
      include(span.x_end);
    }
  }
  if (range.low > range.high) return {0, 1};
  const double air =
      range.size() > 0 ? 0.04 * range.size() : std::max(0.5, 0.1 * std::abs(range.low));
  return {range.low - air, range.high + air};
}

Range AxisRange(const Panel& panel, bool of_x) {
  const auto& fixed = of_x ? panel.x_range : panel.y_range;
  return fixed && fixed->first < fixed->second ? Range{fixed->first, fixed->second}
                                               : DataRange(panel, of_x);
}

void Grow(Range* range, double size) {
  const double middle = 0.5 * (range->low + range->high);
  *range = {middle - 0.5 * size, middle + 0.5 * size};
}

// One panel at a place of the figure, and the way from its data to its pixels.
class PanelRenderer {
 public:
  PanelRenderer(const Panel& panel, double x, double y, double width, double height, int index)
      : panel_(panel),
        left_(x + kMarginLeft),
        top_(y + kMarginTop),
        width_(width - kMarginLeft - kMarginRight),
        height_(height - kMarginTop - kMarginBottom),
        clip_id_("panel" + std::to_string(index)),
        x_range_(AxisRange(panel, true)),
        y_range_(AxisRange(panel, false)) {
    if (panel.equal_aspect) {
      const double unit = std::max(x_range_.size() / width_, y_range_.size() / height_);
      Grow(&x_range_, unit * width_);
      Grow(&y_range_, unit * height_);
    }
  }

  std::string Render() {
    Axes();
    out_ += "<clipPath id=\"" + clip_id_ + "\"><rect x=\"" + Px(left_) + "\" y=\"" + Px(top_) +
            "\" width=\"" + Px(width_) + "\" height=\"" + Px(height_) + "\"/></clipPath>\n";
    out_ += "<g clip-path=\"url(#" + clip_id_ + ")\">\n";
    for (const Span& span : panel_.spans) DrawSpan(span);
    for (size_t i = 0; i < panel_.series.size(); ++i) DrawSeries(panel_.series[i], ColorOf(i));
    out_ += "</g>\n";
    Legend();
    return std::move(out_);
  }

 private:
  double PixelX(double x) const { return left_ + (x - x_range_.low) / x_range_.size() * width_; }
  double PixelY(double y) const {
    return top_ + height_ - (y - y_range_.low) / y_range_.size() * height_;
  }
  std::string ColorOf(size_t index) const {
    const std::string& color = panel_.series[index].color;
    return color.empty() ? kPalette[index % kPalette.size()] : color;
  }

  void Axes() {
    const double bottom = top_ + height_;
    const std::string grid = "stroke=\"#e0e0e0\"";
    const int x_ticks = std::max(2, static_cast<int>(width_ / kTickSpacingX));
    const double x_step = TickStep(x_range_.size(), x_ticks);
    for (const double tick : NiceTicks(x_range_.low, x_range_.high, x_ticks)) {
      out_ += Line(PixelX(tick), top_, PixelX(tick), bottom, grid);
      out_ += Text(PixelX(tick), bottom + 15, TickLabel(tick, x_step), " text-anchor=\"middle\"");
    }
    const int y_ticks = std::max(2, static_cast<int>(height_ / kTickSpacingY));
    const double y_step = TickStep(y_range_.size(), y_ticks);
    for (const double tick : NiceTicks(y_range_.low, y_range_.high, y_ticks)) {
      out_ += Line(left_, PixelY(tick), left_ + width_, PixelY(tick), grid);
      out_ += Text(left_ - 6, PixelY(tick) + 4, TickLabel(tick, y_step), " text-anchor=\"end\"");
    }
    out_ += "<rect x=\"" + Px(left_) + "\" y=\"" + Px(top_) + "\" width=\"" + Px(width_) +
            "\" height=\"" + Px(height_) + "\" fill=\"none\" stroke=\"#404040\"/>\n";
    const double middle = left_ + 0.5 * width_;
    out_ += Text(middle, top_ - 12, panel_.title, " text-anchor=\"middle\" font-size=\"13\"");
    out_ += Text(middle, bottom + 34, panel_.x_label, " text-anchor=\"middle\"");
    const double label_x = left_ - kMarginLeft + 14;
    const double label_y = top_ + 0.5 * height_;
    out_ += Text(label_x, label_y, panel_.y_label,
                 " text-anchor=\"middle\" transform=\"rotate(-90 " + Px(label_x) + " " +
                     Px(label_y) + ")\"");
  }

  void DrawSpan(const Span& span) {
    const double x0 = PixelX(span.x_begin);
    const double x1 = PixelX(span.x_end);
    if (!std::isfinite(x0) || !std::isfinite(x1)) return;
    out_ += "<rect x=\"" + Px(std::min(x0, x1)) + "\" y=\"" + Px(top_) + "\" width=\"" +
            Px(std::max(1.0, std::abs(x1 - x0))) + "\" height=\"" + Px(height_) + "\" fill=\"" +
            Escaped(span.color) + "\" fill-opacity=\"0.15\"/>\n";
  }

  void DrawSeries(const Series& series, const std::string& color) {
    const size_t size = std::min(series.x.size(), series.y.size());
    std::string path;
    std::string points;
    std::string last;  // pixel drawn last; dense data would repeat it thousands of times
    bool pen_down = false;
    for (size_t i = 0; i < size; ++i) {
      if (!std::isfinite(series.x[i]) || !std::isfinite(series.y[i])) {
        pen_down = false;
        continue;
      }
      const std::string px = FormatFixed(PixelX(series.x[i]), 1);
      const std::string py = FormatFixed(PixelY(series.y[i]), 1);
      std::string at = px;
      at.append(" ").append(py);
      if (pen_down && at == last) continue;
      path.append(pen_down ? "L" : "M").append(at);
      points.append("<circle cx=\"").append(px).append("\" cy=\"").append(py);
      points.append("\" r=\"2\"/>\n");
      last = at;
      pen_down = true;
    }
    if (series.style != Style::kPoints && !path.empty()) {
      out_ += "<path d=\"" + path + "\" fill=\"none\" " + Stroke(series, color) + "/>\n";
    }
    if (series.style != Style::kLine && !points.empty()) {
      out_ += "<g fill=\"" + Escaped(color) + "\">\n" + points + "</g>\n";
    }
  }

  static std::string Stroke(const Series& series, const std::string& color) {
    return "stroke=\"" + Escaped(color) + "\" stroke-width=\"" + Px(series.width) +
           "\" stroke-linejoin=\"round\"" + (series.dashed ? " stroke-dasharray=\"6 4\"" : "");
  }

  void Legend() {
    struct Item {
      std::string label;
      std::string sample;  // drawn around the origin (0, 0) .. (22, 0)
    };
    std::vector<Item> items;
    for (size_t i = 0; i < panel_.series.size(); ++i) {
      const Series& series = panel_.series[i];
      if (series.label.empty()) continue;
      std::string sample;
      if (series.style != Style::kPoints) sample += Line(0, 0, 22, 0, Stroke(series, ColorOf(i)));
      if (series.style != Style::kLine) {
        sample += "<circle cx=\"11\" cy=\"0\" r=\"2.5\" fill=\"" + Escaped(ColorOf(i)) + "\"/>\n";
      }
      items.push_back({series.label, sample});
    }
    std::set<std::string> seen;
    for (const Span& span : panel_.spans) {
      if (span.label.empty() || !seen.insert(span.label).second) continue;
      items.push_back({span.label, "<rect x=\"0\" y=\"-5\" width=\"22\" height=\"10\" fill=\"" +
                                       Escaped(span.color) + "\" fill-opacity=\"0.15\"/>\n"});
    }
    if (items.empty()) return;
    size_t longest = 0;
    for (const Item& item : items) longest = std::max(longest, item.label.size());
    const double box_width = 40 + kCharWidth * static_cast<double>(longest);
    const double box_height = 8 + 16 * static_cast<double>(items.size());
    const double x = left_ + width_ - box_width - 6;
    const double y = top_ + 6;
    out_ += "<rect x=\"" + Px(x) + "\" y=\"" + Px(y) + "\" width=\"" + Px(box_width) +
            "\" height=\"" + Px(box_height) +
            "\" fill=\"white\" fill-opacity=\"0.8\" stroke=\"#c0c0c0\"/>\n";
    for (size_t i = 0; i < items.size(); ++i) {
      const double item_y = y + 12 + 16 * static_cast<double>(i);
      out_ += "<g transform=\"translate(" + Px(x + 6) + " " + Px(item_y) + ")\">\n" +
              items[i].sample + Text(28, 4, items[i].label) + "</g>\n";
    }
  }

  const Panel& panel_;
  double left_, top_, width_, height_;  // px, of the area inside the axes
  std::string clip_id_;
  Range x_range_;
  Range y_range_;
  std::string out_;
};

}  // namespace

std::string RenderSvg(const Figure& figure) {
  const int columns = std::max(1, figure.columns);
  const int panels = static_cast<int>(figure.panels.size());
  const int rows = (panels + columns - 1) / columns;
  const double header = figure.title.empty() ? 0 : kHeaderHeight;
  const double width = columns * figure.panel_width;
  const double panels_end = header + rows * figure.panel_height;
  const double height = panels_end + kFooterLine * static_cast<double>(figure.footer.size());
  std::string out = SvgBegin(width, height);
  out += Header(width, figure.title);
  for (int i = 0; i < panels; ++i) {
    const int row = i / columns;
    const double x = (i % columns) * figure.panel_width;
    const double y = header + row * figure.panel_height;
    out +=
        PanelRenderer(figure.panels[i], x, y, figure.panel_width, figure.panel_height, i).Render();
  }
  return out + Footer(panels_end, figure.footer) + "</svg>\n";
}

}  // namespace gw::plot
