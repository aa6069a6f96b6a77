// Status and reason of an image as frames.csv, report.json and gw-view name them.
#pragma once

#include "common/contract/tracking.h"

namespace gw {

// "tracking", "dr_only", ...
const char* StatusName(TrackingStatus status);
// "none", "too_few_features", ...
const char* ReasonName(TrackingReason reason);

}  // namespace gw
