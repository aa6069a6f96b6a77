// A robot that does not know where in the map it is maps on, in a piece of the map of its own: when
// is that begun? Not at once: most doubts pass (somebody walks by, a place is recognised a second
// later). And not on what moves with the camera: the image has to show, where dead reckoning says
// that it should be by now, what an image shows that was taken some way before
// (docs/adr/0047-pieces-of-a-map.md).
#pragma once

#include <optional>

#include "common/camera/camera_model.h"
#include "common/core/se3.h"
#include "common/core/time.h"
#include "frontend/core/features/feature_frame.h"

namespace gw::frontend {

class PieceStart {
 public:
  static constexpr DurationUs kPatience = Milliseconds(3000);  // three times that of a place query
  // So far apart are two images that are compared: a feature 3 m away has moved by tens of pixels.
  static constexpr double kWay = 0.3;   // m; or
  static constexpr double kTurn = 0.3;  // rad
  // Shares of the features expected there: some change their looks on the way, or are hidden.
  static constexpr double kLeastSeen = 0.25;

  explicit PieceStart(const RectifiedCamera& camera) : camera_(camera) {}

  // After every image. T_OC: its camera in the odometry frame; empty without dead reckoning, which
  // begins the wait anew. True: the place has been unknown for long enough, and this image and the
  // motion since another one agree.
  bool Observe(Utime utime, bool place_known, const FeatureFrame& frame,
               const std::optional<SE3>& T_OC);

 private:
  struct Image {
    FeatureFrame frame;
    SE3 T_OC;
  };
  bool Agrees(const FeatureFrame& frame, const SE3& T_OC) const;

  RectifiedCamera camera_;
  std::optional<Utime> since_;
  std::optional<Image> compared_;
};

}  // namespace gw::frontend
