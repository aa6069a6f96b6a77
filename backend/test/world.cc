#include "backend/test/world.h"

#include <algorithm>
#include <cmath>

#include "backend/core/mapper.h"

namespace gw::backend {
namespace {

enum Stream : uint64_t { kPoints = 1, kFeatures, kPose, kDr };

Vector6d Noise(CounterRng& rng, double sigma_m, double sigma_rad) {
  Vector6d out;
  for (int i = 0; i < 6; ++i) out[i] = rng.Normal() * (i < 3 ? sigma_m : sigma_rad);
  return out;
}

}  // namespace

RectifiedCamera TestCamera() {
  RectifiedCamera c;
  c.width = 640;
  c.height = 480;
  c.fx = c.fy = 525;
  c.cx = 319.5;
  c.cy = 239.5;
  c.baseline_m = 0.08;
  c.depth_min_m = 0.3;
  c.depth_max_m = 8;
  Eigen::Matrix3d R_BC;
  R_BC << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  c.T_BC = SE3(Eigen::Quaterniond(R_BC), {0.1, 0.0, 0.6});
  return c;
}

World::World(const WorldOptions& options) : options_(options) {
  for (int i = 0; i < options.num_points; ++i) {
    CounterRng rng(options.seed, kPoints, static_cast<uint64_t>(i));
    Point point;
    const double along = rng.Uniform(-1, 1);
    const double z = rng.Uniform(0, options.height);
    switch (rng.Below(4)) {
      case 0:
        point = {{options.half_x, along * options.half_y, z}, {-1, 0, 0}, 1, {}};
        break;
      case 1:
        point = {{-options.half_x, along * options.half_y, z}, {1, 0, 0}, 1, {}};
        break;
      case 2:
        point = {{along * options.half_x, options.half_y, z}, {0, -1, 0}, 1, {}};
        break;
      default:
        point = {{along * options.half_x, -options.half_y, z}, {0, 1, 0}, 1, {}};
        break;
    }
    // The walls are not flat: a plane would be a special case for estimation.
    point.p_W += point.normal_W * rng.Uniform(0, 0.4);
    point.size = rng.Uniform(4, 14);
    for (uint64_t& word : point.descriptor) word = rng.NextU64();
    points_.push_back(point);
  }
}

SE3 World::TruePose(int k) const {
  const double angle = 2 * std::numbers::pi * k / options_.keyframes_per_lap;
  const double heading = angle + std::numbers::pi / 2;
  const SE3 T_WB(ExpSO3({0, 0, heading}),
                 {options_.radius * std::cos(angle), options_.radius * std::sin(angle), 0});
  return T_WB * TestCamera().T_BC;
}

DrIncrement World::Dr(int k) const {
  const SE3 T_CB = TestCamera().T_BC.inverse();
  CounterRng rng(options_.seed, kDr, static_cast<uint64_t>(k));
  DrIncrement dr;
  dr.utime_begin = UtimeFromSeconds(100 + 0.5 * (k - 1));
  dr.utime_end = UtimeFromSeconds(100 + 0.5 * k);
  dr.T_BaBb = (TruePose(k - 1) * T_CB).inverse() * (TruePose(k) * T_CB) *
              SE3::Exp(Noise(rng, options_.dr_sigma_m, options_.dr_sigma_rad));
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(std::pow(options_.dr_sigma_m, 2)),
      Eigen::Vector3d::Constant(std::pow(options_.dr_sigma_rad, 2));
  dr.cov = variance.asDiagonal();
  return dr;
}

Keyframe World::Make(int k, const Map& map, bool blind) {
  const RectifiedCamera camera = TestCamera();
  Keyframe out;
  out.id = {k + 1};
  out.utime = UtimeFromSeconds(100 + 0.5 * k);
  out.map_revision = map.revision();
  out.previous = map.newest_keyframe();
  const MapKeyframe* previous = map.FindKeyframe(out.previous);
  if (out.previous.value == k && k > 0) out.dr = Dr(k);
  CounterRng pose_rng(options_.seed, kPose, static_cast<uint64_t>(k));
  out.T_WC = TruePose(k);
  if (options_.memory_keyframes > 0 && previous != nullptr) {
    out.T_WC = previous->frame.T_WC * TruePose(k - 1).inverse() * TruePose(k);
  }
  if (k > 0) {
    out.T_WC = out.T_WC * SE3::Exp(Noise(pose_rng, options_.pose_sigma_m, options_.pose_sigma_rad));
  }
  if (blind) {
    out.T_WC = previous->frame.T_WC * camera.T_BC.inverse() * Dr(k).T_BaBb * camera.T_BC;
    shown_[out.id] = {};
    return out;
  }

  const SE3 T_CW = TruePose(k).inverse();
  std::vector<int> shown;
  for (size_t i = 0; i < points_.size() && shown.size() < 800; ++i) {
    const Point& point = points_[i];
    const Eigen::Vector3d p_C = T_CW * point.p_W;
    if (p_C.z() < 0.3) continue;
    const double distance = p_C.norm();
    const Eigen::Vector3d ray_W = (point.p_W - TruePose(k).translation()) / distance;
    if (ray_W.dot(point.normal_W) > -0.3 || !camera.InImage(camera.Project(p_C))) continue;
    CounterRng rng(options_.seed, kFeatures + 16 * static_cast<uint64_t>(k), i);
    const int level = static_cast<int>(
        std::clamp(std::round(std::log(point.size / distance) / std::log(1.2)), 0.0, 7.0));
    const double sigma = options_.pixel_sigma * std::pow(1.2, level);
    const Eigen::Vector2d uv = camera.Project(p_C);
    Feature f;
    f.u = static_cast<float>(uv.x() + sigma * rng.Normal());
    f.v = static_cast<float>(uv.y() + sigma * rng.Normal());
    f.level = static_cast<uint8_t>(level);
    const double disparity = camera.bf() / p_C.z() + sigma * rng.Normal();
    f.u_right = static_cast<float>(f.u - disparity);
    const bool has_depth = rng.Uniform() < options_.depth_share && disparity > 1;
    if (has_depth && camera.bf() / disparity < camera.depth_max_m) {
      f.depth = static_cast<float>(camera.bf() / disparity);
    } else {
      f.u_right = -1;
    }
    Descriptor descriptor = point.descriptor;
    for (int flip = 0; flip < 12; ++flip) {
      const uint32_t bit = rng.Below(256);
      descriptor[bit / 64] ^= uint64_t{1} << (bit % 64);
    }
    LandmarkId landmark;
    const int index = static_cast<int>(out.features.size());
    const auto known = landmark_of_point_.find(static_cast<int>(i));
    LandmarkId resolved =
        known == landmark_of_point_.end() ? LandmarkId{} : map.Resolve(known->second);
    if (options_.memory_keyframes > 0 && resolved.valid()) {
      const auto& observations = map.FindLandmark(resolved)->observations;
      if (observations.back().keyframe.value < out.id.value - options_.memory_keyframes) {
        resolved = {};
      }
    }
    const bool associated = rng.Uniform() < options_.association_share;
    const bool outlier = rng.Uniform() < options_.outlier_share;
    if (resolved.valid() && associated) {
      landmark = resolved;
    } else if (f.has_depth()) {
      landmark = LandmarkId::From(out.id, index);
      if (!resolved.valid()) landmark_of_point_[static_cast<int>(i)] = landmark;
    }
    if (outlier && landmark.valid() && landmark.creator() != out.id && !out.landmarks.empty()) {
      // Swap with an earlier feature's landmark, far away in the image.
      const size_t other = rng.Below(static_cast<uint32_t>(out.landmarks.size()));
      if (out.landmarks[other].valid() && out.landmarks[other].creator() != out.id) {
        std::swap(landmark, out.landmarks[other]);
      }
    }
    if (landmark.valid() && landmark.creator() != out.id) ++out.num_tracked;
    out.features.push_back(f);
    out.descriptors.push_back(descriptor);
    out.landmarks.push_back(landmark);
    shown.push_back(static_cast<int>(i));
  }
  out.q = 1;
  shown_[out.id] = shown;
  return out;
}

World SettledWorld(double radius, uint64_t seed) {
  WorldOptions options;
  options.seed = seed;
  options.radius = radius;
  options.keyframes_per_lap = 40;
  options.pixel_sigma = 0.15;
  options.pose_sigma_m = 0.002;
  options.pose_sigma_rad = 0.0005;
  return World(options);
}

Map DrivenMap(const WorldOptions& options, int keyframes) {
  World world(options);
  Mapper mapper = *Mapper::Create({}, {}, TestCamera());
  for (int k = 0; k < keyframes; ++k) {
    mapper.Insert(world.Make(k, mapper.map()));
    if (const auto job = mapper.BuildJob()) mapper.Apply(SolveLocalBa(*job));
  }
  return mapper.map();
}

double PositionRmse(const World& world, const Map& map) {
  double sum = 0;
  for (const auto& [id, keyframe] : map.keyframes()) {
    const int k = static_cast<int>(id.value) - 1;
    sum += (keyframe.frame.T_WC.translation() - world.TruePose(k).translation()).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(std::max<size_t>(1, map.keyframes().size())));
}

}  // namespace gw::backend
