#include "backend/core/map/keyframe_check.h"

#include <cmath>

#include "common/vision/feature_grid.h"

namespace gw::backend {
namespace {

bool IsSane(const Feature& f) {
  const auto in_range = [](float x) { return std::abs(x) <= FeatureGrid::kMaxPixel; };  // not NaN
  if (!in_range(f.u) || !in_range(f.v) || f.level > kMaxLevel) return false;
  if (!std::isfinite(f.u_right) || !std::isfinite(f.depth) || !std::isfinite(f.angle)) return false;
  return !f.has_depth() || (in_range(f.u_right) && f.depth <= kMaxCoordinate);
}

}  // namespace

bool IsInReach(const Eigen::Vector3d& p) {
  return p.allFinite() && p.cwiseAbs().maxCoeff() <= kMaxCoordinate;
}

KeyframeFault CheckKeyframe(const Keyframe& keyframe) {
  if (!keyframe.id.valid() || keyframe.id.value > kMaxKeyframeId || keyframe.piece > keyframe.id) {
    return KeyframeFault::kId;
  }
  const size_t n = keyframe.features.size();
  if (keyframe.descriptors.size() != n || keyframe.landmarks.size() != n ||
      n > static_cast<size_t>(LandmarkId::kMaxFeatures)) {
    return KeyframeFault::kLengths;
  }
  if (!keyframe.T_WC.IsFinite() || !IsInReach(keyframe.T_WC.translation())) {
    return KeyframeFault::kPose;
  }
  if (!(keyframe.length_factor >= Keyframe::kLeastLengthFactor &&
        keyframe.length_factor <= Keyframe::kMostLengthFactor)) {
    return KeyframeFault::kScale;
  }
  if (!keyframe.cov_T_WC.allFinite() || !(keyframe.q >= 0 && keyframe.q <= 1)) {
    return KeyframeFault::kQuality;
  }
  for (const LandmarkId id : keyframe.landmarks) {
    if (id.value < 0 || id.creator().value > kMaxKeyframeId) return KeyframeFault::kLandmark;
  }
  for (const Feature& feature : keyframe.features) {
    if (!IsSane(feature)) return KeyframeFault::kFeature;
  }
  return KeyframeFault::kNone;
}

const char* KeyframeFaultText(KeyframeFault fault) {
  switch (fault) {
    case KeyframeFault::kNone:
      return "";
    case KeyframeFault::kId:
      return "id out of range, or of a piece that began later";
    case KeyframeFault::kLengths:
      return "feature, descriptor and landmark lists differ in length, or are too long";
    case KeyframeFault::kPose:
      return "pose is not finite or too far away";
    case KeyframeFault::kScale:
      return "factor of its lengths is not between 0.001 and 1000";
    case KeyframeFault::kQuality:
      return "covariance is not finite, or quality not in [0, 1]";
    case KeyframeFault::kLandmark:
      return "a landmark id is out of range";
    case KeyframeFault::kFeature:
      return "a feature's coordinates, depth or level are out of range";
  }
  return "unknown";
}

bool IsUsable(const DrIncrement& dr, Utime utime_end) {
  if (!dr.T_BaBb.IsFinite() || !dr.cov.allFinite()) return false;
  if (dr.utime_end != utime_end || dr.utime_end <= dr.utime_begin) return false;
  if ((dr.cov.diagonal().array() < 0).any()) return false;
  const double scale = dr.cov.cwiseAbs().maxCoeff();
  return (dr.cov - dr.cov.transpose()).cwiseAbs().maxCoeff() <= 1e-6 * scale + 1e-18;
}

bool IsUsable(const DrHeight& height) {
  return std::isfinite(height.z) && std::isfinite(height.variance) && height.variance > 0;
}

}  // namespace gw::backend
