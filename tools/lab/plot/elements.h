// Pieces of SVG text that the charts are made of. Inside of tools/lab/plot only.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace gw::plot {

// Distinct also for colour-blind readers (Okabe and Ito 2008).
inline constexpr std::array<const char*, 7> kPalette = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                                        "#e69f00", "#56b4e9", "#000000"};
inline constexpr double kCharWidth = 6.2;  // px, of the 11 px labels, about
inline constexpr double kHeaderHeight = 34;
inline constexpr double kFooterLine = 14;

std::string Px(double value);
std::string Escaped(const std::string& text);
// attributes: with a blank before each.
std::string Text(double x, double y, const std::string& text, const std::string& attributes = "");
std::string Line(double x0, double y0, double x1, double y1, const std::string& stroke);
std::string SvgBegin(double width, double height);  // ends with </svg>
// A figure's title, and small lines from `top` on.
std::string Header(double width, const std::string& title);
std::string Footer(double top, const std::vector<std::string>& lines);

// The distance of about `target` ticks over a span, and the label of a tick.
double TickStep(double span, int target);
std::string TickLabel(double value, double step);

// About `target` round values (1, 2 or 5 times a power of ten) that lie in [low, high], ascending.
// Precondition: finite, low < high, target >= 1.
std::vector<double> NiceTicks(double low, double high, int target);

}  // namespace gw::plot
