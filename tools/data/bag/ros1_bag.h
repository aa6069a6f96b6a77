// ROS 1 bags, format 2.0 (ROS wiki, "Bags/Format/2.0"): records with a header of name=value fields,
// messages in chunks.
#pragma once

#include <memory>

#include "tools/data/bag/bag.h"

namespace gw::bag {

// bytes: the whole file; they must stay until the result is gone. Every input gives a result: what
// cannot be read is a warning. Precondition: IsRos1Bag(bytes).
std::unique_ptr<BagFile> ReadRos1Bag(Bytes bytes);

bool IsRos1Bag(Bytes bytes);

}  // namespace gw::bag
