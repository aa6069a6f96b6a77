// Does the tracker know where it is? And when it does not: which answer of the back-end to believe.
//
// Unsure, and asking, is a tracker
//  - that has no pose in a map that is there (start in a saved map);
//  - whose vision breaks between two rich images, although dead reckoning saw hardly any motion (it
//    was carried away, or something stands before the lens), or which sees another scene from one
//    image to the next (ViewChange), which needs no landmark: doubt. Until vision returns, a
//    place is confirmed, or the images turn out to have followed the robot (PlaceWatch), nothing
//    may be mapped, and the pose may not be claimed;
//  - that has been without vision for kPatience, although the images are rich.
//
// Answers are hints. They are believed when kAgreeing of them, from different images, say the same
// of where the odometry frame lies in the map; a look-alike does not keep that up along a way.
#pragma once

#include <deque>
#include <optional>

#include "common/contract/place.h"
#include "common/core/se3.h"
#include "common/core/time.h"
#include "frontend/core/place/view_change.h"

namespace gw::frontend {

// What one image told.
struct PlaceEvidence {
  Utime utime;
  bool placed = false;  // the tracker has a pose in the map
  bool map_there = false;
  int num_inliers = 0;       // of the pose that vision found; 0: vision does not carry the pose
  bool relocalised = false;  // from a confirmed place
  int num_detected = 0;      // features of the image
  ViewVerdict view = ViewVerdict::kUnknown;  // what it shows of the image before
  bool dr_trusted = true;                    // vision does not contradict dead reckoning
  std::optional<SE3> T_OC;  // camera in the odometry frame; empty without dead reckoning
};

class PlaceConfirmation {
 public:
  // doubts: whether images may contradict the pose; without, only a tracker that has no pose in the
  // map asks.
  explicit PlaceConfirmation(bool doubts = true) : doubts_(doubts) {}

  static constexpr int kWellTracked = 60;                      // inliers before the break
  static constexpr DurationUs kPatience = Milliseconds(1000);  // without vision
  static constexpr DurationUs kAskEvery = Milliseconds(200);
  static constexpr size_t kAgreeing = 3;
  static constexpr DurationUs kMemory =
      Milliseconds(5000);  // answers older than this are forgotten

  // True when vision breaks here: it was good in the images just before, and this one has nothing
  // of it, or only so little that chance gives as much; or the view is another one, and no more
  // than chance speaks for the pose.
  bool Contradicts(const PlaceEvidence& now) const;

  // After every image. True: ask the back-end about it.
  bool Observe(const PlaceEvidence& now);

  // Vision contradicts the pose: see above.
  bool in_doubt() const { return in_doubt_; }
  // Every image since vision was good shows the scene of the image before, where dead reckoning
  // says, which nothing contradicts: the robot was not carried away.
  bool followed() const { return followed_; }
  // It is where dead reckoning says.
  void EndDoubt() { in_doubt_ = false; }

  // An answer, with the odometry's pose of the camera at its image. What it is told to believe is
  // the pose in the map of the odometry frame: T_WC = T_WO * T_OC. Ignored while the tracker is
  // sure.
  struct Confirmed {
    SE3 T_WO;
    Matrix6d cov_T_WC;  // of the newest answer
  };
  std::optional<Confirmed> Take(const PlaceMatch& match, const SE3& T_OC);

 private:
  struct Hint {
    Utime utime;
    SE3 T_WC, T_OC;
    Matrix6d cov;
  };
  static bool Agree(const Hint& a, const Hint& b);

  bool doubts_;
  bool unsure_ = false;
  bool in_doubt_ = false;
  bool on_probation_ = false;  // relocalised, and not well tracked since
  std::optional<Utime> last_asked_;
  std::optional<Utime> last_vision_;
  std::optional<PlaceEvidence> good_;  // newest rich image whose vision may not break
  bool followed_ = false;              // since then
  std::deque<Hint> hints_;
};

}  // namespace gw::frontend
