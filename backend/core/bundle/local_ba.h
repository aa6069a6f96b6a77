// Local bundle adjustment: the newest keyframes and what they see, moved together.
//
// plan, solve, apply: Mapper::BuildJob cuts an immutable snapshot from the map, SolveLocalBa is a
// pure function that may run on another thread, Mapper::Apply merges the result. Cost: Huber
// reprojection errors, pixel and depth apart, and the DR edges between temporal neighbours
// (docs/method.md, section 2). A depth that does not fit is left out; a pixel that does not fit
// takes its observation out of the map. Bounded by iteration counts only; the same job gives the
// same bytes.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "common/camera/camera_model.h"
#include "common/contract/map.h"
#include "common/good_weights/camera_motion.h"
#include "common/vision/reprojection.h"

namespace gw::backend {

struct LocalBaJob {
  struct KeyframeState {
    KeyframeId id;
    SE3 T_WC;
    bool fixed = false;
  };
  struct LandmarkState {
    LandmarkId id;
    Eigen::Vector3d p_W;
  };
  struct SeenLandmark {
    int32_t keyframe = 0;  // index into keyframes
    int32_t landmark = 0;  // index into landmarks
    PixelObservation pixel;
  };
  struct DrEdge {
    int32_t from = 0, to = 0;   // indices into keyframes
    SE3 T_FromTo;               // camera motion
    ScaleLever lever;           // of the scales of way and turn
    Matrix6d sqrt_information;  // of alpha * inv(Sigma): upper triangular
    double alpha = 0;           // the scale that local BA gave it, for the map
  };
  struct HeldHeight {  // of the body, by the floor (FloorLevels)
    int32_t keyframe = 0;
    double z_W = 0;    // m
    double sigma = 0;  // m, > 0
  };

  int64_t revision = 0;  // of the map it was cut from
  KeyframeId newest;     // of that map
  // Prior of the errors that all ways, and all turns, of DR have in common; 0: they have none.
  double dr_scale_sigma = 0;
  bool robust_dr = true;  // DR edges have Cauchy's loss; else plain squares, as in the paper
  RectifiedCamera camera;
  int iterations = 10;               // per pass
  double function_tolerance = 1e-4;  // relative change of the cost at which a pass ends early
  // A whole map: its reduced system is solved as a sparse one, and each landmark settles by itself
  // before all move together.
  bool settle_landmarks = false;
  std::vector<KeyframeState> keyframes;    // sorted by id; at least one is fixed
  std::vector<LandmarkState> landmarks;    // sorted by id; each has at least two observations
  std::vector<SeenLandmark> observations;  // sorted by landmark, then keyframe
  std::vector<DrEdge> dr_edges;            // sorted by `to`
  std::vector<HeldHeight> heights;         // of free keyframes, sorted
};

struct LocalBaResult {
  int64_t revision = 0;  // of the job
  KeyframeId newest;     // of the job
  // False: the solver found no usable step or the numbers are not finite; nothing may be applied.
  bool usable = false;
  struct MovedKeyframe {
    KeyframeId id;
    SE3 T_WC;
  };
  struct MovedLandmark {
    LandmarkId id;
    Eigen::Vector3d p_W;
  };
  struct Outlier {
    LandmarkId landmark;
    KeyframeId keyframe;
  };
  std::vector<MovedKeyframe> keyframes;  // the free ones
  std::vector<MovedLandmark> landmarks;
  std::vector<Outlier> outliers;  // observations that no longer belong to their landmark
  std::vector<DrEdgeWeight> dr_edges;
  // For reports.
  int iterations = 0;
  int num_observations = 0;
  Eigen::Vector2d dr_scale_error = Eigen::Vector2d::Zero();  // of way and turn, as found
  double cost_before = 0,
         cost_after = 0;  // robust cost of the observations kept to the end, and DR
};

// Global BA is the same over the whole map. It takes seconds: when `stop` (may be empty) answers
// true, the solve ends at its next iteration, and the result is not usable. It is asked on the
// thread that solves.
using StopCondition = std::function<bool()>;
LocalBaResult SolveLocalBa(const LocalBaJob& job, const StopCondition& stop = {});

}  // namespace gw::backend
