// What is wrong with an image's pose, in words for HEALTH and the log of a study: what, and what to
// do about it.
#pragma once

#include <string>

#include "common/contract/tracking.h"
#include "frontend/core/features/view_fault.h"
#include "frontend/core/motion/dr_disagreement.h"
#include "frontend/core/motion/scale_witness.h"

namespace gw::frontend {

// Empty: nothing. fault: the constant by which dead reckoning is wrong, where one is known;
// lengths: what is wrong with the camera's; view: with its images.
std::string HealthCause(const FramePose& frame, const DrConstantFault& fault,
                        const LengthFault& lengths, ViewFault view);

}  // namespace gw::frontend
