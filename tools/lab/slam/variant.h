// Variants as on a command line.
#pragma once

#include <string>

#include "common/config/frontend_config.h"
#include "common/core/result.h"

namespace gw::tools {

// none, da, pe, lba, full, switch or fixed:ALPHA (which sets the scale too). Error
// kInvalidArgument: what may stand there.
Result<Done> ApplyVariant(const std::string& text, FrontendConfig* config);

std::string VariantName(Variant variant);

}  // namespace gw::tools
