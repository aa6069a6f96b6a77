// Algebra of the error state of FilterState: the updates and moves that all parts of DrModel share.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "dr_ekf/core/filter_state.h"
#include "dr_ekf/core/noise_model.h"

namespace gw::dr_ekf {

inline constexpr double kRadPerDeg = 0.017453292519943295;

// Specific force at rest, in O.
inline const Eigen::Vector3d kUp(0, 0, kGravity);

inline double Square(double x) {
  return x * x;
}

inline double WrapAngle(double a) {
  return std::remainder(a, 2 * M_PI);
}

// What an update may do to the pose.
enum class PoseUpdate {
  kCorrect,    // the pose was estimated without this measurement, which corrects it
  kDefineWay,  // the measurement is the way: what it does to the place is no correction
  kDefine,     // the measurement is the motion, in full, and parameters learn nothing from it
  kTrackOnly,  // only the scale of the wheels' turn moves, P stays honest
  kHold,       // pose and velocity do not move (Schmidt's consider update), P stays honest
};

// One Kalman update with innovation = H * error + noise of covariance R. Rows: 1 or 3.
template <int kRows>
void Update(const Eigen::Matrix<double, kRows, kErrorSize>& H,
            const Eigen::Matrix<double, kRows, 1>& innovation,
            const Eigen::Matrix<double, kRows, kRows>& R, PoseUpdate mode, FilterState& state);

// Error map that touches only pose and velocity (the first nine errors).
using TopTransition = Eigen::Matrix<double, 9, kClone>;

void ApplyTransition(const TopTransition& F, FilterState& state);

// The sums of a new wheel sample: their errors are unknown to the state, with this covariance.
void BeginSum(const Eigen::Matrix2d& cov, FilterState& state);

// A wheel interval begins: its pose, and the errors of its sample's sums, stay in the state until
// the next one.
void ClonePose(Utime utime, FilterState& state);

}  // namespace gw::dr_ekf
