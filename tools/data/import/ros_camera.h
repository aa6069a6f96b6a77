// Cameras as sensor_msgs/CameraInfo describes them, as the calibration that the estimators need.
#pragma once

#include <memory>
#include <optional>

#include "common/camera/calibration.h"
#include "common/core/result.h"
#include "tools/data/import/recording.h"
#include "tools/data/import/ros_messages.h"

namespace gw::importer {

// Source pixel of every pixel of an undistorted, rotated image.
class Undistorter {
 public:
  // The image that `info` describes as seen by an ideal pinhole `target` whose frame is turned by
  // R_CT (target frame -> camera). Models: plumb_bob and rational_polynomial (OpenCV's
  // radial-tangential model, k1 k2 p1 p2 k3 k4 k5 k6; docs of OpenCV, "Camera Calibration and 3D
  // Reconstruction"), equidistant (Kannala, Brandt, "A generic camera model", 2006, as in OpenCV's
  // fisheye module: theta (1 + k1 theta^2 + ... + k4 theta^8)). Where the ideal camera looks past
  // the image the result is 0.
  // The result is `width` x `height` pixels large, or as large as the source.
  Undistorter(const RosCameraInfo& info, const PinholeIntrinsics& target,
              const Eigen::Matrix3d& R_CT, int width, int height);
  Undistorter(const RosCameraInfo& info, const PinholeIntrinsics& target,
              const Eigen::Matrix3d& R_CT);
  ~Undistorter();
  Undistorter(Undistorter&&) noexcept;
  Undistorter& operator=(Undistorter&&) noexcept;

  bool Fits(const Image& image) const;
  // Grey by bilinear, depth by nearest interpolation. depth_scale of a turned camera is not
  // corrected, so that R_CT must be the identity for depth. Precondition: Fits(image).
  Image Apply(const Image& image) const;

 private:
  struct Maps;
  std::unique_ptr<Maps> maps_;
};

// One eye: what the log will hold of it.
struct RosEye {
  PinholeIntrinsics intrinsics;
  std::optional<Undistorter> undistorter;  // for images that the front-end cannot rectify itself
  // Frame of the imported image -> optical frame that tf knows.
  Eigen::Matrix3d R_FromImported = Eigen::Matrix3d::Identity();
  int width = 0, height = 0;  // that the intrinsics are stated for; 0: of a part of the image
};

struct RosStereo {
  RosEye left, right;
  SE3 T_C0C1;  // of the imported images
};

// rectified: the images are those of image_rect, described by P. Distortion of five coefficients is
// left to the front-end; other models are undistorted here. Error: kBadData.
Result<RosEye> MakeRosEye(const RosCameraInfo& info, bool rectified);

// The pose between the eyes is that of R and P (ROS REP 104); where P has no baseline, tf's
// (T_C0C1_tf; empty: unknown). A right eye of another size than the left one's is resampled to the
// left one's size and intrinsics. Error: kBadData when neither is there.
Result<RosStereo> MakeRosStereo(const RosCameraInfo& left, const RosCameraInfo& right,
                                bool rectified, const std::optional<SE3>& T_C0C1_tf);

}  // namespace gw::importer
