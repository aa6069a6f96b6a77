// For the tests of the tracker: a synthetic room, points with descriptors on four walls, and a
// robot that drives a curve in it, no pixels.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "common/core/random.h"
#include "frontend/core/tracking/tracker.h"

namespace gw::frontend {

inline constexpr int64_t kFrameUs = 33333;

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

inline Calibration RobotCalibration() {
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
inline SE3 TruePose(double t) {
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
  LengthFault length_fault;
};

// Drives for `images` images, blind in [blind_from, blind_to). dr_scale: wheel scale error; 0 = no
// DR.
// seen_when_blind: features that are left while blind. before_camera: changes what image i shows;
// before_dr: what dead reckoning tells then.
inline Recording Drive(const FrontendConfig& config, int images, int blind_from, int blind_to,
                       double dr_scale, double dr_turn_scale = 1, size_t seen_when_blind = 0,
                       const std::function<void(int, FeatureFrame*)>& before_camera = nullptr,
                       const std::function<void(int, DrState*)>& before_dr = nullptr) {
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
      if (before_dr) before_dr(i, &s);
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
  run.length_fault = tracker.length_fault();
  return run;
}

inline Recording Drive(Variant variant, int images, int blind_from, int blind_to, double dr_scale,
                       double dr_turn_scale = 1) {
  FrontendConfig config;
  config.variant = variant;
  return Drive(config, images, blind_from, blind_to, dr_scale, dr_turn_scale);
}

}  // namespace gw::frontend
