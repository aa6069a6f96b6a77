#include "frontend/core/features/fixed_in_image.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "common/core/log_odds.h"
#include "common/vision/feature_grid.h"
#include "common/vision/projection_search.h"

namespace gw::frontend {
namespace {

constexpr DurationUs kLateness = Milliseconds(200);  // by which DR may be late
constexpr DurationUs kBetweenAnchors = Milliseconds(100);
constexpr DurationUs kLongest = Milliseconds(3000);    // that DR is composed over
constexpr DurationUs kMaxMissing = Milliseconds(300);  // of a track: the emitter may blink
constexpr int kMaxDistance = 80;   // Hamming, from one image to the next: windows are small
constexpr double kNearest = 0.05;  // m
constexpr double kWindow = 3.0;    // px at level 0, around where it may be
// A residual beyond five sigmas says that the hypothesis does not hold, and no more.
constexpr double kMaxChi2 = 25.0;
constexpr double kMovedWay = 0.03;   // m, and
constexpr double kMovedTurn = 0.02;  // rad: more than vision that stands still makes of noise
constexpr double kMemory = 200;      // votes
constexpr int kWitnesses = 10;       // votes of features that are known to move, to outvote DR

double LogLikelihood(const Eigen::Vector2d& residual, const Eigen::Matrix2d& cov) {
  const double chi2 = std::min(residual.dot(cov.inverse() * residual), kMaxChi2);
  return -0.5 * (chi2 + std::log(cov.determinant()));
}

bool Moves(const SE3& T) {
  return T.translation().norm() > kMovedWay || LogSO3(T.rotation()).norm() > kMovedTurn;
}

}  // namespace

void FixedInImage::Observe(Utime utime, const FeatureFrame& frame,
                           const std::optional<CameraStep>& step) {
  Move(utime, step);
  const bool anchor_due = anchors_.empty() || utime - anchors_.back().utime >= kBetweenAnchors;
  kind_.assign(frame.features.size(), Kind::kUnknown);
  // Between anchors there is work only where something has to be left out.
  if (!anchor_due && !any()) return;
  Follow(utime, frame);
  Decide();
  if (anchor_due) SetAnchor(utime, frame);
}

// Brings anchors and tracks to the camera of now.
void FixedInImage::Move(Utime utime, const std::optional<CameraStep>& step) {
  if (!step) {
    first_anchor_ += anchors_.size();
    anchors_.clear();
    recent_.clear();
    return;
  }
  recent_.push_back({utime, step->T_ab});
  while (recent_.size() > 1 && utime - recent_.front().utime > kLateness) recent_.pop_front();
  SE3 T_recent;
  for (const Step& s : recent_) T_recent = T_recent * s.T_ab;
  const SE3 T_ba = step->T_ab.inverse();
  const double way = step->T_ab.translation().norm();
  for (Anchor& a : anchors_) {
    a.T = a.T * step->T_ab;
    // What the direction is off moves the end of this step aside.
    a.white.head<3>().array() += way * way * a.white.tail<3>().maxCoeff();
    a.common.head<3>().array() += way * a.common.tail<3>().maxCoeff();
    a.white += step->white;
    a.common += step->common;
    if (utime - a.utime > kLateness) {
      a.T_late = a.T * T_recent.inverse();
      if (!a.T_first) a.T_first = a.T;
    }
    if (!step->T_ab_seen) a.T_seen.reset();
    if (a.T_seen) a.T_seen = *a.T_seen * *step->T_ab_seen;
  }
  while (!anchors_.empty() && utime - anchors_.front().utime > kLongest) {
    anchors_.pop_front();
    ++first_anchor_;
  }
  const SE3 T_ba_seen = step->T_ab_seen.value_or(step->T_ab).inverse();
  for (Track& t : tracks_) {
    t.p = T_ba * t.p;
    t.p_seen = T_ba_seen * t.p_seen;
  }
}

// Finds the tracks again, where they were or where the motion puts them.
void FixedInImage::Follow(Utime utime, const FeatureFrame& frame) {
  const FeatureGrid grid(frame.features);
  const SearchableImage image{frame.features, frame.descriptors, grid};
  std::vector<bool> taken(frame.features.size(), false);
  for (Track& t : tracks_) {
    const auto find = [&](const Eigen::Vector2d& uv) {
      Projection expected;
      expected.uv = uv;
      expected.level = t.level;
      return FindMostSimilar(image, expected, static_cast<float>(kWindow * pyramid_.Scale(t.level)),
                             t.descriptor, kMaxDistance,
                             [&](int i) { return !taken[static_cast<size_t>(i)]; });
    };
    BestFeature best = find(t.uv);
    for (const Eigen::Vector3d& p : {t.p, t.p_seen}) {
      if (!(p.z() > kNearest)) continue;
      const BestFeature other = find(camera_.Project(p));
      if (other.distance < best.distance) best = other;
    }
    t.feature = best.index;
    if (best.index < 0) continue;
    const auto k = static_cast<size_t>(best.index);
    const Feature& f = frame.features[k];
    taken[k] = true;
    t.uv = {f.u, f.v};
    // Without depth of its own the feature keeps the distance that the motion gives it.
    const double z = f.has_depth() ? f.depth : t.p.z();
    if (z > 0) t.p = t.p_seen = camera_.Unproject(t.uv.x(), t.uv.y(), z);
    t.descriptor = frame.descriptors[k];
    t.level = f.level;
    t.seen = utime;
  }
  std::erase_if(tracks_, [&](const Track& t) { return utime - t.seen > kMaxMissing; });
}

double FixedInImage::WorldLikelihood(const Track& t, const SE3& T_0,
                                     const Vector6d& variance) const {
  const Eigen::Vector3d p = T_0.inverse() * t.p_0;
  if (!(p.z() > kNearest)) return -0.5 * kMaxChi2;
  const double s = pyramid_.Scale(t.level);
  const double iz = 1 / p.z();
  Eigen::Matrix<double, 2, 3> J;                           // d pixel / d p
  J << camera_.fx * iz, 0, -camera_.fx * p.x() * iz * iz,  //
      0, camera_.fy * iz, -camera_.fy * p.y() * iz * iz;
  Eigen::Matrix<double, 2, 6> J_T;
  J_T << -J, J * Skew(p);
  const double sigma_z = s * t.p_0.z() * t.p_0.z() / camera_.bf();
  const Eigen::Vector2d along = J * (T_0.rotation().inverse() * t.p_0) * (sigma_z / t.p_0.z());
  const Eigen::Matrix2d cov = 2 * s * s * Eigen::Matrix2d::Identity() +
                              J_T * variance.asDiagonal() * J_T.transpose() +
                              along * along.transpose();
  return LogLikelihood(t.uv - camera_.Project(p), cov);
}

FixedInImage::Vote FixedInImage::Judge(const Track& t) const {
  const Anchor* anchor = AnchorOf(t);
  if (t.feature < 0 || anchor == nullptr || !anchor->T_late) return Vote::kNone;
  const double s = pyramid_.Scale(t.level);
  const Eigen::Matrix2d still = 2 * s * s * Eigen::Matrix2d::Identity();
  const double fixed = LogLikelihood(t.uv - t.uv_0, still);
  const Vector6d variance = anchor->Variance();
  const double world = std::max(
      {WorldLikelihood(t, anchor->T, variance), WorldLikelihood(t, *anchor->T_late, variance),
       WorldLikelihood(t, anchor->T_first->inverse() * anchor->T, variance)});
  // As vision says, where it says that the camera moves: then it is not held by what stands still.
  double seen = world;
  if (anchor->T_seen && Moves(*anchor->T_seen)) {
    seen = WorldLikelihood(t, *anchor->T_seen, Vector6d::Zero());
  }
  if (fixed - std::max(world, seen) > kDecisiveLogOdds) return Vote::kFixed;
  if (world - fixed > kDecisiveLogOdds) return Vote::kWorld;
  const bool moves = seen - std::max(fixed, world) > kDecisiveLogOdds;
  const double neither = LogLikelihood(Eigen::Vector2d(1e6, 1e6), still);
  return moves || (fixed <= neither && world <= neither) ? Vote::kNeither : Vote::kNone;
}

// What the image says of its tracks. Anchors are taken anew where it says something.
void FixedInImage::Decide() {
  std::vector<Vote> votes(tracks_.size());
  // Counts among the features that are known to move with the world, and among the others.
  int known_world = 0, known_other = 0, other_fixed = 0, other_neither = 0;
  for (size_t i = 0; i < tracks_.size(); ++i) {
    votes[i] = Judge(tracks_[i]);
    if (tracks_[i].kind == Kind::kWorld) {
      known_world += votes[i] == Vote::kWorld;
      known_other += votes[i] == Vote::kFixed || votes[i] == Vote::kNeither;
    } else {
      other_fixed += votes[i] == Vote::kFixed;
      other_neither += votes[i] == Vote::kNeither;
    }
  }
  // Those that are known judge DR; where they are out of sight, what they said lately stands, and
  // the others have a say where nobody did.
  bool dr_wrong = known_other > known_world;
  if (known_world + known_other < kWitnesses) {
    dr_wrong = votes_world_ < kPriorWorld && other_neither > other_fixed;
  }
  if (!any()) since_ = {std::numeric_limits<int64_t>::max()};
  num_fixed_ = 0;
  int fixed = 0, world = 0;
  for (size_t i = 0; i < tracks_.size(); ++i) {
    Track& t = tracks_[i];
    if (!dr_wrong && votes[i] == Vote::kWorld) {
      ++world;
      t.kind = Kind::kWorld;
    }
    if (!dr_wrong && votes[i] == Vote::kFixed) {
      ++fixed;
      if (t.kind != Kind::kFixed) since_ = std::min(since_, AnchorOf(t)->utime);
      t.kind = Kind::kFixed;
    }
    if (t.feature < 0) continue;
    kind_[static_cast<size_t>(t.feature)] = t.kind;
    num_fixed_ += t.kind == Kind::kFixed;
    // Judged: the next anchor is taken from here.
    if (votes[i] != Vote::kNone) t.anchor = kNoAnchor;
  }
  const double kept = std::exp(-(fixed + world) / kMemory);
  votes_fixed_ = kept * votes_fixed_ + fixed;
  votes_world_ = kept * votes_world_ + world;
  const double judged = votes_fixed_ + votes_world_ + kPriorWorld;
  prevails_ = votes_fixed_ > (prevails_ ? kNoRisk : kRisk) * judged;
}

void FixedInImage::AnchorTrack(Track* t, const Feature& f) const {
  t->uv_0 = t->uv = {f.u, f.v};
  t->p_0 = t->p = t->p_seen = camera_.Unproject(f.u, f.v, f.depth);
  t->anchor = first_anchor_ + anchors_.size() - 1;
}

// From this image on, new features are followed, and those that were judged are judged again.
void FixedInImage::SetAnchor(Utime utime, const FeatureFrame& frame) {
  anchors_.emplace_back().utime = utime;
  std::vector<bool> followed(frame.features.size(), false);
  for (Track& t : tracks_) {
    if (t.feature < 0) continue;
    const Feature& f = frame.features[static_cast<size_t>(t.feature)];
    followed[static_cast<size_t>(t.feature)] = true;
    if (AnchorOf(t) == nullptr && f.has_depth()) AnchorTrack(&t, f);
  }
  for (size_t i = 0; i < frame.features.size(); ++i) {
    const Feature& f = frame.features[i];
    if (followed[i] || !f.has_depth()) continue;
    Track t;
    t.descriptor = frame.descriptors[i];
    t.level = f.level;
    t.seen = utime;
    t.feature = static_cast<int>(i);
    AnchorTrack(&t, f);
    tracks_.push_back(t);
  }
}

FeatureFrame FixedInImage::Without(const FeatureFrame& frame) const {
  FeatureFrame out;
  const bool only_world = Prevails();
  for (size_t i = 0; i < frame.features.size(); ++i) {
    if (kind_[i] == Kind::kFixed || (only_world && kind_[i] != Kind::kWorld)) continue;
    out.features.push_back(frame.features[i]);
    out.descriptors.push_back(frame.descriptors[i]);
  }
  const auto left_out = static_cast<int>(frame.features.size() - out.features.size());
  out.num_detected = std::max(frame.num_detected - left_out, 0);
  return out;
}

}  // namespace gw::frontend
