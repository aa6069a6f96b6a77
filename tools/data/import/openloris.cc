#include "tools/data/import/openloris.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "common/camera/depth_sensors.h"
#include "tools/data/files/faults.h"
#include "tools/data/import/body_frame.h"
#include "tools/data/import/encoders.h"
#include "tools/data/import/image_list.h"
#include "tools/data/import/imu_check.h"
#include "tools/data/import/nominal_camera.h"
#include "tools/data/import/sensor_yaml.h"
#include "tools/data/import/stated_size.h"
#include "tools/data/import/stereo_range.h"
#include "tools/data/import/streams.h"
#include "tools/data/import/text_table.h"
#include "tools/data/import/trajectory.h"

namespace gw::importer {
namespace {

namespace fs = std::filesystem;

constexpr const char* kBody = "base_link";
constexpr const char* kColor = "d400_color_optical_frame";
constexpr const char* kInfra2 = "d400_infra2_optical_frame";
constexpr const char* kOdometer = "odometer";

bool Exists(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

// The rigid tree of trans_matrix.yaml: each entry is the pose of the child in its parent.
class FrameTree {
 public:
  static Result<FrameTree> Read(const fs::path& file, std::vector<std::string>& warnings) {
    const Result<SensorYaml> yaml = SensorYaml::Read(file, "the poses of the sensors");
    if (!yaml) return yaml.error();
    const Result<std::vector<SensorYaml>> list = yaml->List("trans_matrix");
    if (!list) return list.error();
    FrameTree tree;
    tree.file_ = file;
    for (const SensorYaml& entry : *list) {
      const Result<std::string> parent = entry.Text("parent_frame");
      if (!parent) return parent.error();
      const Result<std::string> child = entry.Text("child_frame");
      if (!child) return child.error();
      const Result<SE3> T = entry.Pose("matrix", warnings);
      if (!T) return T.error();
      tree.edges_[*parent].emplace_back(*child, *T);
      tree.edges_[*child].emplace_back(*parent, T->inverse());
    }
    return tree;
  }

  bool Has(const std::string& frame) const { return edges_.contains(frame); }

  // Pose of a frame in the body, over any chain of entries.
  Result<SE3> PoseInBody(const std::string& frame) const {
    std::set<std::string> seen = {kBody};
    std::vector<std::pair<std::string, SE3>> open = {{kBody, SE3()}};
    while (!open.empty()) {
      const auto [at, T_BAt] = open.back();
      open.pop_back();
      if (at == frame) return T_BAt;
      const auto edges = edges_.find(at);
      if (edges == edges_.end()) continue;
      for (const auto& [next, T_AtNext] : edges->second) {
        if (seen.insert(next).second) open.emplace_back(next, T_BAt * T_AtNext);
      }
    }
    return Error{ErrorCode::kBadData, file_.string() + ": no chain of frames leads from " +
                                          std::string(kBody) + " to " + frame};
  }

 private:
  fs::path file_;
  std::map<std::string, std::vector<std::pair<std::string, SE3>>> edges_;
};

struct Eye {
  PinholeIntrinsics intrinsics;
  SE3 T_BC;
  double width = 0, height = 0;  // that the intrinsics are stated for; 0: not stated
};

Result<Eye> ReadEye(const SensorYaml& sensors, const char* frame, const FrameTree& tree) {
  const Result<SensorYaml> section = sensors.Section(frame);
  if (!section) return section.error();
  const Result<std::vector<double>> k = section->Numbers("intrinsics", 4);
  if (!k) return k.error();
  Eye eye;
  eye.intrinsics = {(*k)[0], (*k)[2], (*k)[1], (*k)[3], {}};  // the file has fx, cx, fy, cy
  if (section->Has("distortion_coefficients")) {
    const Result<std::vector<double>> d = section->Numbers("distortion_coefficients", 0);
    if (!d) return d.error();
    if (d->size() > eye.intrinsics.radtan.size()) {
      return section->BadData("distortion_coefficients", "must hold at most k1, k2, p1, p2, k3");
    }
    std::copy(d->begin(), d->end(), eye.intrinsics.radtan.begin());
    const Result<std::string> model = section->Text("distortion_model");
    if (!model) return model.error();
    if (eye.intrinsics.distorted() && *model != "radial-tangential") {
      return section->BadData("distortion_model",
                              "is '" + *model + "'; only radial-tangential can be imported");
    }
  }
  for (const auto& [key, value] : {std::pair{"width", &eye.width}, {"height", &eye.height}}) {
    if (!section->Has(key)) continue;
    const Result<double> number = section->Number(key);
    if (!number) return number.error();
    *value = *number;
  }
  const Result<SE3> T_BC = tree.PoseInBody(frame);
  if (!T_BC) return T_BC.error();
  eye.T_BC = *T_BC;
  return eye;
}

Result<Done> FitEye(const fs::path& source, const char* frame, const Eye& eye,
                    PinholeIntrinsics* intrinsics, Recording& recording) {
  if (eye.width == 0 || eye.height == 0) return Done{};
  return FitStatedSize(eye.width, eye.height, (source / "sensors.yaml").string() + ": " + frame,
                       recording.calibration.camera, intrinsics, recording.warnings);
}

// color.txt with aligned_depth.txt; or, where a recording has infra2.txt instead of depth, the
// stereo pair of the colour frame (which then is the left infrared camera) and the right one.
Result<Done> ReadImages(const fs::path& source, const FrameTree& tree, const ReadOptions& options,
                        Recording& recording) {
  const Result<SensorYaml> sensors = SensorYaml::Read(source / "sensors.yaml", "the intrinsics");
  if (!sensors) return sensors.error();
  const Result<Eye> left = ReadEye(*sensors, kColor, tree);
  if (!left) return left.error();
  CameraCalibration& camera = recording.calibration.camera;
  camera.left = left->intrinsics;
  camera.T_BC = left->T_BC;
  const bool stereo = !Exists(source / "aligned_depth.txt") && Exists(source / "infra2.txt");
  Result<Eye> right = Eye();
  if (stereo) {
    right = ReadEye(*sensors, kInfra2, tree);
    if (!right) return right.error();
    camera.kind = CameraKind::kStereo;
    camera.right = right->intrinsics;
    camera.T_C0C1 = left->T_BC.inverse() * right->T_BC;
  }
  tools::Faults faults;
  const auto color = ReadImageList(source, "color.txt", recording.warnings);
  const auto second =
      ReadImageList(source, stereo ? "infra2.txt" : "aligned_depth.txt", recording.warnings);
  faults.Passed(color);
  faults.Passed(second);
  if (!faults.empty()) return faults.error();
  Result<std::vector<FrameFiles>> files = stereo
                                              ? PairStereo(*color, *second, recording.warnings)
                                              : PairWithDepth(*color, *second, recording.warnings);
  if (!files) return files.error();
  Result<std::unique_ptr<FrameSource>> frames =
      MakeFileFrames(*std::move(files), options, recording);
  if (!frames) return frames.error();
  recording.frames = *std::move(frames);
  Result<Done> fits = FitEye(source, kColor, *left, &camera.left, recording);
  if (fits && stereo) fits = FitEye(source, kInfra2, *right, &camera.right, recording);
  if (stereo) SetStereoRange(camera);
  return fits;
}

struct AxisSample {
  Utime utime;
  Eigen::Vector3d value;
};

Result<std::vector<AxisSample>> ReadAxes(const fs::path& file, Recording& recording) {
  const Result<TextTable> table = TextTable::Read(file, "lines `t x y z`");
  if (!table) return table.error();
  std::vector<AxisSample> samples;
  SpoiltRows spoilt;
  const auto read = table->ForEach(recording.warnings, [&](const TextRow& row) -> Result<Done> {
    if (spoilt.Skip(row, 0, 4)) return Done{};
    const Result<Utime> utime = row.Seconds(0);
    if (!utime) return utime.error();
    const Result<std::vector<double>> v = row.Numbers(1, 3);
    if (!v) return v.error();
    samples.push_back({*utime, {(*v)[0], (*v)[1], (*v)[2]}});
    return Done{};
  });
  if (!read) return read.error();
  const Result<Done> good = spoilt.Report(table->rows().size(), recording.warnings);
  if (!good) return good.error();
  OrderImu(samples, file.filename().string(), recording.warnings);
  return samples;
}

// Linear between the neighbours; empty outside, and across a gap of more than 50 ms (a dozen
// samples: interpolation would invent motion).
std::optional<Eigen::Vector3d> At(const std::vector<AxisSample>& samples, Utime utime) {
  const auto after = std::lower_bound(samples.begin(), samples.end(), utime,
                                      [](const AxisSample& s, Utime t) { return s.utime < t; });
  if (after == samples.end()) return std::nullopt;
  if (after->utime == utime) return after->value;
  if (after == samples.begin()) return std::nullopt;
  const auto before = std::prev(after);
  const DurationUs gap = after->utime - before->utime;
  if (gap > Milliseconds(50)) return std::nullopt;
  const double fraction = (utime - before->utime).seconds() / gap.seconds();
  return before->value + fraction * (after->value - before->value);
}

// Noise densities, and what has been done with a correction of the axes, where sensors.yaml states
// them.
Result<Done> ReadImuStatements(const SensorYaml& sensors, Recording& recording) {
  ImuCalibration& imu = recording.calibration.imu;
  for (const auto& [section, noise, walk] :
       {std::tuple{"d400_gyroscope", &imu.gyro_noise, &imu.gyro_walk},
        {"d400_accelerometer", &imu.accel_noise, &imu.accel_walk}}) {
    if (!sensors.Has(section)) continue;
    const Result<SensorYaml> sensor = sensors.Section(section);
    if (!sensor) return sensor.error();
    for (const auto& [key, value] : {std::pair{"noise_density", noise}, {"random_walk", walk}}) {
      if (!sensor->Has(key)) continue;
      const Result<double> number = sensor->Number(key);
      if (!number) return number.error();
      *value = *number;
    }
    if (!sensor->Has("imu_intrinsic")) continue;
    const Result<std::vector<double>> m = sensor->Numbers("imu_intrinsic", 12);
    if (!m) return m.error();
    if (*m != std::vector<double>{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}) {
      recording.warnings.push_back(std::string("sensors.yaml: imu_intrinsic of ") + section +
                                   " is not applied: the camera's library has done so already");
    }
  }
  return Done{};
}

// Track and ticks of the base; ticks_per_turn comes from the command line, 0: not given.
Result<Done> ReadBase(const SensorYaml& sensors, double ticks_per_turn, Recording& recording) {
  if (!sensors.Has(kOdometer)) return Done{};
  const Result<SensorYaml> odometer = sensors.Section(kOdometer);
  if (!odometer) return odometer.error();
  WheelCalibration& wheel = recording.calibration.wheel;
  double radius_m = 0;
  for (const auto& [key, value] :
       {std::pair{"wheel_base", &wheel.track_width_m}, {"wheel_radius", &radius_m}}) {
    if (!odometer->Has(key)) continue;
    const Result<double> number = odometer->Number(key);
    if (!number) return number.error();
    if (*number <= 0) return odometer->BadData(key, "must be positive");
    *value = *number;
  }
  if (radius_m > 0 && ticks_per_turn > 0) {
    wheel.ticks_per_metre = ticks_per_turn / (2 * M_PI * radius_m);
  }
  return Done{};
}

Result<Done> ReadWheels(const fs::path& source, const OpenLorisOptions& options,
                        Recording& recording) {
  if (!options.encoders.empty()) {
    const WheelCalibration& wheel = recording.calibration.wheel;
    auto wheels = ReadEncoders(options.encoders, {wheel.ticks_per_metre, wheel.track_width_m},
                               recording.warnings);
    if (!wheels) return wheels.error();
    recording.wheel = *std::move(wheels);
    recording.notes.emplace_back("wheel", "increments between the encoders' readings of " +
                                              options.encoders.filename().string());
    return Done{};
  }
  const auto odometry = ReadTumTrajectory(
      source / "odom.txt", "lines `t px py pz qx qy qz qw ...` of base_link", recording.warnings);
  if (!odometry) return odometry.error();
  recording.wheel = WheelIncrements(*odometry);
  recording.notes.emplace_back(
      "wheel",
      "increments between odometry poses (the file's twists are left out: some are in the "
      "odometry frame); except in `market` the odometry is already fused with a gyro");
  return Done{};
}

Result<Done> ReadImu(const fs::path& source, const FrameTree& tree, Recording& recording) {
  tools::Faults faults;
  const auto gyro = ReadAxes(source / "d400_gyroscope.txt", recording);
  const auto accel = ReadAxes(source / "d400_accelerometer.txt", recording);
  faults.Passed(gyro);
  faults.Passed(accel);
  if (!faults.empty()) return faults.error();
  for (const AxisSample& w : *gyro) {
    const std::optional<Eigen::Vector3d> a = At(*accel, w.utime);
    ImuSample sample;
    sample.utime = w.utime;
    sample.w_I_rad_s = w.value;
    sample.has_accel = a.has_value();
    if (a) sample.a_I_m_s2 = *a;
    recording.imu.push_back(sample);
  }
  const char* const frame = tree.Has("d400_gyroscope") ? "d400_gyroscope" : "d400_accelerometer";
  const Result<SE3> T_BI = tree.PoseInBody(frame);
  if (!T_BI) return T_BI.error();
  recording.calibration.imu.T_BI = *T_BI;
  recording.notes.emplace_back(
      "imu",
      "gyro samples; the accelerometer, sampled at other instants, is "
      "interpolated to them; noise densities are those of sensors.yaml, where it "
      "states noise_density, else defaults");
  return Done{};
}

// What sensors.yaml says of the IMU and of the base.
Result<Done> ReadStatements(const fs::path& file, const OpenLorisOptions& options,
                            Recording& recording) {
  const Result<SensorYaml> sensors = SensorYaml::Read(file, "the sensors");
  if (!sensors) return sensors.error();
  const Result<Done> stated = ReadImuStatements(*sensors, recording);
  return stated ? ReadBase(*sensors, options.ticks_per_turn, recording) : stated;
}

Result<Done> ReadTruth(const fs::path& file, Recording& recording) {
  if (!Exists(file)) {
    recording.warnings.emplace_back("groundtruth.txt is not there: no ground truth in the log");
    return Done{};
  }
  const auto T_GB = ReadTrueTrajectory(file, "poses of base_link", recording.warnings);
  if (!T_GB) return T_GB.error();
  recording.ground_truth = GroundTruthOfBody(*T_GB, SE3());
  return Done{};
}

}  // namespace

Result<Recording> ReadOpenLoris(const fs::path& source, const OpenLorisOptions& options) {
  Recording recording;
  recording.format = "openloris";
  recording.name = FolderName(source);
  recording.calibration.camera.kind = CameraKind::kRgbd;
  recording.calibration.camera.depth_unit_m = 0.001;
  SetDepthSensor(kRealSenseD435, &recording.calibration.camera);

  const bool has_images = Exists(source / "color.txt");
  const bool has_imu = Exists(source / "d400_gyroscope.txt");
  tools::Faults faults;
  FrameTree tree;
  if (has_images || has_imu) {
    Result<FrameTree> read = FrameTree::Read(source / "trans_matrix.yaml", recording.warnings);
    if (faults.Passed(read)) tree = *std::move(read);
  }
  if (has_images) {
    faults.Passed(ReadImages(source, tree, options, recording));
  } else {
    SetNominalCamera("color.txt is not there", recording);
  }
  if (has_imu) {
    faults.Passed(ReadImu(source, tree, recording));
  } else {
    recording.warnings.emplace_back("d400_gyroscope.txt is not there: no IMU in the log");
  }
  if (Exists(source / "sensors.yaml")) {
    faults.Passed(ReadStatements(source / "sensors.yaml", options, recording));
  }
  faults.Passed(ReadWheels(source, options, recording));
  faults.Passed(ReadTruth(source / "groundtruth.txt", recording));
  if (!faults.empty()) return faults.error();
  if (tree.Has(kOdometer)) {
    const Result<SE3> T_BN = tree.PoseInBody(kOdometer);
    if (!T_BN) return T_BN.error();
    MoveBodyToWheels(*T_BN, recording);
    recording.notes.emplace_back(
        "body", "the odometer's frame (trans_matrix.yaml); sensors and ground truth are in it");
  }
  return recording;
}

}  // namespace gw::importer
