// Does the tracker know where it is? And when it does not: which answer of the back-end to believe.
//
// Unsure, and asking, is a tracker
//  - that has no pose in a map that is there (start in a saved map);
//  - whose vision broke from one image to the next, although both are rich and dead reckoning saw
//    hardly any motion (it was carried away, or something stands before the lens): doubt. Until it
//    is resolved nothing may be mapped, and the pose may not be claimed;
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

namespace gw::frontend {

// What one image told.
struct PlaceEvidence {
  Utime utime;
  bool placed = false;  // the tracker has a pose in the map
  bool map_there = false;
  bool vision = false;      // vision carries the pose of this image
  int num_inliers = 0;      // of it
  int num_detected = 0;     // features of the image
  std::optional<SE3> T_OC;  // camera in the odometry frame; empty without dead reckoning
};

class PlaceConfirmation {
 public:
  static constexpr int kRich = 200;                            // features of a rich image
  static constexpr int kWellTracked = 60;                      // inliers before the break
  static constexpr DurationUs kPatience = Milliseconds(1000);  // without vision
  static constexpr DurationUs kAskEvery = Milliseconds(200);
  static constexpr DurationUs kDoubtAtMost =
      Milliseconds(15000);  // then dead reckoning is believed
  static constexpr size_t kAgreeing = 3;
  static constexpr DurationUs kMemory =
      Milliseconds(5000);  // answers older than this are forgotten

  // After every image. True: ask the back-end about it.
  bool Observe(const PlaceEvidence& evidence);

  // Vision contradicts the pose: see above.
  bool in_doubt() const { return doubt_since_.has_value(); }

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

  bool unsure_ = false;
  std::optional<Utime> doubt_since_;
  std::optional<Utime> last_asked_;
  std::optional<Utime> last_vision_;
  std::optional<PlaceEvidence> before_;
  std::deque<Hint> hints_;
};

}  // namespace gw::frontend
