#include "frontend/core/features/depth_sync.h"

#include <algorithm>
#include <cmath>

#include "frontend/core/features/feature_depth.h"

namespace gw::frontend {
namespace {

constexpr double kMemory = 10;  // s
constexpr double kCertain = 3;
// Disparities that change more unsteadily, in standard deviations, are those of an edge.
constexpr double kUnsteady = 3;

}  // namespace

DepthSync::DepthSync(const CameraGeometry& geometry)
    : camera_(geometry.rectified), source_(geometry.calibration.camera.left), lookup_(geometry) {}

double DepthSync::DisparityAt(const ImageView& depth, double u, double v) const {
  if (depth.empty()) return -1;
  const Eigen::Vector2d at =
      RectifiedToSource(camera_, source_, Eigen::Matrix3d::Identity(), {u, v});
  return camera_.bf() / lookup_.At(depth, static_cast<float>(at.x()), static_cast<float>(at.y()));
}

void DepthSync::Push(Utime utime, const ImageView& depth) {
  const bool usable = camera_.has_depth_image() && !depth.empty();
  if (usable && !depths_.Before(1).empty()) {
    Judge(depth);
    const double kept = std::exp(-std::abs((utime - utime_).seconds()) / kMemory);
    const double kept2 = kept * kept;
    sums_ = {kept * sums_.s, kept * sums_.v, kept2 * sums_.ss, kept2 * sums_.sv, kept2 * sums_.vv};
  }
  sights_.clear();
  utime_ = utime;
  if (usable) {
    depths_.Push(depth);
  } else {
    depths_.Clear();
  }
}

void DepthSync::Judge(const ImageView& after) {
  const double sigma_q = std::sqrt(1.5) * camera_.disparity_sigma_px;
  double s = 0, v = 0;
  for (const Sight& sight : sights_) {
    const double d = DisparityAt(depths_.Before(0), sight.u, sight.v);
    const double d_before = DisparityAt(depths_.Before(1), sight.u, sight.v);
    const double d_after = DisparityAt(after, sight.u, sight.v);
    if (d <= 0 || d_before <= 0 || d_after <= 0) continue;
    const double q = d - (d_before + d_after) / 2;
    if (std::abs(q) > kUnsteady * sigma_q) continue;
    Track& track = tracks_[sight.landmark.value];
    const double expected = camera_.bf() / sight.depth;
    // A landmark that is at half or twice the distance by now is another question.
    const double nearer = track.count > 0 ? expected / track.disparity : 0;
    if (nearer < 0.5 || nearer > 2) {
      track = Track();
      track.disparity = expected;
    }
    const double k = (track.disparity / expected) * (track.disparity / expected);
    const double e = k * (d - expected);
    const double r = k * (d_after - d_before) / 2;
    if (track.count > 0) {
      const double weight = track.count / (track.count + 1);
      s -= weight * (e - track.e) * (r - track.r);
      v += weight * (r - track.r) * (r - track.r) - k * k * q * q / 3;
    }
    track.seen = utime_;
    track.count += 1;
    track.e += (e - track.e) / track.count;
    track.r += (r - track.r) / track.count;
  }
  sums_ = {sums_.s + s, sums_.v + v, sums_.ss + s * s, sums_.sv + s * v, sums_.vv + v * v};
  if (std::abs((utime_ - cleaned_).seconds()) < kMemory) return;
  cleaned_ = utime_;
  std::erase_if(tracks_, [&](const auto& entry) {
    return std::abs((utime_ - entry.second.seen).seconds()) > kMemory;
  });
}

bool DepthSync::IsBeyond(double images, int sign) const {
  const double tau = sign * images;
  const double squares = sums_.ss - 2 * tau * sums_.sv + tau * tau * sums_.vv;
  return sums_.v > 0 && sign * (sums_.s - tau * sums_.v) > kCertain * std::sqrt(squares);
}

double DepthSync::Lateness() const {
  return IsLate(0) || IsEarly(0) ? sums_.s / sums_.v : 0;
}

void DepthSync::Correct(double lateness, const SE3& T_ab, std::vector<Feature>* features) const {
  for (Feature& f : *features) {
    if (!f.has_disparity()) continue;
    const double told = static_cast<double>(f.u) - f.u_right;
    const double d = DisparityAt(depths_.Before(0), f.u, f.v);
    const double d_before = DisparityAt(depths_.Before(1), f.u, f.v);
    f.depth = f.u_right = -1;
    if (d <= 0 || d_before <= 0) continue;
    const Eigen::Vector3d p_a = T_ab * camera_.Unproject(f.u, f.v, camera_.bf() / told);
    if (p_a.z() <= 0) continue;
    const double moved = (camera_.Project(p_a) - Eigen::Vector2d(f.u, f.v)).norm();
    const auto [far, near] = std::minmax(d, d_before);
    if (lookup_.IsEdge(camera_.bf() / near, camera_.bf() / far, moved)) continue;
    const double now = told * (1 + lateness * (1 - d_before / d));
    if (now <= 0) continue;
    SetDepth(camera_, static_cast<float>(camera_.bf() / now), static_cast<float>(now), &f);
  }
}

}  // namespace gw::frontend
