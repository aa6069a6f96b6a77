#include "frontend/core/place/view_change.h"

#include <algorithm>
#include <utility>

#include "common/vision/feature_grid.h"
#include "frontend/core/place/place_confirmation.h"

namespace gw::frontend {
namespace {

// Measured: 0.47 and more from image to image (TUM fr1_rpy turning fast by hand; easy_office,
// blank_corridor, look_alike), 0.16 while the lens is being covered, 0.007 when carried away
// (kidnap).
constexpr double kFewSeenAgain = 0.08;
constexpr float kWindow = 40;        // px about where a feature is expected
constexpr int kSameFeature = 50;     // of 256 bits
constexpr double kTypicalDepth = 2;  // m, of features without

bool IsRich(const FeatureFrame& frame) {
  return static_cast<int>(frame.features.size()) >= PlaceConfirmation::kRich;
}

}  // namespace

double ShareSeenAgain(const RectifiedCamera& camera, const FeatureFrame& before,
                      const FeatureFrame& frame, const SE3& T_CbCa) {
  const FeatureGrid grid(frame.features);
  int expected = 0;
  int seen = 0;
  for (size_t i = 0; i < before.features.size(); ++i) {
    const Feature& f = before.features[i];
    const Eigen::Vector3d p =
        T_CbCa * camera.Unproject(f.u, f.v, f.has_depth() ? f.depth : kTypicalDepth);
    if (!(p.z() > camera.depth_min_m)) continue;
    const Eigen::Vector2d uv = camera.Project(p);
    if (!camera.InImage(uv)) continue;
    ++expected;
    int best = kSameFeature + 1;
    grid.ForEachNear(static_cast<float>(uv.x()), static_cast<float>(uv.y()), kWindow, [&](int k) {
      best = std::min(best, HammingDistance(before.descriptors[i], frame.descriptors[k]));
    });
    seen += best <= kSameFeature;
  }
  return expected > 0 ? static_cast<double>(seen) / expected : 0.0;
}

bool ViewChange::Changed(Utime utime, const FeatureFrame& frame,
                         const std::optional<SE3>& T_OC) const {
  if (!before_ || !T_OC || !IsRich(frame)) return false;
  return ShowsNothingOf(*before_, utime, frame, *T_OC) &&
         (!before_that_ || ShowsNothingOf(*before_that_, utime, frame, *T_OC));
}

bool ViewChange::ShowsNothingOf(const Image& before, Utime utime, const FeatureFrame& frame,
                                const SE3& T_OC) const {
  return InARow(utime - before.utime, before.T_OC.inverse() * T_OC) &&
         ShareSeenAgain(camera_, before.frame, frame, T_OC.inverse() * before.T_OC) < kFewSeenAgain;
}

void ViewChange::Remember(Utime utime, const FeatureFrame& frame, const std::optional<SE3>& T_OC) {
  before_that_ = std::move(before_);
  before_.reset();
  if (T_OC && IsRich(frame)) before_ = Image{utime, frame, *T_OC};
}

}  // namespace gw::frontend
