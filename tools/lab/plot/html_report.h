// Drawings and tables of a benchmark or a study as one HTML file.
#pragma once

#include <string>
#include <vector>

#include "common/core/result.h"
#include "tools/lab/plot/drawing.h"

namespace gw::plot {

// With charts that zoom and show values; in the plain form, which says so, where the page of
// gw-view was not built. Error kBadData: what was built is another page.
Result<std::string> RenderHtml(const std::string& title, const std::vector<Drawing>& drawings,
                               const std::string& markdown);

}  // namespace gw::plot
