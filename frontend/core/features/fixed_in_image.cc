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
// A residual beyond five sigmas says that the hypothesis does not hold, and no more. More than
// twice kDecisiveLogOdds, or no window could decide.
constexpr double kMaxChi2 = 25.0;
constexpr double kMovedWay = 0.03;   // m, and
constexpr double kMovedTurn = 0.02;  // rad: more than vision that stands still makes of noise
constexpr double kNewest = 0.1;      // weight of an image in the mean over about a second
constexpr int kWitnesses = 10;       // features that can speak for DR, or against it

// chi2: of a residual, with this covariance.
double LogLikelihood(double chi2, const Eigen::Matrix2d& cov) {
  return -0.5 * (std::min(chi2, kMaxChi2) + std::log(cov.determinant()));
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
  Decide(step && step->refuted);
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

FixedInImage::Prediction FixedInImage::Predict(const Track& t, const SE3& T_0,
                                               const Vector6d& variance) const {
  const Eigen::Vector3d p = T_0.inverse() * t.p_0;
  if (!(p.z() > kNearest)) return {-0.5 * kMaxChi2, -0.5 * kMaxChi2};
  const double s = pyramid_.Scale(t.level);
  const double iz = 1 / p.z();
  Eigen::Matrix<double, 2, 3> J;                           // d pixel / d p
  J << camera_.fx * iz, 0, -camera_.fx * p.x() * iz * iz,  //
      0, camera_.fy * iz, -camera_.fy * p.y() * iz * iz;
  Eigen::Matrix<double, 2, 6> J_T;
  J_T << -J, J * Skew(p);
  const double sigma_z = s * t.p_0.z() * t.p_0.z() / camera_.bf();
  const Eigen::Vector2d along = J * (T_0.rotation().inverse() * t.p_0) * (sigma_z / t.p_0.z());
  const Eigen::Matrix2d own = 2 * s * s * Eigen::Matrix2d::Identity() + along * along.transpose();
  const Eigen::Matrix2d cov = own + J_T * variance.asDiagonal() * J_T.transpose();
  const Eigen::Vector2d residual = t.uv - camera_.Project(p);
  const double chi2 = residual.dot(cov.inverse() * residual);
  return {LogLikelihood(chi2, own), LogLikelihood(chi2, cov)};
}

std::optional<FixedInImage::Likelihoods> FixedInImage::Explain(const Track& t) const {
  const Anchor* anchor = AnchorOf(t);
  if (t.feature < 0 || anchor == nullptr || !anchor->T_late) return std::nullopt;
  const double s = pyramid_.Scale(t.level);
  const Eigen::Matrix2d own = 2 * s * s * Eigen::Matrix2d::Identity();
  const Vector6d variance = anchor->Variance();
  Likelihoods out;
  out.neither = LogLikelihood(kMaxChi2, own);
  out.fixed = LogLikelihood((t.uv - t.uv_0).dot(own.inverse() * (t.uv - t.uv_0)), own);
  out.world = out.told = out.neither;
  for (const SE3& T_0 : {anchor->T, *anchor->T_late, anchor->T_first->inverse() * anchor->T}) {
    const Prediction dr = Predict(t, T_0, variance);
    out.world = std::max(out.world, dr.fits);
    out.told = std::max(out.told, dr.told);
  }
  // Vision that does not move may be held by what stands still, and says nothing.
  if (anchor->T_seen && Moves(*anchor->T_seen)) {
    out.seen = std::max(out.neither, Predict(t, *anchor->T_seen, Vector6d::Zero()).told);
  }
  return out;
}

// Features that move as DR says, and neither as vision says nor not at all; 0 where as many move as
// vision says, and not as DR does.
int FixedInImage::WitnessesOfDr(const std::vector<std::optional<Likelihoods>>& explained) {
  int as_dr = 0, as_vision = 0;
  for (const auto& l : explained) {
    if (!l) continue;
    const double seen = l->seen.value_or(l->fixed);
    as_dr += l->told - std::max(l->fixed, seen) > kDecisiveLogOdds;
    as_vision += seen - std::max(l->fixed, l->told) > kDecisiveLogOdds;
  }
  return as_dr > as_vision ? as_dr : 0;
}

FixedInImage::Vote FixedInImage::VoteOf(const Likelihoods& l) {
  if (l.fixed - l.moving() > kDecisiveLogOdds) return Vote::kFixed;
  if (l.told - l.fixed > kDecisiveLogOdds) return Vote::kWorld;
  const bool as_vision_says = l.moving() - std::max(l.fixed, l.world) > kDecisiveLogOdds;
  const bool no_way = l.fixed <= l.neither && l.world <= l.neither;
  return as_vision_says || no_way ? Vote::kNeither : Vote::kNone;
}

// DR is contradicted where most of what is known to be of the world does not move as it says. Where
// little is known, by what moves otherwise, if that is more than what moves as DR says and more
// than what may be fixed.
bool FixedInImage::Contradicted(const std::vector<Vote>& votes) const {
  int known_as_dr = 0, known_otherwise = 0, as_dr = 0, otherwise = 0, maybe_fixed = 0;
  for (size_t i = 0; i < votes.size(); ++i) {
    const bool known = tracks_[i].kind == Kind::kWorld;
    as_dr += votes[i] == Vote::kWorld;
    otherwise += votes[i] == Vote::kNeither;
    maybe_fixed += votes[i] == Vote::kFixed;
    known_as_dr += known && votes[i] == Vote::kWorld;
    known_otherwise += known && (votes[i] == Vote::kFixed || votes[i] == Vote::kNeither);
  }
  if (known_as_dr + known_otherwise >= kWitnesses) return known_otherwise > known_as_dr;
  return otherwise > std::max(as_dr, maybe_fixed);
}

// What the image says of its tracks. Anchors are taken anew where it says something.
void FixedInImage::Decide(bool dr_refuted) {
  std::vector<std::optional<Likelihoods>> explained(tracks_.size());
  for (size_t i = 0; i < tracks_.size(); ++i) explained[i] = Explain(tracks_[i]);
  const int witnesses = WitnessesOfDr(explained);
  if (witnesses > 0) {
    // Vision is drawn along.
    for (auto& l : explained) {
      if (l) l->seen.reset();
    }
  }
  std::vector<Vote> votes(tracks_.size(), Vote::kNone);
  for (size_t i = 0; i < tracks_.size(); ++i) {
    if (explained[i]) votes[i] = VoteOf(*explained[i]);
  }
  const bool contradicted = Contradicted(votes) || (dr_refuted && witnesses < kWitnesses);
  contradicted_ += kNewest * ((contradicted ? 1 : 0) - contradicted_);
  const bool believed = !contradicted && contradicted_ < 0.5;
  if (!any()) since_ = {std::numeric_limits<int64_t>::max()};
  num_fixed_ = 0;
  for (size_t i = 0; i < tracks_.size(); ++i) {
    Track& t = tracks_[i];
    if (believed && explained[i]) Learn(*explained[i], &t);
    // What DR that is wrong has told of it so far is void.
    if (!believed && t.kind == Kind::kUnknown) t.log_odds = t.log_odds_before = 0;
    if (t.feature < 0) continue;
    kind_[static_cast<size_t>(t.feature)] = t.kind;
    num_fixed_ += t.kind == Kind::kFixed;
    // Judged: the next anchor is taken from here.
    if (votes[i] != Vote::kNone) t.anchor = kNoAnchor;
  }
  prevails_ = Share() > (prevails_ ? kNoRisk : kRisk);
}

// The odds of the windows before and of this one.
void FixedInImage::Learn(const Likelihoods& l, Track* t) {
  t->log_odds =
      std::clamp(t->log_odds_before + l.fixed - l.moving(), -kDecisiveLogOdds, kDecisiveLogOdds);
  if (t->log_odds == kDecisiveLogOdds) {
    if (t->kind != Kind::kFixed) since_ = std::min(since_, t->since);
    t->kind = Kind::kFixed;
  }
  if (t->log_odds == -kDecisiveLogOdds) {
    t->kind = Kind::kWorld;
    t->since = AnchorOf(*t)->utime;
  }
}

// The share x that explains best what was found of all tracks, each of which has the likelihood
// x exp(log_odds) + 1 - x, with kPriorWorld of the world besides: where its derivative, which
// falls, is zero.
double FixedInImage::Share() const {
  std::vector<double> excess;  // of fixed over world
  excess.reserve(tracks_.size());
  for (const Track& t : tracks_) excess.push_back(std::expm1(t.log_odds));
  double least = 0, most = 1;
  for (int i = 0; i < 12; ++i) {
    const double x = (least + most) / 2;
    double slope = -kPriorWorld / (1 - x);
    for (const double e : excess) slope += e / (1 + x * e);
    (slope > 0 ? least : most) = x;
  }
  return least;
}

void FixedInImage::AnchorTrack(Track* t, const Feature& f) const {
  t->log_odds_before = t->log_odds;
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
    t.seen = t.since = utime;
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
