// Are the two images of a stereo pair those of two eyes, in their order? Asked where hardly any
// feature has a disparity: a driver or a bag that gives one eye twice, or left and right exchanged.
#pragma once

#include "frontend/core/features/row_index.h"

namespace gw::frontend {

enum class EyeOrder {
  kPlausible,
  kOneTwice,   // both images are the same: features are found again at the same place
  kExchanged,  // what is near lies further right in the right image
};

// Decided by the features of which only one in the other image is alike, on the same rows; a
// thousand to one (LogOdds).
EyeOrder JudgeEyeOrder(const StereoSide& left, const StereoSide& right);

}  // namespace gw::frontend
