#include "frontend/core/place/view_change.h"

#include <algorithm>
#include <utility>

#include "common/vision/feature_grid.h"
#include "frontend/core/place/rich_image.h"

namespace gw::frontend {
namespace {

// Measured: 0.47 and more from image to image (TUM fr1_rpy turning fast by hand; easy_office,
// blank_corridor, look_alike), 0.16 while the lens is being covered, and after that, while the
// exposure settles; 0.007 when carried away (kidnap).
constexpr double kFewSeenAgain = 0.08;
constexpr float kWindow = 40;        // px about where a feature is expected
constexpr int kSameFeature = 50;     // of 256 bits
constexpr double kTypicalDepth = 2;  // m, of features without
// Share of the image before that must still be in view: less is too little in common.
constexpr double kEnoughInCommon = 0.5;

bool IsRich(const FeatureFrame& frame) {
  return static_cast<int>(frame.features.size()) >= kRichImage;
}

}  // namespace

SeenAgain CountSeenAgain(const RectifiedCamera& camera, const FeatureFrame& before,
                         const FeatureFrame& frame, const SE3& T_CbCa) {
  const FeatureGrid grid(frame.features);
  SeenAgain out;
  for (size_t i = 0; i < before.features.size(); ++i) {
    const Feature& f = before.features[i];
    const Eigen::Vector3d p_Ca =
        camera.Unproject(f.u, f.v, f.has_depth() ? f.depth : kTypicalDepth);
    const Eigen::Vector3d p = T_CbCa * p_Ca;
    if (!(p.z() > camera.depth_min_m)) continue;
    const Eigen::Vector2d uv = camera.Project(p);
    if (!camera.InImage(uv)) continue;
    ++out.in_view;
    if (!f.has_depth()) {
      const Eigen::Vector3d ray = T_CbCa.rotation() * p_Ca;  // infinitely far away
      if (!(ray.z() > 0) || (camera.Project(ray) - uv).norm() > kWindow) continue;
    }
    ++out.expected;
    int best = kSameFeature + 1;
    grid.ForEachNear(static_cast<float>(uv.x()), static_cast<float>(uv.y()), kWindow, [&](int k) {
      best = std::min(best, HammingDistance(before.descriptors[i], frame.descriptors[k]));
    });
    out.seen += best <= kSameFeature ? 1 : 0;
  }
  return out;
}

ViewVerdict ViewChange::Compare(const FeatureFrame& frame, const std::optional<SE3>& T_OC) const {
  if (!before_ || !T_OC || !IsRich(frame)) return ViewVerdict::kUnknown;
  const ViewVerdict last = Compare(*before_, frame, *T_OC);
  if (last != ViewVerdict::kOther || !before_that_) return last;
  return Compare(*before_that_, frame, *T_OC);
}

ViewVerdict ViewChange::Compare(const Image& before, const FeatureFrame& frame,
                                const SE3& T_OC) const {
  const SeenAgain again =
      CountSeenAgain(camera_, before.frame, frame, T_OC.inverse() * before.T_OC);
  const auto all = static_cast<double>(before.frame.features.size());
  if (again.in_view <= kEnoughInCommon * all || again.expected < kByChance) {
    return ViewVerdict::kUnknown;
  }
  return again.share() < kFewSeenAgain ? ViewVerdict::kOther : ViewVerdict::kSame;
}

void ViewChange::Remember(const FeatureFrame& frame, const std::optional<SE3>& T_OC) {
  before_that_ = std::move(before_);
  before_.reset();
  if (T_OC && IsRich(frame)) before_ = Image{frame, *T_OC};
}

}  // namespace gw::frontend
