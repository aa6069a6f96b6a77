#include "common/good_weights/dr_history.h"

#include <algorithm>
#include <cmath>

namespace gw {
namespace {

// Standard deviation of the acceleration of a robot on wheels, forwards and about the vertical. The
// limits of TurtleBot2's velocity smoother (1 m/s^2, 2 rad/s^2) are two of them; the wheels of five
// recorded robots have 0.13 to 0.8 m/s^2 and 0.27 to 1.0 rad/s^2 while they move.
constexpr double kSigmaAcceleration = 0.5;  // m/s^2
constexpr double kSigmaTurning = 1.0;       // rad/s^2

SE3 Extrapolate(const DrState& state, Utime utime) {
  const double dt = (utime - state.utime).seconds();
  Vector6d twist;
  twist << state.v_OB_B, state.w_OB_B;
  return state.T_OB * SE3::Exp(twist * dt);
}

// First state at or after utime.
std::deque<DrState>::const_iterator FirstNotBefore(const std::deque<DrState>& states, Utime utime) {
  return std::lower_bound(states.begin(), states.end(), utime,
                          [](const DrState& s, Utime t) { return s.utime < t; });
}

// Lower triangular L with L L^T = cov, which may be singular; not pivoted, so that an axis stays
// the same from one state to the next.
Matrix6d Factor(const Matrix6d& cov) {
  Matrix6d L = Matrix6d::Zero();
  for (int k = 0; k < 6; ++k) {
    const double pivot = cov(k, k) - L.row(k).head(k).squaredNorm();
    if (!(pivot > 1e-12 * cov(k, k))) continue;
    L(k, k) = std::sqrt(pivot);
    for (int i = k + 1; i < 6; ++i) {
      L(i, k) = (cov(i, k) - L.row(i).head(k).dot(L.row(k).head(k))) / L(k, k);
    }
  }
  return L;
}

// Sigmas of the common errors that the state tells. twist: the factor of its covariance C.
DrCommon Sigmas(const DrState& state, const Matrix6d& twist) {
  DrCommon sigma;
  sigma << twist.diagonal(), state.way_scale_sigma, state.turn_scale_sigma;
  return sigma;
}

}  // namespace

Matrix6d DrNoise::Covariance() const {
  return white + lever * coherent * lever.transpose();
}

void DrNoise::Begin(const DrState& state) {
  sigma_ = Sigmas(state, Factor(state.cov_twist_coherent));
}

// From the common errors of before to those of now, which have these sigmas: what is not common to
// both no longer goes on.
void DrNoise::Follow(const DrCommon& sigma) {
  for (int k = 0; k < sigma.size(); ++k) {
    // Not told, as while the robot stands still: what was known is not forgotten.
    if (!(sigma[k] > 0)) continue;
    if (sigma_[k] > 0) {
      const double correlation = std::min(sigma[k], sigma_[k]) / std::max(sigma[k], sigma_[k]);
      const Vector6d part = lever.col(k);
      white += (1 - correlation * correlation) * part * part.transpose();
      lever.col(k) *= correlation;
      kept[k] *= correlation;
    }
    sigma_[k] = sigma[k];
  }
}

void DrNoise::Append(const DrState& state, const SE3& T_step, double dt_s) {
  const Matrix6d twist = Factor(state.cov_twist_coherent);
  Follow(Sigmas(state, twist));
  const Matrix6d adj = T_step.inverse().Adjoint();
  white = adj * white * adj.transpose() + state.cov_twist_white * dt_s;
  lever = (adj * lever).eval();
  lever.leftCols<6>() += twist * dt_s;
  lever.col(kWayScale).head<3>() += state.way_scale_sigma * state.v_OB_B * dt_s;
  lever.col(kTurnScale).tail<3>() += state.turn_scale_sigma * state.w_OB_B * dt_s;
}

bool DrHistory::Push(const DrState& state) {
  const ClockWatch::Verdict verdict = clock_.Judge(state.utime);
  const bool behind = !states_.empty() && state.utime <= states_.back().utime;
  if (behind) {
    const bool restarted = state.reset_counter != states_.back().reset_counter;
    if (!restarted && verdict != ClockWatch::Verdict::kSetBack) return false;
    states_.clear();
    clock_ = ClockWatch();
    clock_.Judge(state.utime);
  }
  states_.push_back(state);
  while (states_.size() > 2 && states_.back().utime - states_.front().utime > window_) {
    states_.pop_front();
  }
  return true;
}

std::optional<SE3> DrHistory::PoseAt(Utime utime) const {
  if (states_.empty() || utime < states_.front().utime) return std::nullopt;
  const auto after = FirstNotBefore(states_, utime);
  if (after == states_.end()) {
    if (utime - states_.back().utime > kMaxDrExtrapolation) return std::nullopt;
    return Extrapolate(states_.back(), utime);
  }
  if (after->utime == utime) return after->T_OB;
  const auto before = std::prev(after);
  if (before->reset_counter != after->reset_counter) return std::nullopt;
  const double fraction =
      (utime - before->utime).seconds() / (after->utime - before->utime).seconds();
  return Interpolate(before->T_OB, after->T_OB, fraction);
}

// A constant acceleration A leads A s r / 2 away from the straight line between two states, s after
// the one and r before the other, and A s^2 / 2 away from going on at the velocity of the newest.
Matrix6d DrHistory::BetweenStates(Utime utime) const {
  Matrix6d out = Matrix6d::Zero();
  const auto after = FirstNotBefore(states_, utime);
  if (after == states_.begin() || states_.back().synthetic) return out;
  const double s = (utime - std::prev(after)->utime).seconds();
  const double r = after == states_.end() ? s : (after->utime - utime).seconds();
  out(0, 0) = std::pow(kSigmaAcceleration * s * r / 2, 2);
  out(5, 5) = std::pow(kSigmaTurning * s * r / 2, 2);
  return out;
}

std::optional<DrIncrement> DrHistory::Increment(Utime a, Utime b, DrNoise* noise) const {
  if (b < a) return std::nullopt;
  const std::optional<SE3> T_OBa = PoseAt(a);
  const std::optional<SE3> T_OBb = PoseAt(b);
  if (!T_OBa || !T_OBb) return std::nullopt;

  DrIncrement out;
  out.utime_begin = a;
  out.utime_end = b;
  out.T_BaBb = T_OBa->inverse() * *T_OBb;

  // States that shape the interval: those inside it, and the one at or after its end (or the
  // newest).
  auto it = FirstNotBefore(states_, a);
  if (it == states_.end()) --it;
  out.reset_counter = it->reset_counter;

  DrNoise sum;
  sum.Begin(*it);
  Utime from = a;
  SE3 T_OB_from = *T_OBa;
  for (; it != states_.end(); ++it) {
    if (it->reset_counter != out.reset_counter) return std::nullopt;
    out.slip |= it->slip;
    out.synthetic |= it->synthetic;
    const bool last = it->utime >= b || std::next(it) == states_.end();
    const Utime to = last ? b : it->utime;
    const SE3& T_OB_to = last ? *T_OBb : it->T_OB;
    if (to > from) sum.Append(*it, T_OB_from.inverse() * T_OB_to, (to - from).seconds());
    from = to;
    T_OB_from = T_OB_to;
    if (last) break;
  }
  if (b > a) {
    const Matrix6d adj = out.T_BaBb.inverse().Adjoint();
    sum.white += adj * BetweenStates(a) * adj.transpose() + BetweenStates(b);
  }
  out.cov = sum.Covariance();
  if (noise != nullptr) *noise = sum;
  return out;
}

}  // namespace gw
