#include "backend/core/bundle/window.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "backend/core/bundle/connection.h"
#include "backend/core/bundle/floor_level.h"
#include "backend/core/bundle/good_graph.h"
#include "backend/core/map/seen_landmarks.h"
#include "common/core/covariance.h"
#include "common/good_weights/alpha.h"
#include "common/good_weights/edge_covariance.h"
#include "common/good_weights/quality.h"

namespace gw::backend {
namespace {

constexpr int kTemporalAlways = 5;      // predecessors in time that belong to every window
constexpr int kTemporalWhileWeak = 60;  // and at most so many while vision binds them weakly
constexpr int kGlobalIterations = 20;   // of global BA, per pass
// Relative change of the cost at which global BA has converged. Ten thousands of observations
// outweigh a lap's dead reckoning in the cost, which still moves the map where they have converged
// to 1e-4.
constexpr double kGlobalTolerance = 1e-6;
// Prior of the scales of DR in global BA, as in the DR filter (wheel_scale_sigma,
// gyro_scale_sigma): wheels wear, floors differ, and what the filter learnt of it is as good as
// vision was.
constexpr double kDrScaleSigma = 0.01;
constexpr int kFewestNeighbours = 3;  // taken even below the covisibility threshold

// The covisible part: the newest keyframe and its best neighbours, those that share most or those
// that keep the problem best conditioned.
std::set<KeyframeId> CovisibleWindow(const Map& map, const MappingContext& context) {
  if (context.config.local_ba == LocalWindow::kGoodGraph) return GoodGraphWindow(map, context);
  std::set<KeyframeId> window{map.newest_keyframe()};
  for (const auto& [id, shared] : map.Neighbours(map.newest_keyframe(), 1)) {
    const int size = static_cast<int>(window.size());
    if (size >= context.config.local_keyframes) break;
    if (shared < context.config.covisibility_min_shared && size > kFewestNeighbours) break;
    window.insert(id);
  }
  return window;
}

void AddPredecessors(const Map& map, EdgeLacks& lacks, std::set<KeyframeId>& window) {
  const MapKeyframe* at = map.FindKeyframe(map.newest_keyframe());
  for (int step = 0; step < kTemporalWhileWeak; ++step) {
    if (!at->frame.dr) return;
    const bool weak = lacks.Smoothed(at->frame.id) >= kWeakLack;
    if (step >= kTemporalAlways && !weak) return;
    at = map.FindKeyframe(at->frame.previous);
    if (at == nullptr) return;
    window.insert(at->frame.id);
  }
}

// Keyframes outside the window that see its landmarks, those that see most.
std::vector<KeyframeId> Onlookers(const Map& map, const std::vector<LandmarkId>& landmarks,
                                  const std::set<KeyframeId>& window, int at_most) {
  std::map<KeyframeId, int> seen;
  for (const LandmarkId id : landmarks) {
    for (const Observation& observation : map.FindLandmark(id)->observations) {
      if (!window.contains(observation.keyframe)) ++seen[observation.keyframe];
    }
  }
  std::vector<std::pair<KeyframeId, int>> ranked(seen.begin(), seen.end());
  std::sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) {
    return a.second != b.second ? a.second > b.second : a.first > b.first;
  });
  if (ranked.size() > static_cast<size_t>(at_most)) ranked.resize(static_cast<size_t>(at_most));
  std::vector<KeyframeId> out;
  out.reserve(ranked.size());
  for (const auto& [id, count] : ranked) out.push_back(id);
  return out;
}

using Index = std::map<KeyframeId, int32_t>;  // into the job's keyframes

void AddObservations(const Map& map, const MappingContext& context,
                     const std::vector<LandmarkId>& landmarks, const Index& index,
                     LocalBaJob& job) {
  for (const LandmarkId id : landmarks) {
    const Landmark& landmark = *map.FindLandmark(id);
    const size_t first = job.observations.size();
    for (const Observation& observation : landmark.observations) {
      const auto keyframe = index.find(observation.keyframe);
      if (keyframe == index.end()) continue;
      const auto& features = map.FindKeyframe(observation.keyframe)->frame.features;
      const size_t feature = static_cast<size_t>(observation.feature_index);
      if (feature >= features.size()) continue;
      const SE3& T_WC = job.keyframes[static_cast<size_t>(keyframe->second)].T_WC;
      const double z =
          T_WC.rotation().toRotationMatrix().col(2).dot(landmark.p_W - T_WC.translation());
      job.observations.push_back(
          {keyframe->second, static_cast<int32_t>(job.landmarks.size()),
           ObservationOf(features[feature], context.camera, context.pyramid, z)});
    }
    if (job.observations.size() - first < 2) {
      job.observations.resize(first);
    } else {
      job.landmarks.push_back({id, landmark.p_W});
    }
  }
}

DrMotion MotionTo(const MappingContext& context, const MapKeyframe& to) {
  return CameraMotion(*to.frame.dr, context.camera.T_BC, context.dr_weight);
}

void AddDrEdge(const MapKeyframe& to, const DrMotion& motion, const Matrix6d& cov, double alpha,
               const Index& index, LocalBaJob& job) {
  job.dr_edges.push_back({index.at(to.frame.previous), index.at(to.frame.id), motion.T_CaCb,
                          motion.lever, SqrtInformation(cov), alpha});
}

// Like any word of DR they count as vision lacks quality, and for no more than DR says of them.
void AddHeights(const Map& map, const MappingContext& context, EdgeLacks& lacks, LocalBaJob& job) {
  const FloorLevels levels(map, context.camera.T_BC);
  for (size_t i = 0; i < job.keyframes.size(); ++i) {
    if (job.keyframes[i].fixed) continue;
    const auto height = levels.Of(job.keyframes[i].id);
    if (!height) continue;
    const double q = 1.0 - lacks.Smoothed(job.keyframes[i].id);
    const double alpha = std::min(EdgeScale(context.variant, q, context.dr_weight), 1.0);
    if (!(alpha > 0)) continue;
    job.heights.push_back({static_cast<int32_t>(i), height->z_W, height->sigma / std::sqrt(alpha)});
  }
}

}  // namespace

std::optional<LocalBaJob> CutLocalWindow(const Map& map, const MappingContext& context) {
  if (map.keyframes().size() < 2 || map.FindKeyframe(map.newest_keyframe()) == nullptr) {
    return std::nullopt;
  }
  const bool use_dr = DrInLocalBa(context.variant);
  std::set<KeyframeId> window = CovisibleWindow(map, context);
  const double reference = ConnectionReference(map, context.dr_weight);
  EdgeLacks lacks(map, reference, context.dr_weight);
  if (use_dr) AddPredecessors(map, lacks, window);

  const std::vector<LandmarkId> landmarks = SeenLandmarks(map, window);
  std::map<KeyframeId, bool> fixed;  // every keyframe of the job
  for (const KeyframeId id :
       Onlookers(map, landmarks, window, context.config.local_fixed_keyframes)) {
    fixed[id] = true;
  }
  const std::map<KeyframeId, KeyframeId> first_of = map.FirstOfPieces();
  for (const KeyframeId id : window) fixed[id] = first_of.at(map.PieceOf(id)) == id;
  for (const KeyframeId id : window) {
    if (!use_dr) break;
    const MapKeyframe& keyframe = *map.FindKeyframe(id);
    if (keyframe.frame.dr && lacks.Smoothed(id) >= kWeakLack) {
      fixed.try_emplace(keyframe.frame.previous, true);
    }
    const MapKeyframe* next = map.FindKeyframe(keyframe.next);
    if (next != nullptr && next->frame.dr && lacks.Smoothed(next->frame.id) >= kWeakLack) {
      fixed.try_emplace(keyframe.next, true);
    }
  }
  if (std::none_of(fixed.begin(), fixed.end(), [](const auto& entry) { return entry.second; })) {
    fixed.begin()->second = true;
  }

  LocalBaJob job;
  job.revision = map.revision();
  job.newest = map.newest_keyframe();
  job.camera = context.camera;
  job.iterations = context.config.local_ba_iterations;
  Index index;
  for (const auto& [id, is_fixed] : fixed) {
    index[id] = static_cast<int32_t>(job.keyframes.size());
    job.keyframes.push_back({id, map.FindKeyframe(id)->frame.T_WC, is_fixed});
  }

  AddObservations(map, context, landmarks, index, job);
  if (!use_dr) return job;
  job.robust_dr = context.dr_weight.Departs(Departure::kEdgeLoss);
  for (const auto& [id, is_fixed] : fixed) {
    const MapKeyframe& keyframe = *map.FindKeyframe(id);
    const auto from = index.find(keyframe.frame.previous);
    if (!keyframe.frame.dr || from == index.end()) continue;
    if (is_fixed && job.keyframes[from->second].fixed) continue;
    const double q = 1.0 - lacks.Smoothed(id);
    const double alpha = EdgeScale(context.variant, q, context.dr_weight);
    if (!(alpha > 0)) continue;
    const DrMotion motion = MotionTo(context, keyframe);
    AddDrEdge(keyframe, motion, EdgeCovariance(motion, alpha, context.variant, context.dr_weight),
              alpha, index, job);
  }
  AddHeights(map, context, lacks, job);
  return job;
}

std::optional<LocalBaJob> CutWholeMap(const Map& map, const MappingContext& context) {
  if (map.keyframes().size() < 2) return std::nullopt;
  LocalBaJob job;
  job.revision = map.revision();
  job.newest = map.newest_keyframe();
  job.camera = context.camera;
  job.iterations = kGlobalIterations;
  job.function_tolerance = kGlobalTolerance;
  job.settle_landmarks = context.dr_weight.Departs(Departure::kSettle);
  Index index;
  const std::map<KeyframeId, KeyframeId> first_of = map.FirstOfPieces();
  for (const auto& [id, keyframe] : map.keyframes()) {
    index[id] = static_cast<int32_t>(job.keyframes.size());
    const bool holds = first_of.at(keyframe.frame.piece) == id;
    job.keyframes.push_back({id, keyframe.frame.T_WC, holds});
  }
  AddObservations(map, context, map.SortedLandmarkIds(), index, job);
  if (!DrInGlobalBa(context.variant)) return job;
  job.robust_dr = context.dr_weight.Departs(Departure::kEdgeLoss);
  if (AdaptsAlpha(context.variant) && context.dr_weight.Departs(Departure::kScales)) {
    job.dr_scale_sigma = kDrScaleSigma;
  }
  const double reference = ConnectionReference(map, context.dr_weight);
  for (const auto& [id, keyframe] : map.keyframes()) {
    const double alpha = DrEdgeScale(map, context, id, reference);
    if (!(alpha > 0)) continue;
    const DrMotion motion = MotionTo(context, keyframe);
    const Matrix6d cov = WholeMapEdgeCovariance(motion, alpha, context.variant, context.dr_weight);
    AddDrEdge(keyframe, motion, cov, alpha, index, job);
  }
  EdgeLacks lacks(map, reference, context.dr_weight);
  AddHeights(map, context, lacks, job);
  return job;
}

}  // namespace gw::backend
