// How much an image, or a pose, must show before it means anything of the place.
#pragma once

namespace gw::frontend {

inline constexpr int kRichImage = 200;  // features: what such an image does not show is not there
inline constexpr int kByChance = 30;    // fewer inliers, or features found again, prove nothing

}  // namespace gw::frontend
