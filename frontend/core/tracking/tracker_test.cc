// The tracker in a synthetic room: points with descriptors on four walls, a robot that drives a
// curve, no pixels. GIVEN what the camera and the wheels see, the claims are about poses.
#include "frontend/core/tracking/tracker.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <functional>
#include <map>

#include "common/core/random.h"
#include "frontend/core/place/recovery.h"

namespace gw::frontend {
namespace {

constexpr int64_t kFrameUs = 33333;

struct Room {
  struct Point {
    Eigen::Vector3d p_W;
    Descriptor descriptor;
  };
  std::vector<Point> points;

  // `kinds`: so many different looks, as of tiles; 0: each point has its own.
  Room(int count, int kinds) {
    CounterRng rng(11, 0, 0);
    for (int i = 0; i < count; ++i) {
      const double along = rng.Uniform(-3, 3);
      const double up = rng.Uniform(0, 2.2);
      const double wall = 3.0;
      Point point;
      switch (i % 4) {
        case 0:
          point.p_W = {wall, along, up};
          break;
        case 1:
          point.p_W = {-wall, along, up};
          break;
        case 2:
          point.p_W = {along, wall, up};
          break;
        default:
          point.p_W = {along, -wall, up};
      }
      for (uint64_t& word : point.descriptor) word = rng.NextU64();
      if (kinds > 0 && i >= kinds) {
        point.descriptor = points[static_cast<size_t>(i % kinds)].descriptor;
      }
      points.push_back(point);
    }
  }
};

Calibration RobotCalibration() {
  Calibration c;
  c.camera.kind = CameraKind::kRgbd;
  c.camera.width = 640;
  c.camera.height = 480;
  c.camera.left = {385, 385, 320, 240, {}};
  // Optical frame looking along the body's x, 25 cm above the floor.
  Eigen::Matrix3d R_BC;
  R_BC << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  c.camera.T_BC = SE3(Eigen::Quaterniond(R_BC), {0.1, 0, 0.25});
  return c;
}

// Turns on a small circle, so that all walls come into view; starts at the identity.
SE3 TruePose(double t) {
  const double angle = 0.5 * t;
  const double radius = 0.8;
  return SE3(ExpSO3({0, 0, angle}), {radius * std::sin(angle), radius * (1 - std::cos(angle)), 0});
}

class World {
 public:
  explicit World(int num_points = 3000, int kinds = 0) : room_(num_points, kinds) {
    geometry_ = *MakeCameraGeometry(RobotCalibration());
  }
  const CameraGeometry& geometry() const { return geometry_; }

  FeatureFrame See(const SE3& T_WB, int index, bool blind) const {
    FeatureFrame frame;
    if (blind) return frame;
    CounterRng rng(12, 1, index);
    const RectifiedCamera& camera = geometry_.rectified;
    const SE3 T_CW = (T_WB * camera.T_BC).inverse();
    for (const Room::Point& point : room_.points) {
      const Eigen::Vector3d p_C = T_CW * point.p_W;
      if (p_C.z() < 0.3) continue;
      const Eigen::Vector2d uv = camera.Project(p_C);
      if (!camera.InImage(uv) || rng.Uniform() < 0.15) continue;  // not every corner is found again
      Feature f;
      f.u = static_cast<float>(uv.x() + 0.4 * rng.Normal());
      f.v = static_cast<float>(uv.y() + 0.4 * rng.Normal());
      f.depth = static_cast<float>(p_C.z() + 0.003 * p_C.z() * p_C.z() * rng.Normal());
      f.u_right = static_cast<float>(f.u - camera.bf() / f.depth);
      Descriptor d = point.descriptor;
      for (int k = 0; k < 20; ++k) d[rng.Below(4)] ^= uint64_t{1} << rng.Below(64);
      frame.features.push_back(f);
      frame.descriptors.push_back(d);
      if (frame.features.size() >= 800) break;
    }
    frame.num_detected = static_cast<int>(frame.features.size());
    return frame;
  }

 private:
  Room room_;
  CameraGeometry geometry_;
};

struct Recording {
  std::vector<FramePose> poses;
  std::vector<FrameDetail> details;
  std::vector<double> errors_m;  // position, per image
  std::vector<Keyframe> keyframes;
  DrConstantFault dr_fault;  // at the end
};

// Drives for `images` images, blind in [blind_from, blind_to). dr_scale: wheel scale error; 0 = no
// DR.
// seen_when_blind: features that are left while blind. before_camera: changes what image i shows.
Recording Drive(const FrontendConfig& config, int images, int blind_from, int blind_to,
                double dr_scale, double dr_turn_scale = 1, size_t seen_when_blind = 0,
                const std::function<void(int, FeatureFrame*)>& before_camera = nullptr) {
  const World world;
  Tracker tracker = *Tracker::Create(config, world.geometry());
  MapUpdate empty;
  empty.snapshot = true;
  EXPECT_TRUE(tracker.Push(empty));
  Recording run;
  SE3 T_OB;
  for (int i = 0; i < images; ++i) {
    const SE3 T_WB = TruePose(i * kFrameUs * 1e-6);
    if (dr_scale > 0) {
      if (i > 0) {
        const SE3 step = TruePose((i - 1) * kFrameUs * 1e-6).inverse() * T_WB;
        T_OB = T_OB *
               SE3(ExpSO3(dr_turn_scale * LogSO3(step.rotation())), dr_scale * step.translation());
      }
      DrState s;
      s.utime = {i * kFrameUs};
      s.seq = i + 1;
      s.T_OB = T_OB;
      EXPECT_TRUE(tracker.Push(s));
    }
    const bool blind = i >= blind_from && i < blind_to;
    FeatureFrame seen = world.See(T_WB, i, blind && seen_when_blind == 0);
    if (blind) {
      seen.features.resize(seen_when_blind);
      seen.descriptors.resize(seen_when_blind);
      seen.num_detected = static_cast<int>(seen_when_blind);
    }
    if (before_camera) before_camera(i, &seen);
    TrackerOutput out = tracker.Track({i * kFrameUs}, i + 1, seen);
    run.errors_m.push_back((out.pose.T_WB.translation() - T_WB.translation()).norm());
    run.poses.push_back(out.pose);
    run.details.push_back(out.detail);
    if (out.keyframe) run.keyframes.push_back(*out.keyframe);
  }
  run.dr_fault = tracker.dr_fault();
  return run;
}

Recording Drive(Variant variant, int images, int blind_from, int blind_to, double dr_scale,
                double dr_turn_scale = 1) {
  FrontendConfig config;
  config.variant = variant;
  return Drive(config, images, blind_from, blind_to, dr_scale, dr_turn_scale);
}

TEST(Tracker, FollowsThePathByVisionAlone) {
  const Recording run = Drive(Variant::kNone, 300, 0, 0, 0);
  for (size_t i = 0; i < run.poses.size(); ++i) {
    EXPECT_EQ(run.poses[i].status, TrackingStatus::kTracking) << i;
    EXPECT_LT(run.errors_m[i], 0.03) << i;
  }
  EXPECT_GT(run.keyframes.size(), 5u);
}

TEST(Tracker, VisionOnlyLosesThePoseInTheDarkAndFindsItAgain) {
  const Recording run = Drive(Variant::kNone, 300, 100, 160, 0);
  EXPECT_EQ(run.poses[150].status, TrackingStatus::kLost);
  // Two seconds turn the robot by 60 degrees: the old view is gone, and only a return would help.
  for (const FramePose& pose : run.poses) EXPECT_TRUE(pose.T_WB.IsFinite());
}

TEST(Tracker, DeadReckoningCarriesThePoseThroughTheDark) {
  const Recording run = Drive(Variant::kFull, 300, 100, 160, 1.02);
  EXPECT_EQ(run.poses[150].status, TrackingStatus::kDrOnly);
  EXPECT_EQ(run.poses[150].alpha, DrWeightConfig{}.alpha_max);
  for (size_t i = 0; i < run.poses.size(); ++i) EXPECT_LT(run.errors_m[i], 0.06) << i;
  EXPECT_EQ(run.poses.back().status, TrackingStatus::kTracking);
}

// This source of dead reckoning says nothing of its noise, so that its nominal noise is the bound:
// alpha below 1 stands, alpha above 1 has no effect (docs/method.md, section 3.3).
TEST(Tracker, ReportsThePriorByTheLawAndAfterItsBound) {
  const Recording run = Drive(Variant::kFull, 160, 100, 160, 1.0);
  for (size_t i = 1; i < run.details.size(); ++i) {
    const FrameDetail& prior = run.details[i];
    EXPECT_EQ(prior.utime, run.poses[i].utime);
    EXPECT_EQ(prior.seq, run.poses[i].seq);
    EXPECT_EQ(prior.q, run.poses[i].q) << i;
    EXPECT_LE(prior.q_close, prior.q) << i;
    EXPECT_EQ(prior.alpha_rotation, run.poses[i].alpha) << i;
    EXPECT_NEAR(prior.bounded_rotation, std::min(prior.alpha_rotation, 1.0), 1e-6) << i;
    EXPECT_NEAR(prior.bounded_translation, std::min(prior.alpha_translation, 1.0), 1e-6) << i;
  }
  EXPECT_LT(run.details[50].alpha_rotation, 1);
  EXPECT_GT(run.details[50].alpha_rotation, 0);
  EXPECT_EQ(run.details[150].alpha_translation, DrWeightConfig{}.alpha_max);
  for (const FrameDetail& prior : Drive(Variant::kDa, 20, 0, 0, 1.0).details) {
    EXPECT_EQ(prior.alpha_rotation, 0);
    EXPECT_EQ(prior.bounded_rotation, 0);
  }
}

// Equation 6 of Du, Peng, Vela, "Good Weights", arXiv 2509.22910, has no least number of matches.
TEST(Tracker, ThePapersPoseTakesAnyNumberOfMatches) {
  FrontendConfig paper;
  paper.dr_weight.method = Method::kPaper;
  const Recording run = Drive(paper, 300, 100, 110, 1.0, 1, 5);
  for (int i = 101; i < 110; ++i) {
    EXPECT_EQ(run.poses[i].status, TrackingStatus::kDegraded) << i;
    EXPECT_GT(run.poses[i].num_inliers, 0) << i;
    EXPECT_LE(run.poses[i].num_inliers, 5) << i;
    EXPECT_GT(run.poses[i].dr_share, 0.5) << i;
  }
  for (size_t i = 0; i < run.poses.size(); ++i) EXPECT_LT(run.errors_m[i], 0.03) << i;
  const Recording ours = Drive(FrontendConfig(), 300, 100, 110, 1.0, 1, 5);
  EXPECT_EQ(ours.poses[105].status, TrackingStatus::kDrOnly);
}

TEST(Tracker, ABudgetOfMatchesIsKeptAndTheMapIsNotMadeTwice) {
  FrontendConfig config;
  config.variant = Variant::kNone;
  const Recording all = Drive(config, 300, 0, 0, 0);
  config.matching_budget = 100;
  for (const Matching matching : {Matching::kGood, Matching::kRandom}) {
    config.matching = matching;
    const Recording run = Drive(config, 300, 0, 0, 0);
    SCOPED_TRACE(matching == Matching::kGood ? "good" : "random");
    for (size_t i = 0; i < run.poses.size(); ++i) {
      EXPECT_EQ(run.poses[i].status, TrackingStatus::kTracking) << i;
      EXPECT_LE(run.poses[i].num_inliers, 100) << i;
      EXPECT_LT(run.errors_m[i], 0.06) << i;
    }
    const auto landmarks_made = [](const Recording& r) {
      int made = 0;
      for (const Keyframe& k : r.keyframes) {
        for (const LandmarkId id : k.landmarks) made += id.valid() && id.creator() == k.id;
      }
      return made;
    };
    // Good ones are near, and leave the view sooner.
    EXPECT_LT(run.keyframes.size(), 2.5 * static_cast<double>(all.keyframes.size()));
    EXPECT_LT(landmarks_made(run), 1.3 * landmarks_made(all));
  }
}

// What is mapped after the dark is no surer of where the map begins than dead reckoning was.
TEST(Tracker, CovarianceGrowsWhileBlindAndStaysOnNewGround) {
  const Recording run = Drive(Variant::kFull, 300, 100, 160, 1.0);
  double last = 0;
  for (int i = 101; i < 160; ++i) {
    const double trace = run.poses[i].cov_T_WB.diagonal().head<3>().sum();
    EXPECT_GT(trace, last);
    last = trace;
  }
  const auto trace = [&](size_t i) { return run.poses[i].cov_T_WB.diagonal().head<3>().sum(); };
  EXPECT_EQ(run.poses[299].status, TrackingStatus::kTracking);
  EXPECT_GT(trace(299), 0.5 * last);
  EXPECT_LT(trace(99), 0.1 * last);
}

// Poses a second apart share their drift: the motion between them is known better than two
// independent poses would say.
TEST(Tracker, TellsTheCovarianceOfItsMotion) {
  const Recording run = Drive(Variant::kFull, 200, 100, 160, 1.0);
  EXPECT_EQ(run.poses[20].motion_us, 0);
  for (size_t i = 32; i < run.poses.size(); ++i) {
    const FramePose& b = run.poses[i];
    ASSERT_EQ(b.motion_us, 30 * kFrameUs) << i;
    EXPECT_GT(b.cov_motion.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), 0) << i;
    const FramePose& a = run.poses[i - 30];
    const Matrix6d adj = (b.T_WB.inverse() * a.T_WB).Adjoint();
    const Matrix6d independent = b.cov_T_WB + adj * a.cov_T_WB * adj.transpose();
    EXPECT_LE(b.cov_motion.trace(), independent.trace() * (1 + 1e-9)) << i;
  }
}

TEST(Tracker, BlindPoseIsExactlyTheDeadReckoning) {
  const Recording run = Drive(Variant::kFull, 200, 100, 160, 1.02);
  const SE3 vision = run.poses[99].T_WB.inverse() * run.poses[159].T_WB;
  SE3 dr;
  for (int i = 100; i <= 159; ++i) {
    const SE3 step = TruePose((i - 1) * kFrameUs * 1e-6).inverse() * TruePose(i * kFrameUs * 1e-6);
    dr = dr * SE3(step.rotation(), 1.02 * step.translation());
  }
  EXPECT_LT((vision.inverse() * dr).Log().norm(), 1e-9);
}

TEST(Tracker, HealthyVisionIgnoresBadDeadReckoning) {
  const Recording none = Drive(Variant::kNone, 200, 0, 0, 0);
  const Recording full = Drive(Variant::kFull, 200, 0, 0, 1.05);
  EXPECT_LT(full.errors_m.back(), none.errors_m.back() + 0.005);
}

// Wrong units, signs and stuck headings: healthy vision is not pulled, and says who is wrong.
TEST(Tracker, DeadReckoningThatContradictsHealthyVisionIsNamedAndNotUsed) {
  // Full health (Q of 0.9 and more) only comes when the circle has been mapped once.
  constexpr int kImages = 450;
  const Recording none = Drive(Variant::kNone, kImages, 0, 0, 0);
  // The heading stands.
  const Recording full = Drive(Variant::kFull, kImages, 0, 0, 1, 0);
  // What was mapped in the seconds before it is noticed stays bent here: there is no back-end.
  EXPECT_LT(full.errors_m.back(), none.errors_m.back() + 0.05);
  EXPECT_EQ(full.poses.back().reason, TrackingReason::kDrContradictsVision);
  EXPECT_EQ(full.poses.back().status, TrackingStatus::kDegraded);
  EXPECT_FALSE(full.keyframes.back().dr) << "no edge of it goes into the map";
  for (size_t i = kImages - 60; i < full.poses.size(); ++i) {
    EXPECT_EQ(full.poses[i].reason, TrackingReason::kDrContradictsVision) << i;
  }
  const Recording sound = Drive(Variant::kFull, kImages, 0, 0, 1);
  for (const FramePose& pose : sound.poses) EXPECT_EQ(pose.reason, TrackingReason::kNone);
  EXPECT_TRUE(sound.dr_fault.empty());
}

// Two seconds of dark after ten of light, in which vision has measured the constant.
TEST(Tracker, AConstantByWhichDeadReckoningIsWrongIsTakenOutOfIt) {
  constexpr int kImages = 420, kDark = 330, kLight = 390;
  const Recording sound = Drive(Variant::kFull, kImages, kDark, kLight, 1);
  for (const double way : {2.0, 0.5, 0.001, 10.0}) {
    const Recording full = Drive(Variant::kFull, kImages, kDark, kLight, way);
    ASSERT_TRUE(full.dr_fault.way_factor) << way;
    EXPECT_NEAR(*full.dr_fault.way_factor * way, 1, 0.05);
    EXPECT_FALSE(full.dr_fault.turn_factor);
    // The robot drives a metre in the dark.
    EXPECT_LT(full.errors_m[kLight - 1], sound.errors_m[kLight - 1] + 0.1) << way;
    EXPECT_EQ(full.poses.back().status, TrackingStatus::kDegraded);
    EXPECT_EQ(full.poses.back().reason, TrackingReason::kNone);
    EXPECT_TRUE(full.keyframes.back().dr);
  }
  const Recording turned = Drive(Variant::kFull, kImages, kDark, kLight, 1, -1);
  ASSERT_TRUE(turned.dr_fault.turn_factor);
  EXPECT_NEAR(*turned.dr_fault.turn_factor, -1, 0.05);
  EXPECT_LT(turned.errors_m[kLight - 1], sound.errors_m[kLight - 1] + 0.15);
}

// Wheels that are reset, once. Where things look alike, a few of them fit to the wrong prediction
// and agree with it; the many that fit to vision's own motion decide.
TEST(Tracker, AJumpOfDeadReckoningIsNotFollowedWhereThingsLookAlike) {
  constexpr int kImages = 200, kJump = 120;
  struct Jump {
    double way, turn;
  };
  FrontendConfig config;
  config.variant = Variant::kFull;
  const World world(3000, 14);
  for (const auto& [way, turn] : {Jump{0, 0}, Jump{0.08, 0}, Jump{0.08, 0.1}, Jump{5, 1}}) {
    Tracker tracker = *Tracker::Create(config, world.geometry());
    MapUpdate empty;
    empty.snapshot = true;
    ASSERT_TRUE(tracker.Push(empty));
    double error_m = 0;
    for (int i = 0; i < kImages; ++i) {
      DrState s;
      s.utime = {i * kFrameUs};
      s.seq = i + 1;
      s.T_OB = TruePose(i * kFrameUs * 1e-6);
      const SE3 T_WB = s.T_OB;
      if (i >= kJump) s.T_OB = SE3(ExpSO3({0, 0, turn}), {0, way, 0}) * s.T_OB;
      ASSERT_TRUE(tracker.Push(s));
      const TrackerOutput out = tracker.Track(s.utime, s.seq, world.See(T_WB, i, false));
      error_m = std::max(error_m, (out.pose.T_WB.translation() - T_WB.translation()).norm());
    }
    EXPECT_LT(error_m, 0.03) << way << " " << turn;
  }
}

// Somebody at one metre, whose left edge is at the image's, and whose right edge is at `right` (m,
// from the optical axis): 400 points that hide what is behind.
void PutPerson(double right, int index, FeatureFrame* frame) {
  const RectifiedCamera camera = MakeCameraGeometry(RobotCalibration())->rectified;
  const double edge = camera.Project({right, 0, 1}).x();
  FeatureFrame out;
  for (size_t i = 0; i < frame->features.size(); ++i) {
    if (frame->features[i].u < edge) continue;
    out.features.push_back(frame->features[i]);
    out.descriptors.push_back(frame->descriptors[i]);
  }
  CounterRng cloth(13, 0, 0), noise(13, 1, static_cast<uint64_t>(index));
  for (int i = 0; i < 400; ++i) {
    const Eigen::Vector3d p(right - cloth.Uniform(0, 1.3), cloth.Uniform(-0.6, 0.6), 1);
    Descriptor d;
    for (uint64_t& word : d) word = cloth.NextU64();
    const Eigen::Vector2d uv = camera.Project(p);
    if (!camera.InImage(uv)) continue;
    Feature f;
    f.u = static_cast<float>(uv.x() + 0.4 * noise.Normal());
    f.v = static_cast<float>(uv.y() + 0.4 * noise.Normal());
    f.depth = static_cast<float>(1 + 0.003 * noise.Normal());
    f.u_right = static_cast<float>(f.u - camera.bf() / f.depth);
    out.features.push_back(f);
    out.descriptors.push_back(d);
  }
  out.num_detected = static_cast<int>(out.features.size());
  *frame = out;
}

// Who walks slower than here (1.3 m in 3 s) is followed for a part of a second, or by 2 cm.
TEST(Tracker, APersonWhoWalksByDoesNotCarryThePose) {
  constexpr int kCome = 100, kGo = 300;  // images
  FrontendConfig config;
  config.variant = Variant::kFull;
  const Recording without = Drive(config, 400, 0, 0, 1);
  for (const int walk : {10, 15, 30, 45}) {
    const auto walks_by = [&](int i, FeatureFrame* seen) {
      if (i < kCome || i >= kGo) return;
      const double way = 1.3 * std::min(1.0, static_cast<double>(i - kCome) / walk);
      PutPerson(-0.8 + way, i, seen);
    };
    const Recording with = Drive(config, 400, 0, 0, 1, 1, 0, walks_by);
    for (size_t i = 0; i < with.poses.size(); ++i) {
      EXPECT_LT(with.errors_m[i], without.errors_m[i] + 0.05) << walk << " " << i;
    }
    for (size_t i = kGo - 30; i < kGo; ++i) {
      EXPECT_NE(with.poses[i].status, TrackingStatus::kTracking) << walk << " " << i;
    }
  }
}

// A clock that is set back costs a few images, not the map.
TEST(Tracker, GoesOnInTheSameMapWhenTheClockIsSetBack) {
  const World world;
  for (const bool with_dr : {false, true}) {
    Tracker tracker = *Tracker::Create({}, world.geometry());
    MapUpdate empty;
    empty.snapshot = true;
    EXPECT_TRUE(tracker.Push(empty));
    constexpr int kSet = 100;
    int refused = 0;
    for (int i = 0; i < 200; ++i) {
      const SE3 T_WB = TruePose(i * kFrameUs * 1e-6);
      const Utime utime{20'000'000 + i * kFrameUs - (i >= kSet ? 10'000'000 : 0)};
      DrState s;
      s.utime = utime;
      s.seq = i + 1;
      s.reset_counter = i >= kSet ? 1 : 0;
      s.T_OB = T_WB;
      if (with_dr) {
        EXPECT_TRUE(tracker.Push(s));
      }
      const FramePose pose = tracker.Track(utime, i + 1, world.See(T_WB, i, false)).pose;
      if (pose.reason == TrackingReason::kTimeReversed) {
        ++refused;
        EXPECT_LT(i, kSet + 3);
      } else if (i >= kSet + 6) {
        EXPECT_EQ(pose.status, TrackingStatus::kTracking) << i;
        EXPECT_LT((pose.T_WB.translation() - T_WB.translation()).norm(), 0.03) << i;
      }
    }
    EXPECT_EQ(refused, 2);
  }
}

PlaceMatch Answer(const PlaceQuery& query, const SE3& T_WC) {
  PlaceMatch match;
  match.utime = query.utime;
  match.query_seq = query.seq;
  match.found = true;
  match.T_WC = T_WC;
  match.cov_T_WC = Matrix6d::Identity() * 1e-4;
  match.num_sights = 100;
  match.map_revision = 1;
  match.keyframe = {1};
  return match;
}

// The map that a drive has made, as its back-end would send it: the landmarks where the keyframes
// placed them.
MapUpdate Saved(const World& world, const std::vector<Keyframe>& keyframes) {
  MapUpdate map;
  map.snapshot = true;
  map.revision = 1;
  std::map<LandmarkId, LandmarkUpdate> landmarks;
  for (const Keyframe& k : keyframes) {
    map.newest_keyframe = k.id;
    map.keyframes.push_back({k.id, k.utime, k.T_WC});
    for (size_t i = 0; i < k.features.size(); ++i) {
      if (!k.landmarks[i].valid()) continue;
      LandmarkUpdate& l = landmarks[k.landmarks[i]];
      l.observations.push_back({k.id, static_cast<int32_t>(i)});
      if (l.id.valid()) continue;
      const Feature& f = k.features[i];
      const Eigen::Vector3d p_C = world.geometry().rectified.Unproject(f.u, f.v, f.depth);
      l.id = k.landmarks[i];
      l.p_W = k.T_WC * p_C;
      l.normal_W = k.T_WC.rotation() * p_C.normalized();
      l.max_distance = static_cast<float>(p_C.norm());  // all features are of level 0
      l.min_distance = l.max_distance / 3.6F;
      l.descriptor = k.descriptors[i];
    }
  }
  for (const auto& [id, landmark] : landmarks) map.landmarks.push_back(landmark);
  return map;
}

bool ClaimsAPlace(const FramePose& pose) {
  return pose.cov_T_WB.diagonal().head<3>().sum() < 1.0;
}

// A start in the map of a first round. The views near the origin of W are exactly those that the
// robot sees now, but nobody has told it that it is there: another room may look the same.
class StartInASavedMap : public testing::Test {
 protected:
  StartInASavedMap() : map_(Saved(world_, Drive(Variant::kFull, 400, 0, 0, 1.0).keyframes)) {}

  TrackerOutput See(Tracker& tracker, int i) {
    if (has_dr_) {
      DrState state;
      state.utime = {i * kFrameUs};
      state.seq = i + 1;
      state.T_OB = TruePose(i * kFrameUs * 1e-6);
      EXPECT_TRUE(tracker.Push(state));
    }
    return tracker.Track({i * kFrameUs}, i + 1,
                         world_.See(TruePose(i * kFrameUs * 1e-6), 1000 + i, false));
  }

  static Tracker Make(const World& world, Variant variant) {
    FrontendConfig config;
    config.variant = variant;
    return *Tracker::Create(config, world.geometry());
  }

  const World world_;
  const MapUpdate map_;
  bool has_dr_ = true;
};

TEST_F(StartInASavedMap, ClaimsNothingUntilThreeAnswersAgree) {
  Tracker tracker = Make(world_, Variant::kFull);
  // It is not known either whether there is a map.
  EXPECT_FALSE(ClaimsAPlace(See(tracker, 0).pose));
  EXPECT_TRUE(tracker.Push(map_));
  std::vector<PlaceQuery> asked;
  int i = 1;
  for (; asked.size() < 3; ++i) {
    ASSERT_LT(i, 60);
    const TrackerOutput out = See(tracker, i);
    EXPECT_FALSE(ClaimsAPlace(out.pose)) << i;
    EXPECT_EQ(out.pose.status, TrackingStatus::kRecovering);
    EXPECT_EQ(out.pose.reason, TrackingReason::kPlaceUnknown);
    EXPECT_FALSE(out.keyframe) << i;
    if (out.query) asked.push_back(*out.query);
  }
  for (const PlaceQuery& query : asked) {
    tracker.Push(Answer(query, TruePose(query.utime.seconds()) * world_.geometry().rectified.T_BC));
  }
  for (; i < 60; ++i) {
    const TrackerOutput out = See(tracker, i);
    EXPECT_TRUE(ClaimsAPlace(out.pose)) << i;
    EXPECT_GT(out.pose.num_inliers, 100) << i;
    const SE3 error = TruePose(i * kFrameUs * 1e-6).inverse() * out.pose.T_WB;
    EXPECT_LT(error.translation().norm(), 0.05) << i;
    EXPECT_EQ(out.pose.reason, TrackingReason::kNone) << i;
  }
}

// Three answers that agree, but the image does not look like that.
TEST_F(StartInASavedMap, AConfirmedPlaceThatIsNotSeenIsNotClaimed) {
  Tracker tracker = Make(world_, Variant::kFull);
  EXPECT_TRUE(tracker.Push(map_));
  const SE3 wrong(ExpSO3({0, 0, 2.0}), {0.5, 0.5, 0});
  for (int i = 0; i < 60; ++i) {
    const TrackerOutput out = See(tracker, i);
    EXPECT_FALSE(ClaimsAPlace(out.pose)) << i;
    if (!out.query) continue;
    tracker.Push(Answer(*out.query, wrong * TruePose(out.query->utime.seconds()) *
                                        world_.geometry().rectified.T_BC));
  }
}

TEST_F(StartInASavedMap, WithoutDeadReckoningSeveralImagesHaveToAgree) {
  has_dr_ = false;
  Tracker tracker = Make(world_, Variant::kNone);
  EXPECT_TRUE(tracker.Push(map_));
  for (int i = 0; i < 30; ++i) {
    EXPECT_EQ(ClaimsAPlace(See(tracker, i).pose), i + 1 >= Recovery::kContradictingImages) << i;
  }
}

TEST_F(StartInASavedMap, APoseOfTheDrProcessIsAPlaceToStartFrom) {
  Pose pose;
  pose.has_map = true;
  pose.cov_T_WB = Matrix6d::Identity() * 1e-4;
  Tracker tracker = Make(world_, Variant::kFull);
  EXPECT_TRUE(tracker.Push(map_));
  tracker.Push(pose);
  EXPECT_TRUE(ClaimsAPlace(See(tracker, 0).pose));
  EXPECT_GT(See(tracker, 1).pose.num_inliers, 100);

  // ... but not one that does not know its place itself.
  pose.cov_T_WB = CovarianceOfNoIdea();
  Tracker other = Make(world_, Variant::kFull);
  EXPECT_TRUE(other.Push(map_));
  other.Push(pose);
  EXPECT_FALSE(ClaimsAPlace(See(other, 0).pose));
  EXPECT_EQ(See(other, 1).pose.reason, TrackingReason::kPlaceUnknown);
}

// After one round of the circle the robot is set down on its other side; dead reckoning does not
// notice. A back-end that knows the place answers each question before the next image.
TEST(Tracker, CarriedAwayItClaimsNothingAsksAndFollowsTheAnswers) {
  const World world;
  FrontendConfig config;
  config.variant = Variant::kFull;
  Tracker tracker = *Tracker::Create(config, world.geometry());
  MapUpdate empty;
  empty.snapshot = true;
  EXPECT_TRUE(tracker.Push(empty));
  constexpr int kCarried = 400;
  const auto true_pose = [](int i) {
    return TruePose((i < kCarried ? i : i + 189) * kFrameUs * 1e-6);
  };
  SE3 T_OB;
  std::optional<PlaceMatch> answer;
  int found_after = -1;
  std::optional<Keyframe> first_there;
  for (int i = 0; i < kCarried + 90; ++i) {
    const SE3 T_WB = true_pose(i);
    if (i > 0 && i != kCarried) T_OB = T_OB * (true_pose(i - 1).inverse() * T_WB);
    DrState state;
    state.utime = {i * kFrameUs};
    state.seq = i + 1;
    state.T_OB = T_OB;
    EXPECT_TRUE(tracker.Push(state));
    if (answer) tracker.Push(*answer);
    const TrackerOutput out = tracker.Track({i * kFrameUs}, i + 1, world.See(T_WB, i, false));
    answer.reset();
    if (out.query) {
      EXPECT_GE(i, kCarried);
      answer = Answer(*out.query, T_WB * world.geometry().rectified.T_BC);
    }
    if (i < kCarried) continue;
    if ((out.pose.T_WB.translation() - T_WB.translation()).norm() > 0.5) {
      EXPECT_GT(out.pose.cov_T_WB.diagonal().head<3>().sum(), 1.0) << i;
      EXPECT_FALSE(out.keyframe) << i;
    } else if (found_after < 0) {
      found_after = i - kCarried;
    }
    if (out.keyframe && !first_there) first_there = out.keyframe;
  }
  EXPECT_GT(found_after, 0);
  EXPECT_LT(found_after, 30);  // three answers, one every 0.2 s
  ASSERT_TRUE(first_there);
  EXPECT_FALSE(first_there->dr);  // it does not lead from where the robot was lifted
}

// What the back-end makes of keyframes of a piece when it joins it to the map: all of it moves.
MapUpdate Joined(const std::vector<Keyframe>& piece, const SE3& T_MapPiece,
                 const RectifiedCamera& camera) {
  MapUpdate update;
  update.revision = 1;
  update.newest_keyframe = piece.back().id;
  for (const Keyframe& keyframe : piece) {
    const SE3 T_WC = T_MapPiece * keyframe.T_WC;
    update.keyframes.push_back({keyframe.id, keyframe.utime, T_WC});
    for (size_t i = 0; i < keyframe.features.size(); ++i) {
      const LandmarkId id = keyframe.landmarks[i];
      if (!id.valid() || id.creator() != keyframe.id) continue;
      const Feature& f = keyframe.features[i];
      LandmarkUpdate landmark;
      landmark.id = id;
      landmark.p_W = T_WC * camera.Unproject(f.u, f.v, f.depth);
      landmark.normal_W = (landmark.p_W - T_WC.translation()).normalized();
      landmark.max_distance = 2 * f.depth;
      landmark.min_distance = f.depth / 4;
      landmark.descriptor = keyframe.descriptors[i];
      landmark.observations = {{keyframe.id, static_cast<int32_t>(i)}};
      update.landmarks.push_back(landmark);
    }
  }
  return update;
}

// After two seconds the robot is set down where it has not been yet, and nobody knows the place. It
// maps on there in a piece of its own, claims nothing, and goes on in the map when the piece is
// joined to it.
TEST(Tracker, CarriedToUnmappedGroundItMapsOnInAPieceOfItsOwn) {
  const World world;
  const RectifiedCamera& camera = world.geometry().rectified;
  FrontendConfig config;
  config.variant = Variant::kFull;
  Tracker tracker = *Tracker::Create(config, world.geometry());
  MapUpdate empty;
  empty.snapshot = true;
  EXPECT_TRUE(tracker.Push(empty));
  constexpr int kCarried = 60, kJoined = 210, kImages = 240;
  const auto true_pose = [](int i) {
    return TruePose((i < kCarried ? i : i + 189) * kFrameUs * 1e-6);
  };
  SE3 T_OB, T_WO;  // T_WO: by which the piece lies wrong
  std::vector<Keyframe> piece;
  int begun = -1;
  for (int i = 0; i < kImages; ++i) {
    const SE3 T_WB = true_pose(i);
    if (i > 0 && i != kCarried) T_OB = T_OB * (true_pose(i - 1).inverse() * T_WB);
    if (i == kCarried) T_WO = T_WB * T_OB.inverse();
    DrState state;
    state.utime = {i * kFrameUs};
    state.seq = i + 1;
    state.T_OB = T_OB;
    EXPECT_TRUE(tracker.Push(state));
    if (i == kJoined) {
      EXPECT_TRUE(tracker.Push(Joined(piece, T_WO, camera)));
    }
    const TrackerOutput out = tracker.Track({i * kFrameUs}, i + 1, world.See(T_WB, i, false));
    const double claimed_m = std::sqrt(out.pose.cov_T_WB.diagonal().head<3>().maxCoeff());
    if (i >= kCarried && i < kJoined) {
      EXPECT_EQ(out.pose.status, TrackingStatus::kRecovering) << i;
      EXPECT_GT(claimed_m, 5) << i;
      if (out.keyframe) {
        if (piece.empty()) begun = i;
        piece.push_back(*out.keyframe);
      }
      // In its own frame, which is that of dead reckoning, it knows where it is.
      if (!piece.empty()) {
        EXPECT_LT((out.pose.T_WB.translation() - T_OB.translation()).norm(), 0.1) << i;
      }
    } else if (i >= kJoined) {
      EXPECT_LT((out.pose.T_WB.translation() - T_WB.translation()).norm(), 0.1) << i;
      EXPECT_LT(claimed_m, 0.2) << i;
      EXPECT_EQ(out.pose.status == TrackingStatus::kRecovering, i == kJoined) << i;
      EXPECT_FALSE(out.keyframe && out.keyframe->piece.valid()) << i;
    }
  }
  ASSERT_GT(piece.size(), 2u);
  EXPECT_GE(begun - kCarried, 90);  // 3 s
  EXPECT_LT(begun - kCarried, 120);
  EXPECT_EQ(piece[0].piece, piece[0].id);
  EXPECT_FALSE(piece[0].previous.valid());
  EXPECT_EQ(piece[1].piece, piece[0].id);
  EXPECT_EQ(piece[1].previous, piece[0].id);
  EXPECT_TRUE(piece[1].dr);
}

TEST(Tracker, EveryImageGetsAPoseEvenBadOnes) {
  const World world;
  Tracker tracker = *Tracker::Create({}, world.geometry());
  CameraFrame empty;
  empty.utime = {1000};
  EXPECT_EQ(tracker.Push(empty).pose.reason, TrackingReason::kBadImage);
  const uint8_t pixels[16] = {};
  CameraFrame small;
  small.utime = {34000};
  small.left = small.depth = {pixels, 4, 4, 4, PixelFormat::kGray8};
  EXPECT_EQ(tracker.Push(small).pose.reason, TrackingReason::kBadImage);
  small.utime = {33000};
  EXPECT_EQ(tracker.Push(small).pose.reason, TrackingReason::kTimeReversed);
}

TEST(Tracker, WaitsForTheMapBeforeItBeginsOne) {
  const World world;
  Tracker tracker = *Tracker::Create({}, world.geometry());
  const auto out = tracker.Track({0}, 1, world.See(SE3(), 0, false));
  EXPECT_EQ(out.pose.status, TrackingStatus::kInitializing);
  EXPECT_FALSE(out.keyframe);
  MapUpdate taken;
  taken.snapshot = true;
  taken.newest_keyframe = {41};
  EXPECT_TRUE(tracker.Push(taken));
  const auto next = tracker.Track({kFrameUs}, 2, world.See(SE3(), 1, false));
  ASSERT_TRUE(next.keyframe);
  EXPECT_EQ(next.keyframe->id.value, 42);
}

TEST(Tracker, MakesNoKeyframeOfAFrozenMap) {
  const World world;
  Tracker tracker = *Tracker::Create({}, world.geometry());
  MapUpdate frozen;
  frozen.snapshot = frozen.frozen = true;
  EXPECT_TRUE(tracker.Push(frozen));
  EXPECT_FALSE(tracker.Track({0}, 1, world.See(SE3(), 0, false)).keyframe);
  frozen.frozen = false;
  EXPECT_TRUE(tracker.Push(frozen));
  EXPECT_TRUE(tracker.Track({kFrameUs}, 2, world.See(SE3(), 1, false)).keyframe);
}

TEST(Tracker, RefusesAMapUpdateWithAGap) {
  const World world;
  Tracker tracker = *Tracker::Create({}, world.geometry());
  MapUpdate update;
  update.snapshot = true;
  update.revision = 5;
  EXPECT_TRUE(tracker.Push(update));
  update.snapshot = false;
  update.base_revision = 6;
  update.revision = 7;
  EXPECT_FALSE(tracker.Push(update));
  update.base_revision = 5;
  update.revision = 6;
  EXPECT_TRUE(tracker.Push(update));
}

}  // namespace
}  // namespace gw::frontend
