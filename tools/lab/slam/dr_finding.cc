#include "tools/lab/slam/dr_finding.h"

#include <algorithm>

#include "tools/data/files/format.h"
#include "tools/data/files/json.h"

namespace gw::tools {

std::string Describe(const DrFinding& finding, Utime first_state) {
  const double after_s = std::max(0.0, (finding.utime - first_state).seconds());
  return Format("after %.2f s: ", after_s) + std::string(dr_ekf::Text(finding.diagnosis));
}

Json FoundJson(const std::vector<DrFinding>& found) {
  Json out = Json::array();
  for (const DrFinding& finding : found) {
    out.push_back({{"utime", finding.utime.us}, {"what", std::string(Name(finding.diagnosis))}});
  }
  return out;
}

}  // namespace gw::tools
