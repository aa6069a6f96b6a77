#include "tools/data/import/ros_camera.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <opencv2/imgproc.hpp>

namespace gw::importer {
namespace {

using Matrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Error Refused(const RosCameraInfo& info, const std::string& what) {
  return {ErrorCode::kBadData, "CameraInfo of " + info.frame + ": " + what};
}

bool IsFisheye(const RosCameraInfo& info) {
  return info.model == "equidistant" || info.model == "fisheye";
}

double Coefficient(const RosCameraInfo& info, size_t index) {
  return index < info.D.size() ? info.D[index] : 0;
}

bool Distorted(const RosCameraInfo& info, size_t from) {
  return std::any_of(info.D.begin() + static_cast<int64_t>(std::min(from, info.D.size())),
                     info.D.end(), [](double k) { return k != 0; });
}

Eigen::Vector2d DistortFisheye(const RosCameraInfo& info, const Eigen::Vector2d& p) {
  const double r = p.norm();
  if (r < 1e-9) return p;
  const double theta = std::atan(r);
  const double t2 = theta * theta;
  const double scaled =
      theta * (1 + t2 * (Coefficient(info, 0) +
                         t2 * (Coefficient(info, 1) +
                               t2 * (Coefficient(info, 2) + t2 * Coefficient(info, 3)))));
  return p * (scaled / r);
}

Eigen::Vector2d DistortRational(const RosCameraInfo& info, const Eigen::Vector2d& p) {
  const auto k = [&](size_t i) { return Coefficient(info, i); };
  const double x = p.x(), y = p.y();
  const double r2 = p.squaredNorm();
  const double radial =
      (1 + r2 * (k(0) + r2 * (k(1) + r2 * k(4)))) / (1 + r2 * (k(5) + r2 * (k(6) + r2 * k(7))));
  return {x * radial + 2 * k(2) * x * y + k(3) * (r2 + 2 * x * x),
          y * radial + k(2) * (r2 + 2 * y * y) + 2 * k(3) * x * y};
}

Eigen::Vector2d Distorted(const RosCameraInfo& info, const Eigen::Vector2d& p) {
  return IsFisheye(info) ? DistortFisheye(info, p) : DistortRational(info, p);
}

// Of the whole image that the sensor gives.
int WidthOf(const RosCameraInfo& info) {
  return info.width / std::max(info.binning_x, 1);
}
int HeightOf(const RosCameraInfo& info) {
  return info.height / std::max(info.binning_y, 1);
}

// K of the pixels that the image really has: after the region of interest and binning.
PinholeIntrinsics FromK(const RosCameraInfo& info) {
  const double bx = std::max(info.binning_x, 1);
  const double by = std::max(info.binning_y, 1);
  return {info.K[0] / bx,
          info.K[4] / by,
          (info.K[2] - info.offset_x) / bx,
          (info.K[5] - info.offset_y) / by,
          {}};
}

PinholeIntrinsics FromP(const RosCameraInfo& info) {
  const double bx = std::max(info.binning_x, 1);
  const double by = std::max(info.binning_y, 1);
  return {info.P[0] / bx,
          info.P[5] / by,
          (info.P[2] - info.offset_x) / bx,
          (info.P[6] - info.offset_y) / by,
          {}};
}

// Rectified frame of the pair from the camera's; identity where none is stated (all zero).
Eigen::Matrix3d RectificationOf(const RosCameraInfo& info) {
  const Eigen::Matrix3d R = Eigen::Map<const Matrix3>(info.R.data());
  return std::abs(R.determinant() - 1) < 1e-3 ? R : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
}

double BaselineOf(const RosCameraInfo& right) {
  return right.P[0] > 0 ? -right.P[3] / right.P[0] : 0;
}

Result<Done> CheckInfo(const RosCameraInfo& info) {
  if (!(info.K[0] > 0) || !(info.K[4] > 0)) {
    return Refused(info,
                   "is not calibrated (K is zero); calibrate the camera, or give "
                   "--calibration ROBOT.yaml");
  }
  const bool known = info.model.empty() || info.model == "plumb_bob" || info.model == "none" ||
                     info.model == "rational_polynomial" || IsFisheye(info) || !Distorted(info, 0);
  if (!known) {
    return Refused(info, "its model '" + info.model +
                             "' is not known; plumb_bob, rational_polynomial and equidistant are");
  }
  return Done{};
}

}  // namespace

struct Undistorter::Maps {
  cv::Mat x, y;
  int source_width = 0, source_height = 0;
};

Undistorter::Undistorter(const RosCameraInfo& info, const PinholeIntrinsics& target,
                         const Eigen::Matrix3d& R_CT)
    : Undistorter(info, target, R_CT, WidthOf(info), HeightOf(info)) {}

Undistorter::Undistorter(const RosCameraInfo& info, const PinholeIntrinsics& target,
                         const Eigen::Matrix3d& R_CT, int width, int height)
    : maps_(std::make_unique<Maps>()) {
  const PinholeIntrinsics source = FromK(info);
  maps_->source_width = WidthOf(info);
  maps_->source_height = HeightOf(info);
  maps_->x.create(height, width, CV_32FC1);
  maps_->y.create(height, width, CV_32FC1);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const Eigen::Vector3d ray =
          R_CT * Eigen::Vector3d((u - target.cx) / target.fx, (v - target.cy) / target.fy, 1);
      Eigen::Vector2d pixel(-10, -10);
      if (ray.z() > 1e-6) {
        const Eigen::Vector2d p = Distorted(info, ray.head<2>() / ray.z());
        pixel = {source.fx * p.x() + source.cx, source.fy * p.y() + source.cy};
      }
      maps_->x.at<float>(v, u) = static_cast<float>(pixel.x());
      maps_->y.at<float>(v, u) = static_cast<float>(pixel.y());
    }
  }
}
Undistorter::~Undistorter() = default;
Undistorter::Undistorter(Undistorter&&) noexcept = default;
Undistorter& Undistorter::operator=(Undistorter&&) noexcept = default;

bool Undistorter::Fits(const Image& image) const {
  return image.width == maps_->source_width && image.height == maps_->source_height;
}

Image Undistorter::Apply(const Image& image) const {
  const bool grey = image.format == PixelFormat::kGray8;
  const int type = grey ? CV_8UC1 : CV_16UC1;
  // cv::Mat has no view of constant pixels; they are not written.
  const cv::Mat in(image.height, image.width, type, const_cast<uint8_t*>(image.bytes.data()));
  cv::Mat out;
  cv::remap(in, out, maps_->x, maps_->y, grey ? cv::INTER_LINEAR : cv::INTER_NEAREST,
            cv::BORDER_CONSTANT);
  Image result = image;
  result.width = out.cols;
  result.height = out.rows;
  result.converted = true;
  result.bytes.resize(out.total() * out.elemSize());
  std::memcpy(result.bytes.data(), out.data, result.bytes.size());
  return result;
}

Result<RosEye> MakeRosEye(const RosCameraInfo& info, bool rectified) {
  const Result<Done> good = CheckInfo(info);
  if (!good) return good.error();
  RosEye eye;
  if (info.offset_x == 0 && info.offset_y == 0) {
    eye.width = WidthOf(info);
    eye.height = HeightOf(info);
  }
  if (rectified) {
    if (!(info.P[0] > 0)) return Refused(info, "P is zero, but the image is a rectified one");
    eye.intrinsics = FromP(info);
    eye.R_FromImported = RectificationOf(info).transpose();
    return eye;
  }
  eye.intrinsics = FromK(info);
  if (IsFisheye(info) || Distorted(info, 5)) {
    if (info.P[0] > 0) eye.intrinsics = FromP(info);
    eye.R_FromImported = RectificationOf(info).transpose();
    eye.undistorter.emplace(info, eye.intrinsics, eye.R_FromImported);
  } else {
    for (size_t i = 0; i < 5; ++i) eye.intrinsics.radtan[i] = Coefficient(info, i);
  }
  return eye;
}

namespace {

// Makes the right eye's images those of a camera like the left one: one size and focal length is
// what two eyes are rectified and matched in.
void ResampleToLeft(const RosCameraInfo& right, bool rectified, RosStereo& stereo) {
  RosCameraInfo source = right;
  if (rectified) {
    // The images are those of P, free of distortion and already turned.
    source.D.clear();
    source.K = {right.P[0], 0, right.P[2], 0, right.P[5], right.P[6], 0, 0, 1};
  }
  PinholeIntrinsics target = stereo.left.intrinsics;
  target.radtan = {};
  stereo.right.undistorter.emplace(
      source, target,
      rectified ? Eigen::Matrix3d(Eigen::Matrix3d::Identity()) : stereo.right.R_FromImported,
      stereo.left.width, stereo.left.height);
  stereo.right.intrinsics = target;
  stereo.right.width = stereo.left.width;
  stereo.right.height = stereo.left.height;
}

}  // namespace

Result<RosStereo> MakeRosStereo(const RosCameraInfo& left, const RosCameraInfo& right,
                                bool rectified, const std::optional<SE3>& T_C0C1_tf) {
  Result<RosEye> left_eye = MakeRosEye(left, rectified);
  if (!left_eye) return left_eye.error();
  Result<RosEye> right_eye = MakeRosEye(right, rectified);
  if (!right_eye) return right_eye.error();
  RosStereo stereo{*std::move(left_eye), *std::move(right_eye), SE3()};
  const bool whole = stereo.left.width > 0 && stereo.right.width > 0;  // no part of an image
  if (whole &&
      (stereo.left.width != stereo.right.width || stereo.left.height != stereo.right.height)) {
    ResampleToLeft(right, rectified, stereo);
  }
  const double baseline = BaselineOf(right);
  // From the rectified frames, which differ by the baseline alone, to those of the imported images.
  const Eigen::Matrix3d R_C0Rect =
      stereo.left.R_FromImported.transpose() * RectificationOf(left).transpose();
  const Eigen::Matrix3d R_C1Rect =
      stereo.right.R_FromImported.transpose() * RectificationOf(right).transpose();
  if (baseline != 0) {
    stereo.T_C0C1 = SE3(Eigen::Quaterniond(R_C0Rect * R_C1Rect.transpose()),
                        R_C0Rect * Eigen::Vector3d(baseline, 0, 0));
    return stereo;
  }
  // Both eyes may be stamped with the left one's frame.
  if (!T_C0C1_tf || T_C0C1_tf->translation().norm() == 0) {
    return Refused(right,
                   "has no baseline (P[3] is 0), and tf does not tell where the right eye is "
                   "in the left; is this the left camera's, or not calibrated as stereo?");
  }
  const SE3 T_LeftImported(Eigen::Quaterniond(stereo.left.R_FromImported), Eigen::Vector3d::Zero());
  const SE3 T_RightImported(Eigen::Quaterniond(stereo.right.R_FromImported),
                            Eigen::Vector3d::Zero());
  stereo.T_C0C1 = T_LeftImported.inverse() * *T_C0C1_tf * T_RightImported;
  return stereo;
}

}  // namespace gw::importer
