#include "tools/data/import/tum.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>

#include "common/camera/depth_sensors.h"
#include "common/core/median.h"
#include "tools/data/files/faults.h"
#include "tools/data/files/format.h"
#include "tools/data/import/image_list.h"
#include "tools/data/import/sensor_yaml.h"
#include "tools/data/import/stated_size.h"
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

constexpr int kPresetWidth = 640;  // px
constexpr int kPresetHeight = 480;
constexpr double kTumDepthUnit = 1.0 / 5000.0;  // m
constexpr double kMillimetre = 0.001;           // m: the unit of a RealSense

// The camera that a folder's name states: "rgbd_dataset_freiburg2_desk", "fr2_desk"; or empty.
std::string CameraOfName(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const char number : {'1', '2', '3'}) {
    for (const char* prefix : {"freiburg", "fr"}) {
      if (name.find(std::string(prefix) + number) != std::string::npos) {
        return std::string("fr") + number;
      }
    }
  }
  return "";
}

Result<Done> SetCamera(const TumOptions& options, Recording& recording) {
  CameraCalibration& camera = recording.calibration.camera;
  camera.kind = CameraKind::kRgbd;
  camera.T_BC = PoseOfBodyAtCamera();
  camera.depth_unit_m = options.depth_unit_m.value_or(kTumDepthUnit);
  SetDepthSensor(kKinectOfTum, &camera);
  if (options.intrinsics) {
    camera.left = *options.intrinsics;
    recording.notes.emplace_back("camera", "intrinsics as given by the user");
    return Done{};
  }
  std::string name = options.camera.empty() ? CameraOfName(recording.name) : options.camera;
  if (name.empty()) {
    name = "fr1";
    recording.warnings.emplace_back(
        "the folder's name says neither freiburg1, 2 nor 3: intrinsics and rolling shutter of "
        "freiburg1's Kinect are ASSUMED; name the camera with --camera fr1|fr2|fr3, or give "
        "--intrinsics of your own");
  }
  const std::optional<PinholeIntrinsics> preset = Preset(name);
  if (!preset) {
    return Error{ErrorCode::kInvalidArgument,
                 "--camera " + name + ": no such preset; use fr1, fr2 or fr3"};
  }
  camera.left = *preset;
  // Kinect v1's colour camera has a rolling shutter. Measured: of readouts from 0 to 33 ms, 22 to
  // 26 ms give the smallest trajectory error on fr1_rpy (docs/adr/0005-rolling-shutter.md).
  if (name != "fr3") camera.readout_s = 0.026;
  recording.notes.emplace_back("camera", "preset " + name);
  return Done{};
}

// A focal length fy below 0 means an image whose y axis points up in the camera's frame, as
// ICL-NUIM (Handa et al., ICRA 2014) states its own. Made our camera by a mirror in y, which is
// told to the ground truth too. True when it was so.
bool TurnYDown(Recording& recording) {
  PinholeIntrinsics& camera = recording.calibration.camera.left;
  if (camera.fy >= 0) return false;
  camera.fy = -camera.fy;
  recording.warnings.emplace_back(
      "fy is negative: taken as a camera frame whose y axis points up (as ICL-NUIM's); fy is made "
      "positive, and the ground truth is mirrored in y");
  return true;
}

// S R S and S p, S = diag(1, -1, 1).
SE3 MirroredInY(const SE3& T) {
  const Eigen::Quaterniond& q = T.rotation();
  const Eigen::Vector3d& p = T.translation();
  return SE3(Eigen::Quaterniond(q.w(), -q.x(), q.y(), -q.z()), {p.x(), -p.y(), p.z()});
}

// rgb.txt and depth.txt; where there is no rgb.txt, a list of both by one of its usual names.
Result<std::vector<FrameFiles>> ListFrames(const std::filesystem::path& source,
                                           std::vector<std::string>& warnings) {
  std::error_code ignored;
  for (const char* name :
       {"associations.txt", "association.txt", "associate.txt", "associated.txt"}) {
    if (std::filesystem::exists(source / "rgb.txt", ignored)) break;
    if (std::filesystem::exists(source / name, ignored)) {
      return ReadAssociations(source, name, warnings);
    }
  }
  tools::Faults faults;
  const auto grey = ReadImageList(source, "rgb.txt", warnings);
  const auto depth = ReadImageList(source, "depth.txt", warnings);
  faults.Passed(grey);
  faults.Passed(depth);
  if (!faults.empty()) return faults.error();
  return PairWithDepth(*grey, *depth, warnings);
}

void WarnOfFrameNumbers(const FrameSource& frames, Recording& recording) {
  for (size_t i = 0; i < frames.size(); ++i) {
    if (frames.utime(i).us % 1'000'000 != 0) return;
  }
  if (frames.size() < 10) return;
  recording.warnings.emplace_back(
      "every time is a whole second: are they numbers of images? Then all speeds are wrong; write "
      "times in seconds");
}

Result<Done> ReadFrames(const std::filesystem::path& source, const TumOptions& options,
                        Recording& recording) {
  Result<std::vector<FrameFiles>> files = ListFrames(source, recording.warnings);
  if (!files) return files.error();
  Result<std::unique_ptr<FrameSource>> frames =
      MakeFileFrames(*std::move(files), options, recording);
  if (!frames) return frames.error();
  recording.frames = *std::move(frames);
  WarnOfFrameNumbers(*recording.frames, recording);
  return Done{};
}

// A camera of one's own that is given in TUM's layout: says what the unit makes of an image.
void WarnOfDepthUnit(const Image& depth, Recording& recording) {
  std::vector<uint16_t> values;
  for (size_t i = 0; i + 1 < depth.bytes.size(); i += 2) {
    uint16_t value = 0;
    std::memcpy(&value, &depth.bytes[i], sizeof value);
    if (value > 0) values.push_back(value);
  }
  if (values.empty()) return;
  const int median = MedianOf(&values);
  recording.warnings.push_back(tools::Format(
      "depth is ASSUMED in TUM's unit of 1/5000 m: the first image's median is then %.2f "
      "m; with --depth-unit 0.001 (millimetres, as of a RealSense) it would be %.2f m",
      median * kTumDepthUnit, median * kMillimetre));
}

// What is assumed of the camera must fit the images, or is said.
Result<Done> CheckAssumptions(const TumOptions& options, Recording& recording) {
  if (!options.intrinsics) {
    CameraCalibration& camera = recording.calibration.camera;
    return FitStatedSize(kPresetWidth, kPresetHeight,
                         "preset of the camera (--intrinsics gives others)", camera, &camera.left,
                         recording.warnings);
  }
  if (options.depth_unit_m) return Done{};
  for (size_t i = 0; i < recording.frames->size(); ++i) {
    const Result<FramePixels> pixels = recording.frames->Load(i);
    if (!pixels && !options.skip_missing) return pixels.error();
    if (!pixels) continue;
    WarnOfDepthUnit(pixels->depth, recording);
    break;
  }
  return Done{};
}

Result<Done> ReadTruth(const std::filesystem::path& file, bool y_is_up, Recording& recording) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) {
    recording.warnings.emplace_back("groundtruth.txt is not there: no ground truth in the log");
    return Done{};
  }
  Result<std::vector<StampedPose>> T_GC =
      ReadTrueTrajectory(file, "ground truth", recording.warnings);
  if (!T_GC) return T_GC.error();
  if (y_is_up) {
    for (StampedPose& pose : *T_GC) pose.T = MirroredInY(pose.T);
  }
  recording.ground_truth = GroundTruthOfBody(*T_GC, recording.calibration.camera.T_BC);
  return Done{};
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
  if (!complete || (values.size() != 4 && values.size() != 9) || values[0] <= 0 || values[1] == 0) {
    return Error{ErrorCode::kInvalidArgument,
                 "--intrinsics " + text +
                     ": expected fx,fy,cx,cy or fx,fy,cx,cy,k1,k2,p1,p2,k3 with fx above 0"};
  }
  PinholeIntrinsics camera{values[0], values[1], values[2], values[3], {}};
  std::copy(values.begin() + 4, values.end(), camera.radtan.begin());
  return camera;
}

Result<Recording> ReadTum(const std::filesystem::path& source, const TumOptions& options) {
  Recording recording;
  recording.format = "tum";
  recording.name = FolderName(source);
  const Result<Done> camera_set = SetCamera(options, recording);
  if (!camera_set) return camera_set.error();
  const bool y_is_up = TurnYDown(recording);
  tools::Faults faults;
  if (faults.Passed(ReadFrames(source, options, recording))) {
    faults.Passed(CheckAssumptions(options, recording));
  }
  faults.Passed(ReadTruth(source / "groundtruth.txt", y_is_up, recording));
  if (!faults.empty()) return faults.error();
  std::error_code ignored;
  if (std::filesystem::exists(source / "accelerometer.txt", ignored)) {
    recording.notes.emplace_back("imu", "accelerometer.txt left out: an IMU sample needs a gyro");
  }
  recording.notes.emplace_back("licence", "CC BY 4.0; cite Sturm et al., IROS 2012");
  return recording;
}

}  // namespace gw::importer
