// Reports as one HTML file that needs nothing else: the parts of gw-view's page (3-D view, camera
// image, charts that zoom and show values) with the data embedded. Where the page was not built, a
// plain form: text and drawings, which says so.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "common/core/result.h"
#include "tools/data/files/json_fwd.h"

namespace gw::view {

// The folder of that name beside the running program, of an installation or of a build folder, if
// it holds the file; else "". names: "view" (the page of gw-view), "report".
std::string PageFolder(const std::string& name, const std::string& file);

struct Report {
  std::string title;
  std::string lead;  // a paragraph below the title
  std::vector<std::pair<std::string, std::string>> facts;
  std::vector<tools::Json> messages;  // of a run: [topic of gw-view, message], as they came
  std::vector<std::string> figures;   // plot::Drawing::json
  std::string markdown;               // text and tables, below
};

// The page that reports are made of; "" when it was not built.
std::string ReportTemplate();

// The template with the data of the report in it. Error kBadData: it is not that template.
Result<std::string> RenderReport(const std::string& page, const Report& report);

// The form without scripts, for drawings and Markdown: drawings are SVG text.
std::string RenderPlainReport(const std::string& title, const std::vector<std::string>& drawings,
                              const std::string& markdown);

// What a plain report says of itself, as HTML.
inline constexpr char kPlainNote[] =
    "<p><em>Plain form: the page of gw-view was not built (npm was missing, or its registry could "
    "not be reached). With it, target <code>gw_view_page</code>, the charts zoom and show "
    "values.</em></p>\n";

// Text as the content of an HTML element.
std::string EscapeHtml(const std::string& text);

}  // namespace gw::view
