#include "common/camera/camera_model.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <string>

namespace gw {
namespace {

Error BadCalibration(const std::string& what) {
  return {ErrorCode::kBadConfig, "calibration.camera." + what};
}

// The image already is what a rectified camera would see: no distortion, no rotation between the
// eyes (1e-6 rad is far below a pixel), right eye displaced along x only.
bool IsRectified(const CameraCalibration& c) {
  const bool same = c.left.fx == c.right.fx && c.left.fy == c.right.fy && c.left.cx == c.right.cx &&
                    c.left.cy == c.right.cy;
  const bool parallel = LogSO3(c.T_C0C1.rotation()).norm() < 1e-6;
  const Eigen::Vector3d& b = c.T_C0C1.translation();
  return same && parallel && std::hypot(b.y(), b.z()) < 1e-6 && !c.left.distorted() &&
         !c.right.distorted();
}

// Rotation of the rectified frame in the left camera (Fusiello, Trucco, Verri 2000): x along the
// baseline, z as close as possible to the mean viewing direction.
Eigen::Matrix3d RectifyingRotation(const SE3& T_C0C1) {
  const Eigen::Vector3d x = T_C0C1.translation().normalized();
  const Eigen::Vector3d z_mean =
      Eigen::Vector3d::UnitZ() + T_C0C1.rotation() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d y = z_mean.cross(x).normalized();
  Eigen::Matrix3d R;
  R << x, y, x.cross(y);
  return R;
}

}  // namespace

Eigen::Vector2d Distort(const PinholeIntrinsics& camera, const Eigen::Vector2d& n) {
  const auto& k = camera.radtan;
  const double x = n.x();
  const double y = n.y();
  const double r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
  return {x * radial + 2.0 * k[2] * x * y + k[3] * (r2 + 2.0 * x * x),
          y * radial + k[2] * (r2 + 2.0 * y * y) + 2.0 * k[3] * x * y};
}

Result<Eigen::Vector2d> Undistort(const PinholeIntrinsics& camera,
                                  const Eigen::Vector2d& distorted) {
  const auto& k = camera.radtan;
  Eigen::Vector2d n = distorted;
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector2d error = Distort(camera, n) - distorted;
    if (error.squaredNorm() < 1e-22) return n;
    const double x = n.x();
    const double y = n.y();
    const double r2 = x * x + y * y;
    const double radial = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
    const double slope = 2.0 * (k[0] + r2 * (2.0 * k[1] + r2 * 3.0 * k[4]));  // d radial / d r2 * 2
    Eigen::Matrix2d J;
    J << radial + slope * x * x + 2.0 * k[2] * y + 6.0 * k[3] * x,
        slope * x * y + 2.0 * k[2] * x + 2.0 * k[3] * y,
        slope * x * y + 2.0 * k[2] * x + 2.0 * k[3] * y,
        radial + slope * y * y + 6.0 * k[2] * y + 2.0 * k[3] * x;
    if (std::abs(J.determinant()) < 1e-9) break;
    n -= J.inverse() * error;
  }
  if (n.allFinite() && (Distort(camera, n) - distorted).squaredNorm() < 1e-18) return n;
  return Error{ErrorCode::kBadData,
               "undistortion does not converge: pixel outside the calibrated image"};
}

Eigen::Vector2d RectifiedToSource(const RectifiedCamera& rectified, const PinholeIntrinsics& source,
                                  const Eigen::Matrix3d& R_SourceRect, const Eigen::Vector2d& uv) {
  const Eigen::Vector3d ray = R_SourceRect * rectified.Unproject(uv.x(), uv.y(), 1.0);
  const Eigen::Vector2d n = Distort(source, {ray.x() / ray.z(), ray.y() / ray.z()});
  return {source.fx * n.x() + source.cx, source.fy * n.y() + source.cy};
}

Result<CameraGeometry> MakeCameraGeometry(const Calibration& calibration) {
  const CameraCalibration& c = calibration.camera;
  CameraGeometry out;
  out.calibration = calibration;
  RectifiedCamera& r = out.rectified;
  if (c.left.cx >= c.width || c.left.cy >= c.height) {
    return BadCalibration(
        "left: principal point lies outside the image; check cx, cy, width, height");
  }
  if (c.depth_min_m >= c.depth_max_m) {
    return BadCalibration("depth_min_m must be smaller than depth_max_m");
  }
  r.width = c.width;
  r.height = c.height;
  r.fx = c.left.fx;
  r.fy = c.left.fy;
  r.cx = c.left.cx;
  r.cy = c.left.cy;
  r.depth_min_m = c.depth_min_m;
  r.depth_max_m = c.depth_max_m;
  r.T_BC = c.T_BC;
  r.readout_s = c.readout_s;
  if (c.kind == CameraKind::kRgbd) {
    r.baseline_m = c.depth_baseline_m;
    r.disparity_sigma_px = c.disparity_sigma_px;
    return out;
  }
  if (c.right.fx <= 0 || c.right.fy <= 0) {
    return BadCalibration("right: missing; a stereo camera needs the intrinsics of both eyes");
  }
  r.baseline_m = c.T_C0C1.translation().norm();
  if (r.baseline_m < 1e-3) {
    return BadCalibration(
        "T_C0C1: baseline below 1 mm; state the right camera's pose in the left's frame");
  }
  if (c.T_C0C1.translation().x() < 0.7 * r.baseline_m) {
    return BadCalibration(
        "T_C0C1: the right camera is not to the right (+x) of the left; are the eyes swapped?");
  }
  if (IsRectified(c)) return out;

  out.rectification.needed = true;
  out.rectification.R_C0Rect = RectifyingRotation(c.T_C0C1);
  out.rectification.R_C1Rect =
      c.T_C0C1.rotation().conjugate().toRotationMatrix() * out.rectification.R_C0Rect;
  r.fx = r.fy = 0.25 * (c.left.fx + c.left.fy + c.right.fx + c.right.fy);
  // Principal point: where the mean of both eyes' image centres falls, so that little is cut off.
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();
  int num_offsets = 0;
  for (const auto& [eye, R_EyeRect] : {std::pair{&c.left, out.rectification.R_C0Rect},
                                       std::pair{&c.right, out.rectification.R_C1Rect}}) {
    const Result<Eigen::Vector2d> n = Undistort(
        *eye, {(0.5 * c.width - eye->cx) / eye->fx, (0.5 * c.height - eye->cy) / eye->fy});
    if (!n) return BadCalibration("radtan: the distortion cannot be inverted at the image centre");
    const Eigen::Vector3d ray = R_EyeRect.transpose() * Eigen::Vector3d(n->x(), n->y(), 1.0);
    offset += Eigen::Vector2d(r.fx * ray.x() / ray.z(), r.fy * ray.y() / ray.z());
    ++num_offsets;
  }
  offset /= num_offsets;
  r.cx = 0.5 * c.width - offset.x();
  r.cy = 0.5 * c.height - offset.y();
  r.T_BC = c.T_BC * SE3(Eigen::Quaterniond(out.rectification.R_C0Rect), Eigen::Vector3d::Zero());
  return out;
}

}  // namespace gw
