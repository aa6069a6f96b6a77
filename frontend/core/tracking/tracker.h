// The tracking front-end: one image in, one pose out, always.
//
//   predict (DR or constant velocity) -> match the landmarks of the last image -> pose -> match the
//   rest of the local map -> pose -> keyframe?
//
// Pure and single-threaded: everything that happened comes back by value; time is that of the
// samples.
#pragma once

#include <memory>
#include <optional>

#include "common/camera/camera_model.h"
#include "common/config/frontend_config.h"
#include "common/contract/dead_reckoning.h"
#include "common/contract/frame_detail.h"
#include "common/contract/map.h"
#include "common/contract/place.h"
#include "common/contract/samples.h"
#include "common/contract/tracking.h"
#include "common/core/result.h"
#include "frontend/core/features/feature_frame.h"
#include "frontend/core/features/view_fault.h"
#include "frontend/core/motion/dr_disagreement.h"
#include "frontend/core/motion/scale_witness.h"

namespace gw::frontend {

struct TrackerOutput {
  FramePose pose;
  FrameDetail detail;                // of the same image, for people
  std::optional<Keyframe> keyframe;  // to be delivered to the back-end, in order
  std::optional<PlaceQuery> query;   // to be asked there; its answer to Push(PlaceMatch)
};

class Tracker {
 public:
  static Result<Tracker> Create(const FrontendConfig& config, const CameraGeometry& geometry);
  Tracker(Tracker&&) noexcept;
  Tracker& operator=(Tracker&&) noexcept;
  ~Tracker();

  // An image. Images of a wrong size or format and images back in time give a pose too (predicted,
  // with the reason); they are not used. When several in a row are back in time, and in order among
  // themselves, the clock was set back: tracking goes on in the same map, with the new time.
  TrackerOutput Push(const CameraFrame& frame);

  // The same from features, for tests without pixels.
  TrackerOutput Track(Utime utime, int64_t seq, const FeatureFrame& features);

  // Dead reckoning; false: not newer than the state before, refused.
  bool Push(const DrState& state);

  // Map changes in order of revision. False: a revision is missing; ask for a snapshot (Request).
  // Until the first snapshot (an empty one will do) no map is begun, because the back-end may hold
  // one.
  bool Push(const MapUpdate& update);

  // Where the robot is, from someone who kept track (POSE of the DR process): starting point after
  // a restart. Used only while this tracker has no pose in the map.
  void Push(const Pose& pose);

  // The answer to a query. A place is believed when several answers agree with dead reckoning; the
  // next image is then tracked from there (see place_confirmation.h).
  void Push(const PlaceMatch& match);

  // What to ask the back-end for: the map around the current pose, if there is one.
  MapRequest Request() const;

  // While healthy vision contradicts dead reckoning: the constant that explains it, if one does.
  DrConstantFault dr_fault() const;

  // Where dead reckoning and the accelerometer agree against it: what is wrong with the camera's
  // lengths.
  LengthFault length_fault() const;

  // What is wrong with the images themselves, though they may still be tracked.
  ViewFault view_fault() const;

  // False until the first snapshot has come.
  bool has_map() const;

 private:
  class Impl;
  explicit Tracker(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace gw::frontend
