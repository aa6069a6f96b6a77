#include "backend/core/keyframe_check.h"

#include <cmath>

#include "backend/core/feature_grid.h"

namespace gw::backend {
namespace {

bool IsSane(const Feature& f) {
  const auto in_range = [](float x) { return std::abs(x) <= FeatureGrid::kMaxPixel; };  // not NaN
  if (!in_range(f.u) || !in_range(f.v) || f.level > kMaxLevel) return false;
  return !f.has_depth() || (in_range(f.u_right) && f.depth <= kMaxCoordinate);
}

}  // namespace

KeyframeFault CheckKeyframe(const Keyframe& keyframe) {
  if (!keyframe.id.valid() || keyframe.id.value > (int64_t{1} << 48)) return KeyframeFault::kId;
  const size_t n = keyframe.features.size();
  if (keyframe.descriptors.size() != n || keyframe.landmarks.size() != n ||
      n > static_cast<size_t>(LandmarkId::kMaxFeatures)) {
    return KeyframeFault::kLengths;
  }
  if (!keyframe.T_WC.IsFinite() ||
      keyframe.T_WC.translation().cwiseAbs().maxCoeff() > kMaxCoordinate) {
    return KeyframeFault::kPose;
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
      return "id out of range";
    case KeyframeFault::kLengths:
      return "feature, descriptor and landmark lists differ in length, or are too long";
    case KeyframeFault::kPose:
      return "pose is not finite or too far away";
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

}  // namespace gw::backend
