// A log of the bus as an MCAP file with the topics of gw-view.
#pragma once

#include <string>

#include "common/core/result.h"
#include "tools/data/foxglove/translator.h"

namespace gw::foxglove {

struct McapSummary {
  uint64_t messages = 0;
  uint64_t bytes = 0;
  int64_t undecodable = 0;  // messages of the log that were left out
};

// Errors: kNotFound, kIo (the path, what the system says).
Result<McapSummary> ExportMcap(const std::string& log, const TranslatorOptions& options,
                               const std::string& out);

}  // namespace gw::foxglove
