#include "frontend/core/tracking/pose_finder.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "common/core/log_odds.h"
#include "common/core/random.h"
#include "common/good_weights/covariance.h"
#include "common/good_weights/quality.h"
#include "common/vision/descriptor_pairing.h"
#include "common/vision/pose_ransac.h"
#include "frontend/core/place/recovery.h"

namespace gw::frontend {
namespace {

constexpr int kFewMatches = 20;  // first stage: with fewer inliers the window is doubled
constexpr int kAttempts = 3;
constexpr int kLocalKeyframes = 40;
constexpr int kNearKeyframes = 8;
constexpr int kRelocalizedInliers = 30;     // a pose that does not follow from the last image's
constexpr float kNearRadius = 10.0F;        // px; what is near has not been seen in the last image
constexpr float kSecondStageRadius = 6.0F;  // px at level 0: the pose is known by then
constexpr float kMaxRadius = 80.0F;         // px
constexpr uint64_t kStream = 0x7265;        // of random draws
constexpr MatcherLimits kSecondStageLimits{.max_distance = 80, .max_ratio = 0.85};

// Of the features that look like a landmark in its window, so many fit to it around a right
// prediction: 0.5 to 1 did (a person before a hand-held camera).
constexpr double kFitWhereRight = 0.6;

// True when so many fit that the prediction is right, 20 to 1.
bool ConfirmsPrediction(int fitting, int similar) {
  // Around one that was wrong by a few pixels 0.05 to 0.36 did (wheels that count backwards).
  constexpr double kWrong = 0.2;
  return LogOdds(fitting, similar, kFitWhereRight, kWrong) > std::log(20.0);
}

// The landmarks of a pose, sorted. match: per feature 0 where it shows one of them, and is taken;
// -1.
std::vector<LandmarkId> Explained(const FoundPose& found, std::vector<int>* match) {
  std::vector<LandmarkId> ids;
  match->assign(found.landmarks.size(), -1);
  for (size_t i = 0; i < found.landmarks.size(); ++i) {
    if (!found.landmarks[i].valid()) continue;
    ids.push_back(found.landmarks[i]);
    (*match)[i] = 0;
  }
  std::sort(ids.begin(), ids.end());
  return ids;
}

}  // namespace

PoseFinder::PoseFinder(const FrontendConfig& config, const RectifiedCamera& camera,
                       const Pyramid& pyramid)
    : config_(config),
      camera_(camera),
      pyramid_(pyramid),
      matcher_(camera, pyramid),
      good_(camera, pyramid) {}

void PoseFinder::SetImage(const FeatureFrame* frame, uint64_t seed) {
  frame_ = frame;
  seed_ = seed;
  grid_ = FeatureGrid(frame->features);
  num_close_ = static_cast<int>(std::count_if(frame->features.begin(), frame->features.end(),
                                              [](const Feature& f) { return f.has_depth(); }));
}

float PoseFinder::SearchRadius(const Matrix6d& cov) const {
  constexpr double kTypicalDepth = 2.0;  // m
  const double sigma_r = std::sqrt(cov.diagonal().tail<3>().maxCoeff());
  const double sigma_t = std::sqrt(cov.diagonal().head<3>().maxCoeff());
  const double px = camera_.fx * std::hypot(sigma_r, sigma_t / kTypicalDepth);
  return std::min(static_cast<float>(3.0 + 2.5 * px), kMaxRadius);
}

std::optional<PosePrior> PoseFinder::PriorFor(const PosePrediction& prediction,
                                              const DrScale& scale) const {
  if (!prediction.has_prior || scale.rotation <= 0) return std::nullopt;
  const Matrix6d cov = ScaledCovariance(prediction.weight_cov, scale, prediction.honest_cov);
  return PosePrior{prediction.T_WC, cov.inverse()};
}

// Matches of the first stage from which a pose is estimated.
int PoseFinder::FewestMatches(const PosePrediction& prediction, const DrScale& scale) const {
  return prediction.any_matches && PriorFor(prediction, scale) ? 0 : config_.min_inliers;
}

// Pose from the current associations; outliers lose their match.
void PoseFinder::Estimate(const SE3& T_WC_start, const std::optional<PosePrior>& prior,
                          Association* a) const {
  std::vector<LandmarkObservation> observations;
  std::vector<size_t> feature_of;
  const SE3 T_CW_start = T_WC_start.inverse();
  for (size_t i = 0; i < a->match.size(); ++i) {
    if (a->match[i] < 0) continue;
    const Eigen::Vector3d& p_W = a->candidates[a->match[i]].point->p_W;
    observations.push_back(
        {p_W, ObservationOf(frame_->features[i], camera_, pyramid_, (T_CW_start * p_W).z())});
    feature_of.push_back(i);
  }
  a->estimate = OptimizePose(camera_, T_WC_start, observations, prior);
  for (size_t k = 0; k < feature_of.size(); ++k) {
    a->outlier[feature_of[k]] = !a->estimate.inlier[k];
    if (!a->estimate.inlier[k]) a->match[feature_of[k]] = -1;
  }
}

// Matches candidates, all of them or what the budget allows, and appends those that were looked for
// to the association's. Returns how many features were matched.
int PoseFinder::Match(const SE3& T_WC, std::vector<Candidate> candidates,
                      const MatcherLimits& limits, int budget, Association* a) const {
  const int first = static_cast<int>(a->candidates.size());
  int matched = 0;
  if (config_.matching == Matching::kAll) {
    matched = matcher_.Match(T_WC, candidates, first, Image(), limits, &a->match);
  } else {
    const Choice choice{config_.matching, budget, seed_ + static_cast<uint64_t>(first),
                        a->estimate.vision_information};
    ChoiceResult result =
        good_.Match(matcher_, T_WC, candidates, first, Image(), limits, choice, &a->match);
    candidates = std::move(result.searched);
    matched = result.matched;
    const auto searched = static_cast<double>(candidates.size());
    if (searched > 0) a->left_out += (result.in_view - searched) * matched / searched;
  }
  a->candidates.insert(a->candidates.end(), candidates.begin(), candidates.end());
  return matched;
}

// Matches the candidates around the prediction, and estimates the pose if they are enough.
void PoseFinder::FirstStage(const PosePrediction& prediction, Association* a) const {
  a->match.assign(frame_->features.size(), -1);
  a->outlier.assign(frame_->features.size(), 0);
  a->estimate = PoseEstimate();
  a->left_out = 0;
  // Half the budget: the rest is for what the last image did not show, without which the pose would
  // drift away from the map.
  a->num_first_stage =
      Match(prediction.T_WC, std::exchange(a->candidates, {}), {}, config_.matching_budget / 2, a);
  int num_close = 0;
  for (size_t i = 0; i < a->match.size(); ++i) {
    num_close += a->match[i] >= 0 && frame_->features[i].has_depth();
  }
  a->quality = ImageQuality({frame_->num_detected, a->num_first_stage}, config_.dr_weight);
  a->quality_close = ImageQuality({num_close_, num_close}, config_.dr_weight);
  a->scale = PriorScale(config_.variant, a->quality, a->quality_close, config_.dr_weight);
  if (a->num_first_stage >= FewestMatches(prediction, a->scale)) {
    Estimate(prediction.T_WC, PriorFor(prediction, a->scale), a);
  }
}

// The other landmarks of the local map around those that are matched (sorted).
std::vector<Candidate> PoseFinder::AroundMatched(const std::vector<LandmarkId>& ids,
                                                 KeyframeId* reference, LocalMap* map) const {
  std::vector<const MapPoint*> points;
  map->CollectAround(ids, *reference, kLocalKeyframes, &points, reference);
  std::vector<Candidate> out;
  for (const MapPoint* point : points) {
    if (std::binary_search(ids.begin(), ids.end(), point->id)) continue;
    out.push_back({point, &point->descriptor, -1, kSecondStageRadius});
  }
  return out;
}

// Second stage: the rest of the local map, in small windows around the pose of the first.
void PoseFinder::SearchLocalMap(const std::optional<PosePrior>& prior, KeyframeId* reference,
                                LocalMap* map, Association* a) const {
  std::vector<LandmarkId> ids;
  for (const int m : a->match) {
    if (m >= 0) ids.push_back(a->candidates[m].point->id);
  }
  std::sort(ids.begin(), ids.end());
  Match(a->estimate.T_WC, AroundMatched(ids, reference, map), kSecondStageLimits,
        config_.matching_budget - static_cast<int>(ids.size()), a);
  Estimate(a->estimate.T_WC, prior, a);
}

void PoseFinder::Complete(LocalMap* map, FoundPose* found) const {
  if (!found->found) return;
  std::vector<int> match;
  const std::vector<LandmarkId> ids = Explained(*found, &match);
  const std::vector<Candidate> candidates = AroundMatched(ids, &found->reference, map);
  matcher_.Match(found->estimate.T_WC, candidates, 1, Image(), kSecondStageLimits, &match);
  const SE3 T_CW = found->estimate.T_WC.inverse();
  for (size_t i = 0; i < match.size(); ++i) {
    if (match[i] < 1) continue;
    const MapPoint& point = *candidates[static_cast<size_t>(match[i]) - 1].point;
    if (Fits(i, T_CW * point.p_W)) found->landmarks[i] = point.id;
  }
}

FoundPose PoseFinder::Result(const Association& a, KeyframeId reference) const {
  FoundPose out;
  out.estimate = a.estimate;
  out.num_tracked = a.num_first_stage;
  out.q = a.quality;
  out.q_close = a.quality_close;
  out.scale = a.scale;
  out.outlier = a.outlier;
  out.reference = reference;
  out.num_matchable = a.estimate.num_inliers + static_cast<int>(a.left_out);
  out.landmarks.resize(frame_->features.size());
  for (size_t i = 0; i < a.match.size(); ++i) {
    if (a.match[i] >= 0) out.landmarks[i] = a.candidates[a.match[i]].point->id;
  }
  return out;
}

// Beside a prior, few inliers are believed when they are as many of the matches of the first stage
// as a right prediction has, and not what chance leaves of a wrong one.
bool PoseFinder::IsFounded(const PosePrediction& prediction, const Association& a,
                           int fewest) const {
  if (fewest == 0 || !PriorFor(prediction, a.scale)) return true;
  if (a.estimate.num_inliers >= Recovery::kConvincingInliers) return true;
  return ConfirmsPrediction(a.estimate.num_inliers, a.num_first_stage);
}

FoundPose PoseFinder::Follow(const PosePrediction& prediction,
                             const std::vector<TrackedPoint>& tracked, KeyframeId reference,
                             LocalMap* map) {
  const bool search_near =
      prediction.vision_broken || tracked.size() < static_cast<size_t>(kFewMatches);
  float radius = SearchRadius(prediction.search_cov);
  std::vector<const MapPoint*> near;
  if (search_near) {
    KeyframeId nearest;
    map->CollectNear(prediction.T_WC, kNearKeyframes, &near, &nearest);
    if (nearest.valid()) reference = nearest;
    radius = std::max(radius, kNearRadius);
  }
  // A window that does not reach the true place still finds look-alikes: the share of inliers
  // tells.
  const auto trust = [](const Association& a) {
    return a.estimate.num_inliers >= kFewMatches &&
           a.estimate.num_inliers >= kTrustedShare * a.num_first_stage;
  };
  Association a;
  Association best;
  for (int attempt = 0; attempt < kAttempts; ++attempt, radius = std::min(2 * radius, kMaxRadius)) {
    a.candidates.clear();
    if (search_near) {
      for (const MapPoint* point : near) {
        a.candidates.push_back({point, &point->descriptor, -1, radius});
      }
    } else {
      for (const TrackedPoint& t : tracked) {
        const MapPoint* point = map->Find(t.id);
        if (point != nullptr) a.candidates.push_back({point, &t.descriptor, t.level, radius});
      }
    }
    FirstStage(prediction, &a);
    if (attempt == 0 || a.estimate.num_inliers > best.estimate.num_inliers) best = a;
    if (trust(best) || radius >= kMaxRadius) break;
  }
  const int fewest = FewestMatches(prediction, best.scale);
  const bool founded = IsFounded(prediction, best, fewest);
  if (best.num_first_stage >= fewest && best.estimate.num_inliers >= fewest / 2) {
    SearchLocalMap(PriorFor(prediction, best.scale), &reference, map, &best);
  }
  FoundPose out = Result(best, reference);
  if (prediction.has_prior && best.scale.rotation > 0) {
    out.bounded =
        EffectiveScale(prediction.weight_cov,
                       ScaledCovariance(prediction.weight_cov, best.scale, prediction.honest_cov));
  }
  int needed = search_near ? kRelocalizedInliers : config_.min_inliers;
  if (fewest == 0) needed = 1;
  if (best.num_first_stage < fewest) {
    out.reason = frame_->num_detected < config_.min_inliers ? TrackingReason::kTooFewFeatures
                                                            : TrackingReason::kTooFewMatches;
  } else if (best.estimate.num_inliers < needed || !founded) {
    out.reason = TrackingReason::kTooFewInliers;
  }
  out.found = out.reason == TrackingReason::kNone;
  return out;
}

bool PoseFinder::Fits(size_t feature, const Eigen::Vector3d& p_C) const {
  return p_C.z() >= kMinProjectionDepth &&
         FitOf(camera_, PixelOf(frame_->features[feature], pyramid_), p_C).pixel_ok();
}

// What `other` leaves unexplained, as a camera at T_WC would see it.
PoseFinder::Rest PoseFinder::RestAt(const SE3& T_WC, const SE3& T_WC_other,
                                    const std::vector<Candidate>& candidates,
                                    std::vector<int> match) const {
  Rest rest;
  rest.similar = matcher_.Match(T_WC, candidates, 1, Image(), kSecondStageLimits, &match);
  rest.match.assign(match.size(), -1);
  const SE3 T_CW = T_WC.inverse(), T_CW_other = T_WC_other.inverse();
  for (size_t i = 0; i < match.size(); ++i) {
    if (match[i] < 1) continue;
    const int k = match[i] - 1;
    const Eigen::Vector3d& p_W = candidates[static_cast<size_t>(k)].point->p_W;
    if (!Fits(i, T_CW * p_W)) continue;
    if (Fits(i, T_CW_other * p_W)) {
      --rest.similar;  // tells nothing
      continue;
    }
    rest.match[i] = k;
    ++rest.fitting;
  }
  return rest;
}

FoundPose PoseFinder::FollowRest(const PosePrediction& prediction, const FoundPose& other,
                                 KeyframeId reference, LocalMap* map) const {
  std::vector<int> match;
  const std::vector<LandmarkId> explained = Explained(other, &match);
  Association a;
  a.outlier.assign(match.size(), 0);
  KeyframeId nearest;
  std::vector<const MapPoint*> points;
  map->CollectNear(prediction.T_WC, kNearKeyframes, &points, &nearest);
  for (const MapPoint* point : points) {
    if (std::binary_search(explained.begin(), explained.end(), point->id)) continue;
    a.candidates.push_back({point, &point->descriptor, -1, kSecondStageRadius});
  }
  const SE3& T_WC_other = other.estimate.T_WC;
  Rest rest = RestAt(prediction.T_WC, T_WC_other, a.candidates, match);
  a.match = std::move(rest.match);
  a.num_first_stage = rest.similar;
  // A handful fits by chance where things look alike; as for any pose, it takes a few.
  bool confirms = rest.fitting >= config_.min_inliers;
  if (confirms) {
    // As far from the other pose to the other side nothing fits but by chance.
    const SE3 T_WC_control = T_WC_other * (prediction.T_WC.inverse() * T_WC_other);
    const Rest control = RestAt(T_WC_control, T_WC_other, a.candidates, std::move(match));
    const double by_chance = (control.fitting + 1.0) / (control.similar + 2.0);
    confirms = by_chance < kFitWhereRight &&
               LogOdds(rest.fitting, rest.similar, kFitWhereRight, by_chance) > kDecisiveLogOdds;
  }
  if (confirms) {
    a.scale = PriorScale(config_.variant, 0, 0, config_.dr_weight);
    Estimate(prediction.T_WC, PriorFor(prediction, a.scale), &a);
  }
  FoundPose out = Result(a, nearest.valid() ? nearest : reference);
  out.found = a.estimate.num_inliers > 0;
  if (!out.found) out.reason = TrackingReason::kTooFewInliers;
  return out;
}

FoundPose PoseFinder::FindAgain(const SE3& T_WC_near, uint64_t seed, LocalMap* map) {
  FoundPose none;
  none.reason = TrackingReason::kTooFewMatches;
  std::vector<const MapPoint*> points;
  KeyframeId reference;
  map->CollectNear(T_WC_near, kLocalKeyframes, &points, &reference);
  const auto pairs =
      PairDescriptors(camera_, pyramid_, frame_->features, frame_->descriptors, points);
  const auto hypothesis =
      FindPose(camera_, pairs, config_.min_inliers, CounterRng(seed, kStream, 0));
  if (!hypothesis) return none;
  PosePrediction prediction;
  prediction.T_WC = hypothesis->T_WC;
  Association a;
  for (const MapPoint* point : points)
    a.candidates.push_back({point, &point->descriptor, -1, 8.0F});
  FirstStage(prediction, &a);
  if (a.estimate.num_inliers < config_.min_inliers) return none;
  SearchLocalMap(std::nullopt, &reference, map, &a);
  FoundPose out = Result(a, reference);
  out.found = a.estimate.num_inliers >= kRelocalizedInliers;
  if (!out.found) out.reason = TrackingReason::kTooFewInliers;
  return out;
}

}  // namespace gw::frontend
