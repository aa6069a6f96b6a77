// How POSE steps beside the motion of dead reckoning, as it was composed and as it was published.
#pragma once

#include <optional>

#include "common/contract/dead_reckoning.h"

namespace gw::sim {

class PoseSteps {
 public:
  struct Largest {
    double m = 0, rad = 0;
  };

  // Poses that belong together, one after the other. A step counts where the robot drives: not
  // while it is stationary, and not where a reset counter moves on or the first place in a map
  // becomes known.
  void Push(const Pose& composed, const Pose& published, bool stationary);

  // From one composed pose to the next: corrections above kCorrectionM or kCorrectionRad.
  int corrections() const { return corrections_; }
  const Largest& composed() const { return composed_; }
  const Largest& published() const { return published_; }
  // The largest correction that was outstanding.
  const Largest& outstanding() const { return outstanding_; }
  // Poses whose correction was outstanding by more than three standard deviations of what the
  // covariance said of any of position and rotation: none, if the covariance tells the truth.
  int not_covered() const { return not_covered_; }
  int snaps() const { return snaps_; }  // of the reset counter

  static constexpr double kCorrectionM = 0.02;
  static constexpr double kCorrectionRad = 0.0175;  // 1 degree

 private:
  std::optional<Pose> last_composed_, last_published_;
  int corrections_ = 0, not_covered_ = 0, snaps_ = 0;
  Largest composed_, published_, outstanding_;
};

}  // namespace gw::sim
