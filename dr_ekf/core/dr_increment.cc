// DrFilter::Increment: relative motion from the filter's own history.
#include <algorithm>

#include "dr_ekf/core/dr_filter.h"

namespace gw::dr_ekf {
namespace {

using ErrorPoseMatrix = Eigen::Matrix<double, kErrorSize, 6>;

// Covariance of inv(T_a) * T_b from the marginals and the cross covariance of the pose errors.
Matrix6d RelativeCovariance(const SE3& T_ab, const Matrix6d& cov_a, const Matrix6d& cov_b,
                            const Matrix6d& cov_ba) {
  const Matrix6d adj = T_ab.inverse().Adjoint();
  const Matrix6d cross = adj * cov_ba.transpose();
  const Matrix6d cov = cov_b + adj * cov_a * adj.transpose() - cross - cross.transpose();
  return 0.5 * (cov + cov.transpose());
}

}  // namespace

Result<DrIncrement> DrFilter::Increment(Utime a, Utime b) const {
  const auto missing = [](const char* what) {
    return Error{ErrorCode::kNotFound, std::string("no DR increment: ") + what};
  };
  if (b < a) return Error{ErrorCode::kInvalidArgument, "no DR increment: it ends before it begins"};
  if (history_.empty() || a < history_.front().after.utime || b > history_.back().after.utime) {
    return missing("an end lies outside the history");
  }
  // The last entry at or before each end, and the first at or after it.
  const auto last_at_or_before = [this](Utime t) {
    const auto it =
        std::upper_bound(history_.begin(), history_.end(), t,
                         [](Utime time, const Entry& e) { return time < e.after.utime; });
    return static_cast<size_t>(it - history_.begin()) - 1;
  };
  const size_t ia = last_at_or_before(a);
  const size_t ib = last_at_or_before(b);
  const uint32_t counter = history_[ia].after.reset_counter;
  const size_t end = history_[ib].after.utime < b ? ib + 1 : ib;
  if (history_[end].after.reset_counter != counter) return missing("a reset lies between");

  // Pose inside the step after entry i, and its share of that step.
  const auto share = [this](size_t i, Utime t) {
    const Utime from = history_[i].after.utime;
    if (t <= from) return 0.0;
    return (t - from).seconds() / (history_[i + 1].after.utime - from).seconds();
  };
  const auto pose_at = [&](size_t i, double f) {
    const SE3& T_OS = history_[i].after.T_OS;
    const SE3 T = f > 0 ? Interpolate(T_OS, history_[i + 1].after.T_OS, f) : T_OS;
    return T * model_.T_SB();
  };
  // Covariance between two entries, in S.
  const auto entries = [this](size_t from, size_t to) {
    const FilterState& s = history_[from].after;
    ErrorPoseMatrix X = s.P.leftCols<6>();
    for (size_t i = from + 1; i <= to; ++i) X = (history_[i].after.transition * X).eval();
    const FilterState& e = history_[to].after;
    return RelativeCovariance(s.T_OS.inverse() * e.T_OS, s.P.topLeftCorner<6, 6>(),
                              e.P.topLeftCorner<6, 6>(), X.topRows<6>());
  };
  // Carries a covariance at T (right perturbation, S) to where T_b is.
  const auto carry = [](const Matrix6d& cov, const SE3& T, const SE3& T_b) {
    const Matrix6d adj = (T_b.inverse() * T).Adjoint();
    return Matrix6d(adj * cov * adj.transpose());
  };

  const double fa = share(ia, a);
  const double fb = share(ib, b);
  const SE3 T_OBa = pose_at(ia, fa);
  const SE3 T_OBb = pose_at(ib, fb);
  const SE3 T_OSb = T_OBb * model_.T_SB().inverse();
  Matrix6d cov = Matrix6d::Zero();
  if (ia == ib) {
    if (fb > fa) cov = (fb - fa) * carry(entries(ia, ia + 1), history_[ia + 1].after.T_OS, T_OSb);
  } else {
    // Inside a step the noise grows linearly.
    const size_t first = fa > 0 ? ia + 1 : ia;
    if (first > ia) cov += (1 - fa) * carry(entries(ia, first), history_[first].after.T_OS, T_OSb);
    cov += carry(entries(first, ib), history_[ib].after.T_OS, T_OSb);
    if (fb > 0) cov += fb * carry(entries(ib, ib + 1), history_[ib + 1].after.T_OS, T_OSb);
  }

  DrIncrement out;
  out.utime_begin = a;
  out.utime_end = b;
  out.T_BaBb = T_OBa.inverse() * T_OBb;
  const Matrix6d adj_BS = model_.T_SB().inverse().Adjoint();
  out.cov = adj_BS * cov * adj_BS.transpose();
  out.reset_counter = counter;
  for (size_t i = ia; i <= end; ++i) out.slip |= history_[i].after.slip;
  return out;
}

}  // namespace gw::dr_ekf
