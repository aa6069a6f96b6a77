#include "frontend/core/motion/dr_trust.h"

#include <algorithm>

#include "common/core/covariance.h"

namespace gw::frontend {
namespace {

// Windows that contradict are many standard deviations off in one of the axes: faults of the kind
// looked for (a wrong unit, frame or factor) are off by tens of them, honest noise is off by this
// in one window of a million, and not in several in a row.
constexpr double kContradictionSigmas = 5;
// A slip that the DR filter has not noticed lasts a second or so. DR that has never agreed yet has
// no such credit.
constexpr int kContradicting = 3;  // windows
constexpr int kAgreeing = 5;       // windows
// Ways and turns below these show neither agreement nor fault.
constexpr double kMovedWay = 0.1;    // m
constexpr double kMovedTurn = 0.05;  // rad
// The ratio is a mean over about so many windows. A single one counts for no more than kMostRatio:
// a mean of squares has no other defence against a slip or a moment of wrong vision.
constexpr double kMemory = 20;
// What is known beforehand counts as much as so many windows.
constexpr double kPriorWindows = 5;
constexpr double kMostRatio = 9;

}  // namespace

void DrTrust::Judge(const DrEvidence& evidence) {
  const Vector6d error = (evidence.T_dr.inverse() * evidence.T_vision).Log();
  const Matrix6d S = evidence.cov_dr + evidence.cov_vision;
  const Vector6d ratio = error.cwiseAbs2().cwiseQuotient(S.diagonal());
  const bool contradicts = ratio.maxCoeff() > kContradictionSigmas * kContradictionSigmas;
  const bool moved = evidence.T_vision.translation().norm() > kMovedWay ||
                     LogSO3(evidence.T_vision.rotation()).norm() > kMovedTurn;
  contradicting_ = contradicts ? contradicting_ + 1 : 0;
  agreeing_ = contradicts ? 0 : agreeing_ + (moved ? 1 : 0);
  num_windows_ += moved ? 1 : 0;
  if (contradicts) vision_moved_ = moved;
  proven_ = proven_ || agreeing_ >= kAgreeing;
  if (trusted_ && contradicting_ >= (proven_ ? kContradicting : 1)) {
    trusted_ = false;
  } else if (!trusted_ && agreeing_ >= kAgreeing) {
    trusted_ = true;
  }
  ratio_ += (ratio.cwiseMin(trusted_ ? kMostRatio : ratio.maxCoeff()) - ratio_) / kMemory;
}

DrNoise DrTrust::Shown(const DrNoise& claimed) const {
  const Vector6d scale = ratio_.cwiseMax(1.0).cwiseSqrt();
  DrNoise out = claimed;
  out.white = scale.asDiagonal() * claimed.white * scale.asDiagonal();
  out.lever = scale.asDiagonal() * claimed.lever;
  return out;
}

Matrix6d DrTrust::Weighted(const Matrix6d& nominal, const Matrix6d& shown) const {
  const double prior = kPriorWindows / (kPriorWindows + num_windows_);
  return LargerCovariance(prior * prior * nominal, shown);
}

}  // namespace gw::frontend
