// Variants as on a command line.
//
//   VARIANT   = [METHOD ":"] NAME { CHANGE }
//   METHOD    = "paper" | "ours"                         without: as the configuration says
//   NAME      = "none" | "da" | "pe" | "lba" | "full" | "switch" | "fixed:" ALPHA
//   CHANGE    = "+" DEPARTURE | "-" DEPARTURE            one departure more, or one less
//
// DEPARTURE: a name of kDepartures (common/config/departure.h; docs/method.md, section 10, says
// what each is). "paper:full+bound" is the paper and one change, "full-bound" ours without one.
#pragma once

#include <string>

#include "common/config/frontend_config.h"
#include "common/core/result.h"

namespace gw::tools {

// "fixed:ALPHA" sets the scale too. Error kInvalidArgument: what may stand there.
Result<Done> ApplyVariant(const std::string& text, FrontendConfig* config);

// The same, the other way round; without ALPHA, which is in the configuration.
std::string VariantName(const FrontendConfig& config);

}  // namespace gw::tools
