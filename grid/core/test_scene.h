// Tests: a room of boxes on a floor, seen by a level camera.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "common/camera/camera_model.h"
#include "grid/core/depth_source.h"

namespace gw::grid {

struct SceneBox {
  Eigen::Vector3d min, max;  // m, in the frame of the floor
};

struct Scene {
  std::vector<SceneBox> boxes;
  std::vector<SceneBox> holes;  // pieces of the floor that are not there; only x and y count

  // Distance along the ray (in units of its length) to what it meets first.
  double Meet(const Eigen::Vector3d& origin, const Eigen::Vector3d& ray) const {
    double nearest = std::numeric_limits<double>::infinity();
    if (ray.z() < 0) {
      const double t = -origin.z() / ray.z();
      const Eigen::Vector3d p = origin + t * ray;
      const bool hole = std::any_of(holes.begin(), holes.end(), [&p](const SceneBox& h) {
        return p.x() > h.min.x() && p.x() < h.max.x() && p.y() > h.min.y() && p.y() < h.max.y();
      });
      nearest = hole ? (-1.0 - origin.z()) / ray.z() : t;  // its ground lies 1 m deep
    }
    for (const SceneBox& box : boxes) {
      const Eigen::Array3d a = (box.min - origin).array() / ray.array();
      const Eigen::Array3d b = (box.max - origin).array() / ray.array();
      const double enter = a.min(b).maxCoeff(), leave = a.max(b).minCoeff();
      if (enter > 0 && enter <= leave) nearest = std::min(nearest, enter);
    }
    return nearest;
  }
};

// A D435-like camera, 0.25 m above the floor, looking forward.
inline Calibration SceneCalibration() {
  Calibration calibration;
  CameraCalibration& c = calibration.camera;
  c.kind = CameraKind::kRgbd;
  c.width = 640;
  c.height = 480;
  c.left = {385, 385, 320, 240, {}};
  c.depth_min_m = 0.25;
  c.depth_max_m = 6;
  c.depth_baseline_m = 0.05;
  c.T_BC = SE3(Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), {0.1, 0, 0.25});
  return calibration;
}
// The same with a second eye in place of depth.
inline Calibration StereoCalibration() {
  Calibration calibration = SceneCalibration();
  CameraCalibration& c = calibration.camera;
  c.kind = CameraKind::kStereo;
  c.right = c.left;
  c.T_C0C1 = SE3(Eigen::Quaterniond::Identity(), {0.05, 0, 0});
  return calibration;
}
inline CameraGeometry SceneGeometry() {
  return *MakeCameraGeometry(SceneCalibration());
}

// What the camera of a robot at T_FB measures; nothing beyond 10 m.
inline DepthImage SceneDepth(const Scene& scene, const DepthRays& rays, const SE3& T_FB) {
  DepthImage depth;
  const Eigen::Vector3d origin = T_FB * rays.origin.cast<double>();
  for (const Eigen::Vector3f& ray : rays.ray) {
    const double z = scene.Meet(origin, T_FB.rotation() * ray.cast<double>());
    depth.push_back(z < 10 ? static_cast<float>(z) : 0.0f);
  }
  return depth;
}

inline SE3 OnFloor(double x, double y, double yaw) {
  return SE3(ExpSO3({0, 0, yaw}), {x, y, 0});
}

}  // namespace gw::grid
