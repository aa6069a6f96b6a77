// Do two answers about a place say the same? One law for the front-end, which compares answers of
// the back-end, and the back-end, which compares sights of one piece of the map in another.
#pragma once

#include "common/core/se3.h"

namespace gw {

// A fixed part for the fits of two images, whose poses are found to a few centimetres at places a
// few metres away, and one that grows with the way between them, along which dead reckoning and
// pieces of a map drift: five per cent (docs/adr/0009-loops-and-relocalisation.md).
inline constexpr double kAgreeTranslation = 0.15;  // m
inline constexpr double kAgreeRotation = 0.06;     // rad
inline constexpr double kAgreePerMetre = 0.05;     // m/m and rad/m

// True when two poses that should be the same (error between them) are one place. way: m, >= 0,
// that lies between the two images.
inline bool SamePlace(const SE3& error, double way = 0) {
  return error.translation().norm() < kAgreeTranslation + kAgreePerMetre * way &&
         LogSO3(error.rotation()).norm() < kAgreeRotation + kAgreePerMetre * way;
}

}  // namespace gw
