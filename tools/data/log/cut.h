// A piece of a log.
#pragma once

#include <cstdint>
#include <string>

#include "common/core/result.h"
#include "tools/data/log/span.h"

namespace gw::tools {

struct CutSummary {
  int64_t events = 0;  // written
  int64_t bytes = 0;
  bool source_truncated = false;
  int64_t source_skipped_bytes = 0;
};

// Copies the events received in the span (of the time of LogClock) byte by byte. All notes
// before the span are kept, moved to its begin, and one is added that says what was cut. Works with
// damaged logs. `to` appears only when it is complete. Error: kNotFound, kIo, kBadData when the
// span holds nothing, kInvalidArgument when both names are the same file.
Result<CutSummary> CutLog(const std::string& from, const Span& span, const std::string& to);

}  // namespace gw::tools
