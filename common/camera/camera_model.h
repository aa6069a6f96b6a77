// The ideal camera that all estimators use: pinhole, no distortion, a stereo partner displaced
// along +x by `baseline_m` (for RGB-D a virtual one). Made from the calibration; stereo images are
// rectified to it, RGB-D keypoints are undistorted to it.
#pragma once

#include <Eigen/Core>

#include "common/camera/calibration.h"
#include "common/core/result.h"

namespace gw {

struct RectifiedCamera {
  int width = 0, height = 0;                // px
  double fx = 0, fy = 0, cx = 0, cy = 0;    // px
  double baseline_m = 0;                    // > 0
  double disparity_sigma_px = 0;            // of a depth image, px at baseline_m; 0: stereo pair
  double depth_min_m = 0, depth_max_m = 0;  // depths outside are not used
  double readout_s = 0;                     // rolling shutter; 0 = global
  SE3 T_BC;                                 // rectified left camera in the body

  double bf() const { return fx * baseline_m; }  // disparity (px) = bf / depth
  bool has_depth_image() const { return disparity_sigma_px > 0; }

  // Pixel of a point in C. Precondition: p_C.z() > 0.
  Eigen::Vector2d Project(const Eigen::Vector3d& p_C) const {
    const double iz = 1.0 / p_C.z();
    return {fx * p_C.x() * iz + cx, fy * p_C.y() * iz + cy};
  }
  // Point in C of a pixel with depth (m along z).
  Eigen::Vector3d Unproject(double u, double v, double depth_m) const {
    return {(u - cx) / fx * depth_m, (v - cy) / fy * depth_m, depth_m};
  }
  bool InImage(const Eigen::Vector2d& uv) const {
    return uv.x() >= 0 && uv.y() >= 0 && uv.x() < width && uv.y() < height;
  }
};

// Brown-Conrady: ideal normalised coordinates (x/z, y/z) -> distorted ones, and its inverse (fixed
// point with Newton steps; exact to 1e-9 inside the calibrated image, error() when it does not
// converge).
Eigen::Vector2d Distort(const PinholeIntrinsics& camera, const Eigen::Vector2d& normalised);
Result<Eigen::Vector2d> Undistort(const PinholeIntrinsics& camera,
                                  const Eigen::Vector2d& distorted);

// How the images of a stereo pair become those of the RectifiedCamera.
struct StereoRectification {
  bool needed = false;  // false: the pair is already rectified, use the images as they are
  Eigen::Matrix3d R_C0Rect = Eigen::Matrix3d::Identity();  // rectified frame -> left camera
  Eigen::Matrix3d R_C1Rect = Eigen::Matrix3d::Identity();  // rectified frame -> right camera
};

struct CameraGeometry {
  RectifiedCamera rectified;
  StereoRectification rectification;  // stereo only
  Calibration calibration;            // as given
};

// Pixel in the source image of one eye for a pixel of the rectified image.
Eigen::Vector2d RectifiedToSource(const RectifiedCamera& rectified, const PinholeIntrinsics& source,
                                  const Eigen::Matrix3d& R_SourceRect, const Eigen::Vector2d& uv);

// Checks the calibration as a whole (baseline > 0, principal point inside the image, right camera
// to the right of the left, depth_min < depth_max) and derives the geometry. Error: kBadConfig,
// names the field.
Result<CameraGeometry> MakeCameraGeometry(const Calibration& calibration);

}  // namespace gw
