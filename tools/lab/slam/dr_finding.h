// What the DR filter found wrong with its inputs in a run, and when.
#pragma once

#include <string>
#include <vector>

#include "common/core/time.h"
#include "dr_ekf/core/dr_diagnosis.h"
#include "tools/data/files/json_fwd.h"

namespace gw::tools {

struct DrFinding {
  Utime utime;  // of the newest state before; 0: before the first one
  dr_ekf::DrDiagnosis diagnosis;
};

// "after 3.20 s: ...", counted from the first state; one sentence for people.
std::string Describe(const DrFinding& finding, Utime first_state);

// utime and what (the name of dr.found.*) of each.
Json FoundJson(const std::vector<DrFinding>& found);

}  // namespace gw::tools
