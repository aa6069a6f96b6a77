#include "tools/data/import/camera_check.h"

#include <cmath>

#include "tools/data/files/format.h"

namespace gw::importer {
namespace {

// Greatest distance of the principal point from the middle of the image, as a share of its width or
// height. Published cameras of the formats here have up to 3.5 % (EuRoC's cam1); intrinsics of 640
// columns for 848 have 12 %.
constexpr double kLargestShift = 0.08;

void WarnOfEye(const char* name, const PinholeIntrinsics& eye, Recording& recording) {
  const CameraCalibration& camera = recording.calibration.camera;
  const double x = eye.cx - (camera.width - 1) / 2.0;
  const double y = eye.cy - (camera.height - 1) / 2.0;
  if (std::abs(x) < kLargestShift * camera.width && std::abs(y) < kLargestShift * camera.height) {
    return;
  }
  recording.warnings.push_back(tools::Format(
      "the principal point of the %s camera is %.0f, %.0f px off the middle of the %d x %d images: "
      "are the intrinsics of another size?",
      name, x, y, camera.width, camera.height));
}

}  // namespace

void WarnOfPrincipalPoint(Recording& recording) {
  if (!recording.frames) return;
  const CameraCalibration& camera = recording.calibration.camera;
  WarnOfEye("left", camera.left, recording);
  if (camera.kind == CameraKind::kStereo) WarnOfEye("right", camera.right, recording);
}

}  // namespace gw::importer
