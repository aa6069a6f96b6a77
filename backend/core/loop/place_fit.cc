#include "backend/core/loop/place_fit.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <map>

#include "backend/core/map/seen_landmarks.h"
#include "backend/core/mapping/matching.h"
#include "common/vision/descriptor_pairing.h"
#include "common/vision/pose_optimizer.h"
#include "common/vision/pose_ransac.h"

namespace gw::backend {
namespace {

constexpr uint64_t kStream = 0x706C6163;
constexpr int kFewestAgreeing = 12;  // pairs that RANSAC must reconcile
constexpr int kGuidedRounds = 2;
constexpr double kFloorTranslation = 0.01;  // m
constexpr double kFloorRotation = 0.003;    // rad

std::vector<const Landmark*> LandmarksOf(const Map& map, const std::vector<KeyframeId>& group) {
  std::vector<const Landmark*> out;
  for (const LandmarkId id : SeenLandmarks(map, group)) out.push_back(map.FindLandmark(id));
  return out;
}

struct GuidedMatch {
  const Landmark* landmark = nullptr;
  int distance = 257;
};

// Feature -> the landmark that it shows when the image was taken at T_WC.
std::map<int, GuidedMatch> SearchGuided(const MappingContext& context, const MapKeyframe& image,
                                        const std::vector<const Landmark*>& landmarks,
                                        const SE3& T_WC, int* num_expected) {
  std::map<int, GuidedMatch> out;
  const SE3 T_CW = T_WC.inverse();
  *num_expected = 0;
  for (const Landmark* landmark : landmarks) {
    const auto expected = Project(context, *landmark, T_WC, T_CW);
    if (!expected) continue;
    ++*num_expected;
    const int feature = FindFeature(context, *landmark, *expected, image);
    if (feature < 0) continue;
    const int distance = HammingDistance(landmark->descriptor, image.frame.descriptors[feature]);
    GuidedMatch& match = out[feature];
    if (distance < match.distance) match = {landmark, distance};
  }
  return out;
}

// Share of the cells with kExpectedInCell landmarks or more that show kSeenInCell of them.
double Coverage(const MappingContext& context, const MapKeyframe& image,
                const std::vector<const Landmark*>& landmarks, const PlaceFit& fit) {
  constexpr int kColumns = 6;
  constexpr int kRows = 4;
  constexpr int kExpectedInCell = 10;
  constexpr int kSeenInCell = 3;
  const auto cell = [&](double u, double v) {
    const int column = static_cast<int>(u * kColumns / context.camera.width);
    const int row = static_cast<int>(v * kRows / context.camera.height);
    return std::clamp(row, 0, kRows - 1) * kColumns + std::clamp(column, 0, kColumns - 1);
  };
  std::array<int, kColumns * kRows> expected{};
  std::array<int, kColumns * kRows> seen{};
  const SE3 T_CW = fit.T_WC.inverse();
  for (const Landmark* landmark : landmarks) {
    const auto projection = Project(context, *landmark, fit.T_WC, T_CW);
    if (projection) ++expected[cell(projection->uv.x(), projection->uv.y())];
  }
  for (const PlaceFit::Match& match : fit.matches) {
    const Feature& f = image.frame.features[match.feature];
    ++seen[cell(f.u, f.v)];
  }
  int asked = 0, answered = 0;
  for (size_t i = 0; i < expected.size(); ++i) {
    if (expected[i] < kExpectedInCell) continue;
    ++asked;
    answered += seen[i] >= kSeenInCell ? 1 : 0;
  }
  return asked > 0 ? static_cast<double>(answered) / asked : 0;
}

}  // namespace

Matrix6d FitCovariance(const PlaceFit& fit) {
  Matrix6d cov = fit.information.inverse();
  cov.diagonal().head<3>().array() += kFloorTranslation * kFloorTranslation;
  cov.diagonal().tail<3>().array() += kFloorRotation * kFloorRotation;
  return cov;
}

bool SeesItsShare(const PlaceFit& fit) {
  return static_cast<double>(fit.matches.size()) >= kFewestShare * fit.num_expected;
}

bool SeesAllAround(const PlaceFit& fit) {
  return fit.coverage >= kFewestCoverage;
}

bool IsOneOf(const Map& map, const std::vector<KeyframeId>& places, KeyframeId keyframe) {
  return std::any_of(places.begin(), places.end(), [&](KeyframeId place) {
    return place == keyframe || map.SharedLandmarks(place, keyframe) >= kSamePlaceShared;
  });
}

std::vector<KeyframeId> PlaceGroup(const Map& map, KeyframeId centre) {
  std::vector<KeyframeId> group{centre};
  for (const auto& [id, shared] : map.Neighbours(centre, 1)) {
    if (group.size() == kGroupSize) break;
    group.push_back(id);
  }
  return group;
}

std::optional<PlaceFit> FitPlace(const Map& map, const MappingContext& context,
                                 const MapKeyframe& image, const std::vector<KeyframeId>& group,
                                 uint64_t seed) {
  const std::vector<const Landmark*> landmarks = LandmarksOf(map, group);
  const auto pairs = PairDescriptors(context.camera, context.pyramid, image.frame.features,
                                     image.frame.descriptors, landmarks);
  const auto hypothesis =
      FindPose(context.camera, pairs, kFewestAgreeing, CounterRng(seed, kStream, 0));
  if (!hypothesis) return std::nullopt;
  PlaceFit out;
  out.T_WC = hypothesis->T_WC;
  for (int round = 0; round < kGuidedRounds; ++round) {
    const SE3 T_CW = out.T_WC.inverse();
    const auto guided = SearchGuided(context, image, landmarks, out.T_WC, &out.num_expected);
    std::vector<LandmarkObservation> observations;
    std::vector<PlaceFit::Match> matches;
    for (const auto& [feature, match] : guided) {
      const Eigen::Vector3d& p_W = match.landmark->p_W;
      observations.push_back({p_W, ObservationOf(image.frame.features[feature], context.camera,
                                                 context.pyramid, (T_CW * p_W).z())});
      matches.push_back({feature, match.landmark->id});
    }
    if (static_cast<int>(matches.size()) < kFewestAgreeing) return std::nullopt;
    const PoseEstimate estimate =
        OptimizePose(context.camera, out.T_WC, observations, std::nullopt);
    out.T_WC = estimate.T_WC;
    out.information = estimate.vision_information;
    out.matches.clear();
    for (size_t i = 0; i < matches.size(); ++i) {
      if (estimate.inlier[i] != 0) out.matches.push_back(matches[i]);
    }
  }
  if (static_cast<int>(out.matches.size()) < kFewestMatches || !out.T_WC.IsFinite()) {
    return std::nullopt;
  }
  out.coverage = Coverage(context, image, landmarks, out);
  return out;
}

}  // namespace gw::backend
