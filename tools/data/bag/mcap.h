// MCAP files (mcap.dev, "MCAP Format Specification", version 0).
#pragma once

#include <memory>

#include "tools/data/bag/bag.h"

namespace gw::bag {

// bytes: the whole file; they must stay until the result is gone. Every input gives a result: what
// cannot be read is a warning. Precondition: IsMcap(bytes).
std::unique_ptr<BagFile> ReadMcap(Bytes bytes);

bool IsMcap(Bytes bytes);

}  // namespace gw::bag
