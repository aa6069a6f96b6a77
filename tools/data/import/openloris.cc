#include "tools/data/import/openloris.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "tools/data/import/image_list.h"
#include "tools/data/import/sensor_yaml.h"
#include "tools/data/import/streams.h"
#include "tools/data/import/text_table.h"
#include "tools/data/import/trajectory.h"

namespace gw::importer {
namespace {

namespace fs = std::filesystem;

constexpr const char* kBody = "base_link";
constexpr const char* kColor = "d400_color_optical_frame";

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

Result<Done> ReadCamera(const fs::path& source, const FrameTree& tree, Recording& recording) {
  const Result<SensorYaml> sensors = SensorYaml::Read(source / "sensors.yaml", "the intrinsics");
  if (!sensors) return sensors.error();
  const Result<SensorYaml> color = sensors->Section(kColor);
  if (!color) return color.error();
  const Result<std::vector<double>> k = color->Numbers("intrinsics", 4);
  if (!k) return k.error();
  CameraCalibration& camera = recording.calibration.camera;
  camera.left = {(*k)[0], (*k)[2], (*k)[1], (*k)[3], {}};  // the file's order is fx, cx, fy, cy
  if (color->Has("distortion_coefficients")) {
    const Result<std::vector<double>> d = color->Numbers("distortion_coefficients", 0);
    if (!d) return d.error();
    if (d->size() > camera.left.radtan.size()) {
      return color->BadData("distortion_coefficients", "must hold at most k1, k2, p1, p2, k3");
    }
    std::copy(d->begin(), d->end(), camera.left.radtan.begin());
    const Result<std::string> model = color->Text("distortion_model");
    if (!model) return model.error();
    if (camera.left.distorted() && *model != "radial-tangential") {
      return color->BadData("distortion_model",
                            "is '" + *model + "'; only radial-tangential can be imported");
    }
  }
  const Result<SE3> T_BC = tree.PoseInBody(kColor);
  if (!T_BC) return T_BC.error();
  camera.T_BC = *T_BC;
  return Done{};
}

// The D435i's nominal colour camera at 848 x 480, for recordings without images: the YAML needs a
// camera section, and nothing reads its values.
void SetNominalCamera(Recording& recording) {
  CameraCalibration& camera = recording.calibration.camera;
  camera.width = 848;
  camera.height = 480;
  camera.left = {610, 610, 424, 240, {}};
  camera.T_BC = BodyAtCamera_T_BC();
  recording.warnings.emplace_back(
      "color.txt is not there: no images in the log, and the camera calibration is only nominal");
}

struct AxisSample {
  Utime utime;
  Eigen::Vector3d value;
};

Result<std::vector<AxisSample>> ReadAxes(const fs::path& file, Recording& recording) {
  const Result<TextTable> table = TextTable::Read(file, "lines `t x y z`");
  if (!table) return table.error();
  std::vector<AxisSample> samples;
  for (const TextRow& row : table->rows()) {
    const Result<Utime> utime = row.Seconds(0);
    if (!utime) return utime.error();
    const Result<std::vector<double>> v = row.Numbers(1, 3);
    if (!v) return v.error();
    samples.push_back({*utime, {(*v)[0], (*v)[1], (*v)[2]}});
  }
  MakeOrdered(samples, file.filename().string(), recording.warnings);
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

Result<Done> ReadImu(const fs::path& source, const FrameTree& tree, Recording& recording) {
  const auto gyro = ReadAxes(source / "d400_gyroscope.txt", recording);
  if (!gyro) return gyro.error();
  const auto accel = ReadAxes(source / "d400_accelerometer.txt", recording);
  if (!accel) return accel.error();
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
  recording.notes.emplace_back("imu",
                               "gyro samples; the accelerometer, sampled at other instants, is "
                               "interpolated to them; noise densities are defaults");
  return Done{};
}

}  // namespace

Result<Recording> ReadOpenLoris(const fs::path& source, const ReadOptions& options) {
  Recording recording;
  recording.format = "openloris";
  recording.name = FolderName(source);
  recording.calibration.camera.kind = CameraKind::kRgbd;
  recording.calibration.camera.depth_unit_m = 0.001;

  const bool has_images = Exists(source / "color.txt");
  const bool has_imu = Exists(source / "d400_gyroscope.txt");
  FrameTree tree;
  if (has_images || has_imu) {
    Result<FrameTree> read = FrameTree::Read(source / "trans_matrix.yaml", recording.warnings);
    if (!read) return read.error();
    tree = *std::move(read);
  }
  if (has_images) {
    const Result<Done> camera = ReadCamera(source, tree, recording);
    if (!camera) return camera.error();
    const auto color = ReadImageList(source, "color.txt", recording.warnings);
    if (!color) return color.error();
    const auto depth = ReadImageList(source, "aligned_depth.txt", recording.warnings);
    if (!depth) return depth.error();
    Result<std::vector<FrameFiles>> files = PairWithDepth(*color, *depth, recording.warnings);
    if (!files) return files.error();
    Result<std::unique_ptr<FrameSource>> frames =
        MakeFileFrames(*std::move(files), options, recording);
    if (!frames) return frames.error();
    recording.frames = *std::move(frames);
  } else {
    SetNominalCamera(recording);
  }
  if (has_imu) {
    const Result<Done> imu = ReadImu(source, tree, recording);
    if (!imu) return imu.error();
  } else {
    recording.warnings.emplace_back("d400_gyroscope.txt is not there: no IMU in the log");
  }
  const auto odometry = ReadTumTrajectory(
      source / "odom.txt", "lines `t px py pz qx qy qz qw ...` of base_link", recording.warnings);
  if (!odometry) return odometry.error();
  recording.wheel = WheelIncrements(*odometry);
  recording.notes.emplace_back(
      "wheel",
      "increments between odometry poses (the file's twists are left out: some are in the "
      "odometry frame); except in `market` the odometry is already fused with a gyro");
  if (Exists(source / "groundtruth.txt")) {
    const auto T_GB =
        ReadTumTrajectory(source / "groundtruth.txt", "poses of base_link", recording.warnings);
    if (!T_GB) return T_GB.error();
    recording.ground_truth = GroundTruthOfBody(*T_GB, SE3());
  } else {
    recording.warnings.emplace_back("groundtruth.txt is not there: no ground truth in the log");
  }
  return recording;
}

}  // namespace gw::importer
