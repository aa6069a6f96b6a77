// What may be wrong with what a camera shows, though it is still tracked.
#pragma once

#include <string_view>

namespace gw::frontend {

enum class ViewFault { kNone, kFlickers, kLeftCovered, kRightCovered, kDepthLate, kDepthEarly };

// In words for HEALTH: what, and what to do about it; empty for none.
std::string_view Describe(ViewFault fault);

}  // namespace gw::frontend
