// Does the robot know where in the map it is? Watched image by image: doubt and questions
// (PlaceConfirmation), images that show another scene than the one before (ViewChange), a place
// that was confirmed and is to be tracked from, and when to map on without one (PieceStart).
#pragma once

#include <optional>
#include <utility>

#include "common/camera/camera_model.h"
#include "common/contract/place.h"
#include "frontend/core/features/feature_frame.h"
#include "frontend/core/place/piece_start.h"
#include "frontend/core/place/place_confirmation.h"
#include "frontend/core/place/view_change.h"

namespace gw::frontend {

class PlaceWatch {
 public:
  // doubts: whether images may contradict the pose (PlaceConfirmation).
  PlaceWatch(const RectifiedCamera& camera, bool doubts)
      : camera_(camera), doubts_(doubts), place_(doubts), view_(camera), piece_start_(camera) {}

  // After the search for the pose of an image, before it is judged: does the image show the scene
  // of the one before? T_OC: its camera in the odometry frame. weak: only few inliers, or none,
  // answer the question already.
  void CompareViews(const FeatureFrame& frame, const std::optional<SE3>& T_OC, bool weak);

  // True when the pose that vision found for the newest image is contradicted. view of the evidence
  // is filled in here.
  bool Contradicts(PlaceEvidence evidence) const;

  // After the pose of the newest image is decided. known: the tracker has a pose in the frame that
  // it uses, so that `evidence` is all that can speak against it.
  struct Verdict {
    bool ask = false;     // the back-end, where this image was taken
    bool sure = false;    // the pose is known and not in doubt
    bool map_on = false;  // the place has been unknown for long: a piece may be begun here
  };
  Verdict Observe(PlaceEvidence evidence, const FeatureFrame& frame, bool known);

  bool in_doubt() const { return place_.in_doubt(); }

  // An answer of the back-end about the image whose camera was at T_OC; piece: that of its
  // keyframe.
  void Answer(const PlaceMatch& match, const SE3& T_OC, KeyframeId piece);

  // The place that was confirmed since the last call: to be tracked from at the next image.
  struct Confirmed {
    SE3 T_WO;           // of the odometry frame, in the frame of the piece
    Matrix6d cov_T_WC;  // of the camera's pose
    KeyframeId piece;
  };
  std::optional<Confirmed> TakeConfirmed() { return std::exchange(confirmed_, std::nullopt); }

  // A piece was begun, whose frame is known.
  void BeginPiece();
  // The clock was set back.
  void Restart();

 private:
  RectifiedCamera camera_;
  bool doubts_;
  PlaceConfirmation place_;
  ViewChange view_;
  PieceStart piece_start_;
  ViewVerdict newest_ = ViewVerdict::kUnknown;  // what the newest image shows of the one before
  std::optional<Confirmed> confirmed_;
};

}  // namespace gw::frontend
