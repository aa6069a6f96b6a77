#include "tools/data/import/tum.h"

#include <charconv>
#include <cmath>

#include "tools/data/import/image_list.h"
#include "tools/data/import/sensor_yaml.h"
#include "tools/data/import/trajectory.h"

namespace gw::importer {
namespace {

// The colour cameras as the data set's page publishes them.
std::optional<PinholeIntrinsics> Preset(const std::string& camera) {
  if (camera == "fr1") {
    return PinholeIntrinsics{
        517.3, 516.5, 318.6, 255.3, {0.2624, -0.9531, -0.0054, 0.0026, 1.1633}};
  }
  if (camera == "fr2") {
    return PinholeIntrinsics{
        520.9, 521.0, 325.1, 249.7, {0.2312, -0.7849, -0.0033, -0.0001, 0.9172}};
  }
  if (camera == "fr3") return PinholeIntrinsics{535.4, 539.2, 320.1, 247.6, {}};
  return std::nullopt;
}

}  // namespace

Result<PinholeIntrinsics> ParseIntrinsics(const std::string& text) {
  std::vector<double> values;
  const char* at = text.data();
  const char* const end = at + text.size();
  bool complete = false;
  while (!complete) {
    double value = 0;
    const auto [next, status] = std::from_chars(at, end, value);
    if (status != std::errc() || !std::isfinite(value) || (next != end && *next != ',')) break;
    values.push_back(value);
    complete = next == end;
    at = next + (complete ? 0 : 1);
  }
  if (!complete || (values.size() != 4 && values.size() != 9) || values[0] <= 0 || values[1] <= 0) {
    return Error{ErrorCode::kInvalidArgument,
                 "--intrinsics " + text + ": expected fx,fy,cx,cy or fx,fy,cx,cy,k1,k2,p1,p2,k3"};
  }
  PinholeIntrinsics camera{values[0], values[1], values[2], values[3], {}};
  std::copy(values.begin() + 4, values.end(), camera.radtan.begin());
  return camera;
}

Result<Recording> ReadTum(const std::filesystem::path& source, const TumOptions& options) {
  Recording recording;
  recording.format = "tum";
  recording.name = FolderName(source);
  CameraCalibration& camera = recording.calibration.camera;
  const std::optional<PinholeIntrinsics> preset = Preset(options.camera);
  if (!options.intrinsics && !preset) {
    return Error{ErrorCode::kInvalidArgument,
                 "--camera " + options.camera + ": no such preset; use fr1, fr2 or fr3"};
  }
  camera.kind = CameraKind::kRgbd;
  // Kinect v1's colour camera has a rolling shutter. Measured: of readouts from 0 to 33 ms, 22 to
  // 26 ms give the smallest trajectory error on fr1_rpy (docs/results.md).
  if (options.camera != "fr3") camera.readout_s = 0.026;
  camera.left = options.intrinsics ? *options.intrinsics : *preset;
  camera.depth_unit_m = 1.0 / 5000.0;
  camera.T_BC = BodyAtCamera_T_BC();
  recording.notes.emplace_back("camera", options.intrinsics ? "intrinsics as given by the user"
                                                            : "preset " + options.camera);

  const auto grey = ReadImageList(source, "rgb.txt", recording.warnings);
  if (!grey) return grey.error();
  const auto depth = ReadImageList(source, "depth.txt", recording.warnings);
  if (!depth) return depth.error();
  Result<std::vector<FrameFiles>> files = PairWithDepth(*grey, *depth, recording.warnings);
  if (!files) return files.error();
  Result<std::unique_ptr<FrameSource>> frames =
      MakeFileFrames(*std::move(files), options, recording);
  if (!frames) return frames.error();
  recording.frames = *std::move(frames);

  std::error_code ignored;
  if (std::filesystem::exists(source / "groundtruth.txt", ignored)) {
    const Result<std::vector<StampedPose>> T_GC =
        ReadTumTrajectory(source / "groundtruth.txt", "ground truth", recording.warnings);
    if (!T_GC) return T_GC.error();
    recording.ground_truth = GroundTruthOfBody(*T_GC, camera.T_BC);
  } else {
    recording.warnings.emplace_back("groundtruth.txt is not there: no ground truth in the log");
  }
  if (std::filesystem::exists(source / "accelerometer.txt", ignored)) {
    recording.notes.emplace_back("imu", "accelerometer.txt left out: an IMU sample needs a gyro");
  }
  recording.notes.emplace_back("licence", "CC BY 4.0; cite Sturm et al., IROS 2012");
  return recording;
}

}  // namespace gw::importer
