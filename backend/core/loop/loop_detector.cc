#include "backend/core/loop/loop_detector.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "common/core/covariance.h"
#include "common/good_weights/camera_motion.h"

namespace gw::backend {
namespace {

constexpr int kRecent = 10;           // keyframes just before it, or after, are no loop
constexpr int kStrongNeighbour = 15;  // shared landmarks
constexpr size_t kMaxByLook = 3;      // candidates from place recognition
constexpr size_t kMaxByDr = 2;        // candidates from dead reckoning
constexpr double kMinScore = 0.03;    // photographs of other places reach 0.11 (ADR 6): no gate,
constexpr int kMinMatches = 20;       // only what is worth a geometric check
constexpr int kAgree = 2;             // of the kWitnesses keyframes before must share the fit
constexpr int kWitnesses = 4;
constexpr double kAgreeTranslation = 0.25;  // m
constexpr double kAgreeRotation = 4.0 * std::numbers::pi / 180.0;

// Keyframes that the map already relates to this one.
std::set<KeyframeId> Related(const Map& map, KeyframeId at) {
  std::set<KeyframeId> out{at};
  for (const auto& [id, shared] : map.FindKeyframe(at)->covisible) {
    out.insert(id);
    for (const auto& [second, weight] : map.Neighbours(id, kStrongNeighbour)) out.insert(second);
  }
  const auto here = map.keyframes().find(at);
  auto before = here, after = here;
  for (int i = 0; i < kRecent; ++i) {
    if (before != map.keyframes().begin()) out.insert((--before)->first);
    if (after != map.keyframes().end()) ++after;
    if (after != map.keyframes().end()) out.insert(after->first);
  }
  return out;
}

void AddByLook(const Map& map, const PlaceIndex& places, const MapKeyframe& from,
               const std::set<KeyframeId>& related, std::vector<KeyframeId>& out) {
  for (const PlaceScore& place : places.Query(from.frame.descriptors)) {
    if (out.size() == kMaxByLook || place.score < kMinScore) break;
    if (place.num_matches < kMinMatches || related.contains(place.keyframe)) continue;
    if (place.keyframe > from.frame.id || map.PieceOf(place.keyframe) != from.frame.piece) continue;
    if (!IsOneOf(map, out, place.keyframe)) out.push_back(place.keyframe);
  }
}

// The nearest keyframes that look the same way and lie within three sigma of the drift of dead
// reckoning since then.
void AddByDr(const Map& map, const MappingContext& context, const MapKeyframe& from,
             const std::set<KeyframeId>& related, std::vector<KeyframeId>& out) {
  constexpr double kReach = 0.5;  // m: sights overlap that far even without drift
  const double cos_view = std::cos(std::numbers::pi / 6);
  const Eigen::Vector3d view_W = from.frame.T_WC.rotation() * Eigen::Vector3d::UnitZ();
  std::vector<std::pair<double, KeyframeId>> near;
  Matrix6d cov = Matrix6d::Zero();
  const MapKeyframe* at = &from;
  while (at->frame.dr) {
    const MapKeyframe* before = map.FindKeyframe(at->frame.previous);
    if (before == nullptr) break;
    const DrMotion motion = CameraMotion(*at->frame.dr, context.camera.T_BC, context.dr_weight);
    const Matrix6d adj = (at->frame.T_WC.inverse() * from.frame.T_WC).inverse().Adjoint();
    cov += adj * motion.cov * adj.transpose();
    at = before;
    if (related.contains(at->frame.id) || at->num_observations == 0) continue;
    const SE3 T_ab = at->frame.T_WC.inverse() * from.frame.T_WC;
    const double distance = T_ab.translation().norm();
    const double sigma = std::sqrt(cov.topLeftCorner<3, 3>().trace());
    if (distance > kReach + 3 * sigma) continue;
    if (view_W.dot(at->frame.T_WC.rotation() * Eigen::Vector3d::UnitZ()) < cos_view) continue;
    near.push_back({distance, at->frame.id});
  }
  std::sort(near.begin(), near.end());
  size_t taken = 0;
  for (const auto& [distance, id] : near) {
    if (taken == kMaxByDr) break;
    if (IsOneOf(map, out, id)) continue;
    out.push_back(id);
    ++taken;
  }
}

// How many of the keyframes before it fit the group with the same correction of the map.
int Witnesses(const Map& map, const MappingContext& context, const MapKeyframe& from,
              const std::vector<KeyframeId>& group, const PlaceFit& fit) {
  const SE3 correction = fit.T_WC * from.frame.T_WC.inverse();
  int agree = 0;
  const MapKeyframe* at = map.FindKeyframe(from.frame.previous);
  for (int i = 0; i < kWitnesses && at != nullptr && agree < kAgree; ++i) {
    const auto other =
        FitPlace(map, context, *at, group, static_cast<uint64_t>(at->frame.id.value));
    if (other && SeesItsShare(*other)) {
      const SE3 error = (correction * at->frame.T_WC).inverse() * other->T_WC;
      agree += error.translation().norm() < kAgreeTranslation &&
                       LogSO3(error.rotation()).norm() < kAgreeRotation
                   ? 1
                   : 0;
    }
    at = map.FindKeyframe(at->frame.previous);
  }
  return agree;
}

}  // namespace

std::optional<DrChain> ChainDr(const Map& map, const MappingContext& context, KeyframeId older,
                               KeyframeId newer) {
  DrChain out;
  const MapKeyframe* at = map.FindKeyframe(newer);
  while (at != nullptr && at->frame.id != older) {
    if (!at->frame.dr) return std::nullopt;
    const DrMotion motion = CameraMotion(*at->frame.dr, context.camera.T_BC, context.dr_weight);
    // An error at the end of this step, seen at the end of the chain.
    const Matrix6d adj = out.T_OlderNewer.inverse().Adjoint();
    out.cov += adj * motion.cov * adj.transpose();
    out.T_OlderNewer = motion.T_CaCb * out.T_OlderNewer;
    at = map.FindKeyframe(at->frame.previous);
  }
  if (at == nullptr) return std::nullopt;
  return out;
}

double DrContradiction(const DrChain& chain, const SE3& T_OlderNewer, const Matrix6d& cov_loop) {
  const Vector6d error = (chain.T_OlderNewer.inverse() * T_OlderNewer).Log();
  const Matrix6d cov = chain.cov + cov_loop;
  return error.dot(Eigen::LDLT<Matrix6d>(cov).solve(error));
}

std::optional<Loop> DetectLoop(const Map& map, const MappingContext& context,
                               const PlaceIndex& places, KeyframeId at, LoopCounters& counters) {
  const MapKeyframe* from = map.FindKeyframe(at);
  if (from == nullptr) return std::nullopt;
  const std::set<KeyframeId> related = Related(map, at);
  if (related.size() == map.keyframes().size()) return std::nullopt;
  std::vector<KeyframeId> candidates;
  AddByLook(map, places, *from, related, candidates);
  const bool use_dr =
      DrInLocalBa(context.variant) && context.dr_weight.Departs(Departure::kLoopTest);
  if (use_dr) AddByDr(map, context, *from, related, candidates);
  for (const KeyframeId candidate : candidates) {
    ++counters.candidates;
    std::vector<KeyframeId> group = PlaceGroup(map, candidate);
    std::erase_if(group, [&](KeyframeId id) { return related.contains(id); });
    const auto fit = FitPlace(map, context, *from, group, static_cast<uint64_t>(at.value));
    if (!fit || !SeesItsShare(*fit)) continue;
    ++counters.fits;
    if (Witnesses(map, context, *from, group, *fit) < kAgree) {
      ++counters.inconsistent;
      continue;
    }
    const Matrix6d cov = FitCovariance(*fit);
    Loop loop;
    loop.older = candidate;
    loop.newer = at;
    loop.T_OlderNewer = map.FindKeyframe(candidate)->frame.T_WC.inverse() * fit->T_WC;
    loop.matches = fit->matches;
    loop.sqrt_information = SqrtInformation(cov);
    const auto chain = use_dr ? ChainDr(map, context, loop.older, loop.newer) : std::nullopt;
    if (chain && DrContradiction(*chain, loop.T_OlderNewer, cov) > kDrGate) {
      ++counters.refused_by_dr;
      continue;
    }
    return loop;
  }
  return std::nullopt;
}

}  // namespace gw::backend
