#include "frontend/core/view_change.h"

#include <algorithm>

#include "frontend/core/place_confirmation.h"

namespace gw::frontend {
namespace {

// Measured: 0.47 and more from image to image (TUM fr1_rpy turning fast by hand; easy_office,
// blank_corridor, look_alike), 0.16 while the lens is being covered, 0.007 when carried away
// (kidnap).
constexpr double kFewSeenAgain = 0.08;
constexpr float kWindow = 40;        // px about where a feature is expected
constexpr int kSameFeature = 50;     // of 256 bits
constexpr double kTypicalDepth = 2;  // m, of features without

}  // namespace

bool ViewChange::Observe(Utime utime, const FeatureFrame& frame, const std::optional<SE3>& T_OC) {
  const bool rich = T_OC && static_cast<int>(frame.features.size()) >= PlaceConfirmation::kRich;
  bool changed = false;
  if (rich) {
    grid_.Build(frame.features, camera_.width, camera_.height);
    if (has_before_ && InARow(utime - utime_, T_OC_.inverse() * *T_OC)) {
      changed = ShareSeenAgain(frame, T_OC->inverse() * T_OC_) < kFewSeenAgain;
    }
    utime_ = utime;
    before_ = frame;
    T_OC_ = *T_OC;
  }
  has_before_ = rich;
  return changed;
}

double ViewChange::ShareSeenAgain(const FeatureFrame& frame, const SE3& T_CbCa) const {
  int expected = 0;
  int seen = 0;
  for (size_t i = 0; i < before_.features.size(); ++i) {
    const Feature& f = before_.features[i];
    const Eigen::Vector3d p =
        T_CbCa * camera_.Unproject(f.u, f.v, f.has_depth() ? f.depth : kTypicalDepth);
    if (!(p.z() > camera_.depth_min_m)) continue;
    const Eigen::Vector2f uv = camera_.Project(p).cast<float>();
    if (!(uv.x() >= 0 && uv.y() >= 0 && uv.x() < static_cast<float>(camera_.width) &&
          uv.y() < static_cast<float>(camera_.height))) {
      continue;
    }
    ++expected;
    int best = kSameFeature + 1;
    grid_.ForEachNear(uv.x(), uv.y(), kWindow, [&](int k) {
      best = std::min(best, HammingDistance(before_.descriptors[i], frame.descriptors[k]));
    });
    seen += best <= kSameFeature;
  }
  return expected > 0 ? static_cast<double>(seen) / expected : 0.0;
}

}  // namespace gw::frontend
