// Applies a FaultPlan to a log.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "tools/data/fault/fault_injector.h"

namespace gw::fault {

using Progress = std::function<void(int64_t bytes_done, int64_t bytes_total)>;

// What FaultInjector makes of the log `from`. `to` appears only when it is complete. Error:
// kNotFound, kIo, kBadData (empty log), kInvalidArgument (same file).
Result<FaultSummary> ApplyFaults(const std::string& from, const FaultPlan& plan,
                                 const std::string& to, const Progress& progress);

}  // namespace gw::fault
