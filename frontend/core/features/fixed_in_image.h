// Which features are fixed to the camera and not to the world: dots of an infrared projector, dirt
// on the lens, parts of the robot, marks in the image. They stand still in the image while the
// robot drives, and would be tracked perfectly as a world that does not move.
//
// Every feature with depth is followed from image to image by itself, without map or pose. Once the
// camera has moved, by dead reckoning (DR), two hypotheses stand against each other,
//
//   fixed   u ~ N(u_0, 2 s^2 I)                               u_0: where it was when it was
//   anchored world   u ~ N(pi(inv(T_0) p_0), 2 s^2 I + J Sigma_T J^T + d d^T sigma_z^2)
//
// T_0: the camera's motion since then, Sigma_T its covariance, d = d pi / d z, sigma_z: of the
// depth, for a disparity that is off by a pixel, s: pixel sigma of the pyramid level. DR may also
// be early or late: the world has the best of its motion until now, until 0.2 s ago, and since 0.2
// s after the anchor. The log odds of a feature add up from one anchor to the next; at 1000 to 1 it
// is decided. Of a feature that is not, only the share of what is fixed is known, the one that
// explains best what was found of all others.
//
// Vision is a witness, too: what moves as it says is of the world. That is asked only where vision
// moves, and where of the features that tell the two motions apart no majority moves as DR says:
// otherwise vision is drawn along by what is fixed. In the same way DR is believed only where most
// of what is known to be of the world moves as it says, now and lately; DR that vision has refuted,
// where ten features say that they move by it.
#pragma once

#include <algorithm>
#include <deque>
#include <limits>
#include <optional>
#include <vector>

#include "common/camera/camera_model.h"
#include "common/core/se3.h"
#include "common/core/time.h"
#include "common/vision/pyramid.h"
#include "frontend/core/features/feature_frame.h"

namespace gw::frontend {

// The motion of the camera between two images by DR, with its noise (right perturbation, per axis).
struct CameraStep {
  SE3 T_ab;
  Vector6d white = Vector6d::Zero();   // variance of what is independent from step to step
  Vector6d common = Vector6d::Zero();  // sigma of what steps in a row have in common
  std::optional<SE3> T_ab_seen;        // by vision, where it carries the pose
  bool refuted = false;                // vision that moves contradicts it
};

class FixedInImage {
 public:
  FixedInImage(const RectifiedCamera& camera, const Pyramid& pyramid)
      : camera_(camera), pyramid_(pyramid) {}

  // With every image; features as detected, before a rolling shutter is undone. step: since the
  // image before; empty where DR does not tell or the wheels slip.
  void Observe(Utime utime, const FeatureFrame& frame, const std::optional<CameraStep>& step);

  // Some features of the image are to be left out.
  bool any() const { return num_fixed_ > 0 || Prevails(); }
  // A feature of which nothing is known yet is fixed with a probability above kRisk, by what the
  // features were found to be that were judged lately; until that has fallen below kNoRisk.
  bool Prevails() const { return prevails_; }
  // When what is now known to be fixed was first seen. Precondition: any().
  Utime since() const { return since_; }

  // The image without them; num_detected falls likewise.
  FeatureFrame Without(const FeatureFrame& frame) const;

 private:
  // Half a world that is fixed makes a pose of its own; an eighth is outvoted by the rest.
  static constexpr double kRisk = 0.125;
  static constexpr double kNoRisk = 0.05;
  // So many judged features of the world are taken for granted: a few that seem fixed, which a
  // repeated pattern may make, say nothing of those that are not known.
  static constexpr double kPriorWorld = 60;

  static constexpr size_t kNoAnchor = std::numeric_limits<size_t>::max();

  enum class Kind { kUnknown, kWorld, kFixed };
  enum class Vote { kNone, kWorld, kFixed, kNeither };

  // Logarithms of the likelihoods of where a track is now.
  struct Likelihoods {
    double fixed = 0;
    double world = 0;            // it moves as DR says, if one allows for its noise
    double told = 0;             // likewise, and DR could tell: the density of a prediction
    std::optional<double> seen;  // as vision says, where that moves
    double neither = 0;          // the least that any of them has

    // It moves, whoever says how.
    double moving() const { return std::max(world, seen.value_or(world)); }
  };
  // An image from which features are judged.
  struct Anchor {
    Utime utime;
    SE3 T;                               // camera now in the camera of then
    Vector6d white = Vector6d::Zero();   // of T, as of a step
    Vector6d common = Vector6d::Zero();  // of T
    std::optional<SE3> T_late;           // until kLateness ago; empty: it is younger
    std::optional<SE3> T_first;          // of its first kLateness; empty: it is younger
    std::optional<SE3> T_seen = SE3();   // as T, by vision; empty where it was broken since

    Vector6d Variance() const { return white + common.cwiseAbs2(); }
  };
  struct Track {
    Kind kind = Kind::kUnknown;
    double log_odds = 0;         // of fixed against world, by all that it showed
    double log_odds_before = 0;  // until it was anchored
    Utime since;                 // the begin of what makes it fixed, should it be
    Eigen::Vector2d uv_0;        // px, in the anchor's image
    Eigen::Vector3d p_0;         // there, m
    size_t anchor = kNoAnchor;   // number since the begin
    Eigen::Vector2d uv;          // px, when it was seen last
    Eigen::Vector3d p;           // by DR, in the camera now
    Eigen::Vector3d p_seen;      // by vision
    Descriptor descriptor;
    int level = 0;
    Utime seen;
    int feature = -1;  // in the newest image; -1: not found
  };

  void Move(Utime utime, const std::optional<CameraStep>& step);
  void Follow(Utime utime, const FeatureFrame& frame);
  void Decide(bool dr_refuted);
  std::optional<Likelihoods> Explain(const Track& track) const;
  static int WitnessesOfDr(const std::vector<std::optional<Likelihoods>>& explained);
  static Vote VoteOf(const Likelihoods& likelihoods);
  bool Contradicted(const std::vector<Vote>& votes) const;
  void Learn(const Likelihoods& likelihoods, Track* track);
  // What the noise of DR explains is one error for all features of an image: `fits` does not hold
  // it against each of them. `told`: the density, which is low where DR could be anywhere.
  struct Prediction {
    double fits, told;
  };
  Prediction Predict(const Track& track, const SE3& T_0, const Vector6d& variance) const;
  double Share() const;
  void SetAnchor(Utime utime, const FeatureFrame& frame);
  void AnchorTrack(Track* track, const Feature& f) const;

  const Anchor* AnchorOf(const Track& t) const {
    const bool there = t.anchor != kNoAnchor && t.anchor >= first_anchor_;
    return there ? &anchors_[t.anchor - first_anchor_] : nullptr;
  }

  RectifiedCamera camera_;
  Pyramid pyramid_;
  std::deque<Anchor> anchors_;
  size_t first_anchor_ = 0;  // number of anchors_.front()
  struct Step {
    Utime utime;  // of its end
    SE3 T_ab;
  };
  std::deque<Step> recent_;  // of the last kLateness
  std::vector<Track> tracks_;
  std::vector<Kind> kind_;   // per feature of the newest image
  int num_fixed_ = 0;        // in the newest image
  double contradicted_ = 0;  // share of the images lately that contradict DR
  bool prevails_ = false;
  Utime since_;
};

}  // namespace gw::frontend
