// Spans of time on a command line.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "common/core/result.h"
#include "common/core/time.h"

namespace gw::tools {

// [begin, end), counted from the begin of the log.
struct Span {
  DurationUs begin = {0};
  DurationUs end = {std::numeric_limits<int64_t>::max()};

  bool Contains(DurationUs since_begin) const { return since_begin >= begin && since_begin < end; }
};

// "T0:T1" in seconds with further numbers behind colons: "T0:T1:A:B" gives {span, {A, B}}. An empty
// T0 is the begin, an empty T1 the end of the log. Error kInvalidArgument: names the option, with
// the number of further values outside [min_values, max_values], with T1 <= T0, or with anything
// that is no finite number that is not negative.
struct SpanArgument {
  Span span;
  std::vector<double> values;
};
Result<SpanArgument> ParseSpan(const std::string& option, const std::string& text,
                               size_t min_values = 0, size_t max_values = 0);

}  // namespace gw::tools
