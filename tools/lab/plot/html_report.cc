#include "tools/lab/plot/html_report.h"

#include "common/core/version.h"
#include "tools/data/files/json.h"
#include "tools/view/report/report_page.h"

namespace gw::plot {

Result<std::string> RenderHtml(const std::string& title, const std::vector<Drawing>& drawings,
                               const std::string& markdown) {
  const std::string page = view::ReportTemplate();
  if (page.empty()) {
    std::vector<std::string> svgs;
    svgs.reserve(drawings.size());
    for (const Drawing& drawing : drawings) svgs.push_back(drawing.svg);
    return view::RenderPlainReport(title, svgs, markdown);
  }
  view::Report report;
  report.title = title;
  report.lead = std::string("Good Weights ") + Version() +
                ". Draw a rectangle in a chart to zoom, double click to see all again.";
  for (const Drawing& drawing : drawings) report.figures.push_back(drawing.json);
  report.markdown = markdown;
  return view::RenderReport(page, report);
}

}  // namespace gw::plot
