#include "tools/lab/plot/elements.h"

#include <algorithm>
#include <cmath>

#include "common/core/format.h"

namespace gw::plot {

std::string Px(double value) {
  return FormatFixed(value, 2);
}

std::string Escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string Text(double x, double y, const std::string& text, const std::string& attributes) {
  if (text.empty()) return "";
  return "<text x=\"" + Px(x) + "\" y=\"" + Px(y) + "\"" + attributes + ">" + Escaped(text) +
         "</text>\n";
}

std::string Line(double x0, double y0, double x1, double y1, const std::string& stroke) {
  return "<line x1=\"" + Px(x0) + "\" y1=\"" + Px(y0) + "\" x2=\"" + Px(x1) + "\" y2=\"" + Px(y1) +
         "\" " + stroke + "/>\n";
}

std::string SvgBegin(double width, double height) {
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + FormatFixed(width, 0) +
         "\" height=\"" + FormatFixed(height, 0) + "\" viewBox=\"0 0 " + FormatFixed(width, 0) +
         " " + FormatFixed(height, 0) +
         "\" font-family=\"sans-serif\" font-size=\"11\">\n"
         "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
}

std::string Header(double width, const std::string& title) {
  return Text(0.5 * width, 24, title, " text-anchor=\"middle\" font-size=\"16\"");
}

std::string Footer(double top, const std::vector<std::string>& lines) {
  std::string out;
  for (size_t i = 0; i < lines.size(); ++i) {
    out += Text(12, top + kFooterLine * static_cast<double>(i + 1) - 4, lines[i],
                " font-size=\"10\" fill=\"#606060\"");
  }
  return out;
}

double TickStep(double span, int target) {
  const double raw = span / target;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (raw <= factor * power * (1 + 1e-9)) return factor * power;
  }
  return 10.0 * power;
}

std::string TickLabel(double value, double step) {
  const double size = std::max(std::abs(value), step);
  if (size >= 1e7 || step < 1e-6) return FormatDouble(value);
  return FormatFixed(value, std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9))));
}

std::vector<double> NiceTicks(double low, double high, int target) {
  const double step = TickStep(high - low, target);
  const double slack = 1e-9 * step;
  std::vector<double> ticks;
  // Multiples of the step, not sums: sums would gather rounding errors.
  for (double k = std::ceil((low - slack) / step); k * step <= high + slack; ++k) {
    ticks.push_back(k * step + 0.0);  // + 0.0 turns -0 into 0
  }
  return ticks;
}

}  // namespace gw::plot
