// Quantiles of the chi-square distribution, from its tables: the limits of squared errors that are
// normal and divided by their covariance. Named by degrees of freedom and probability.
#pragma once

namespace gw {

inline constexpr double kChi2One95 = 3.841;   // 95 %
inline constexpr double kChi2One999 = 10.83;  // 99.9 %
inline constexpr double kChi2Two95 = 5.991;   // 95 %
inline constexpr double kChi2Six99 = 16.81;   // 99 %
inline constexpr double kChi2Six999 = 22.46;  // 99.9 %

}  // namespace gw
