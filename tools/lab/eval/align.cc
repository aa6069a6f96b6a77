#include "tools/lab/eval/align.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace gw::eval {
namespace {

// Root mean square spread (m) below which positions count as one place: less than any sensor tells.
constexpr double kMinSpread = 1e-4;
// Spread across the main direction relative to that along it, below which positions count as a
// line: 1 mm in 1 m.
constexpr double kMinRelativeWidth = 1e-3;

struct Centred {
  Eigen::Vector3d mean_ref = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_est = Eigen::Vector3d::Zero();
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();  // mean of (p_ref - mean) * (p_est - mean)^T
};

Centred Centre(const std::vector<PosePair>& pairs) {
  Centred c;
  const double weight = 1.0 / static_cast<double>(pairs.size());
  for (const PosePair& pair : pairs) {
    c.mean_ref += weight * pair.T_ref.translation();
    c.mean_est += weight * pair.T_est.translation();
  }
  for (const PosePair& pair : pairs) {
    c.cross += weight * (pair.T_ref.translation() - c.mean_ref) *
               (pair.T_est.translation() - c.mean_est).transpose();
  }
  return c;
}

Error Undetermined(const std::string& what) {
  return {ErrorCode::kBadData, "cannot align: " + what};
}

Result<SE3> AlignSe3(const Centred& c) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(c.cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d& s = svd.singularValues();
  if (s[0] < kMinSpread * kMinSpread) {
    return Undetermined("all positions are in one place; use --align none");
  }
  if (s[1] < s[0] * kMinRelativeWidth * kMinRelativeWidth) {
    return Undetermined(
        "all positions lie on a line, the turn about it is not determined; use --align yaw or "
        "none");
  }
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0) signs.z() = -1;
  const Eigen::Matrix3d R = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  return SE3(Eigen::Quaterniond(R), c.mean_ref - R * c.mean_est);
}

// The yaw that maximises sum p_ref^T Rz(yaw) p_est over the centred positions.
Result<SE3> AlignYaw(const Centred& c) {
  const double sine = c.cross(1, 0) - c.cross(0, 1);
  const double cosine = c.cross(0, 0) + c.cross(1, 1);
  if (std::hypot(sine, cosine) < kMinSpread * kMinSpread) {
    return Undetermined("all positions are in one place seen from above; use --align none");
  }
  const double yaw = std::atan2(sine, cosine);
  const Eigen::Quaterniond q(std::cos(0.5 * yaw), 0, 0, std::sin(0.5 * yaw));
  return SE3(q, c.mean_ref - q * c.mean_est);
}

}  // namespace

std::vector<PosePair> Associate(const Trajectory& ref, const Trajectory& est, DurationUs max_gap,
                                DurationUs max_diff) {
  std::vector<PosePair> pairs;
  for (const TimedPose& e : est) {
    const auto after =
        std::lower_bound(ref.begin(), ref.end(), e.utime,
                         [](const TimedPose& pose, Utime utime) { return pose.utime < utime; });
    if (after != ref.end() && after->utime == e.utime) {
      pairs.push_back({e.utime, after->T, e.T});
      continue;
    }
    const bool has_before = after != ref.begin();
    const bool has_after = after != ref.end();
    if (has_before && has_after && after->utime - (after - 1)->utime <= max_gap) {
      const TimedPose& before = *(after - 1);
      const double fraction =
          (e.utime - before.utime).seconds() / (after->utime - before.utime).seconds();
      pairs.push_back({e.utime, Interpolate(before.T, after->T, fraction), e.T});
      continue;
    }
    const TimedPose* nearest = nullptr;
    if (has_before) nearest = &*(after - 1);
    if (has_after && (nearest == nullptr || after->utime - e.utime < e.utime - nearest->utime)) {
      nearest = &*after;
    }
    if (nearest == nullptr) continue;
    const DurationUs diff = e.utime - nearest->utime;
    if (diff <= max_diff && -diff <= max_diff) pairs.push_back({e.utime, nearest->T, e.T});
  }
  return pairs;
}

Result<SE3> Align(const std::vector<PosePair>& pairs, Alignment alignment) {
  if (pairs.empty()) {
    return Undetermined("no pose of the estimate has a reference pose at its time");
  }
  if (alignment == Alignment::kNone) return SE3();
  if (pairs.size() == 1) {
    return Undetermined("only one pose has a reference; use --align none");
  }
  const Centred centred = Centre(pairs);
  return alignment == Alignment::kSe3 ? AlignSe3(centred) : AlignYaw(centred);
}

}  // namespace gw::eval
