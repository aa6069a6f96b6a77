#include "tools/data/import/cid_sims.h"

#include <algorithm>
#include <cmath>

#include "common/camera/depth_sensors.h"
#include "tools/data/files/faults.h"
#include "tools/data/files/format.h"
#include "tools/data/import/gyro_alignment.h"
#include "tools/data/import/image_list.h"
#include "tools/data/import/imu_check.h"
#include "tools/data/import/sensor_yaml.h"
#include "tools/data/import/stated_size.h"
#include "tools/data/import/streams.h"
#include "tools/data/import/text_table.h"
#include "tools/data/import/trajectory.h"

namespace gw::importer {
namespace {

namespace fs = std::filesystem;

bool Exists(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

Result<fs::path> FindCalibration(const fs::path& source, const CidSimsOptions& options) {
  if (!options.calibration.empty()) return options.calibration;
  const fs::path parent = fs::absolute(source / ".").parent_path().parent_path();
  for (const fs::path& folder : {source, parent}) {
    if (Exists(folder / "calibration.yaml")) return folder / "calibration.yaml";
  }
  return Error{ErrorCode::kNotFound, (source / "calibration.yaml").string() +
                                         ": not there; name the data set's calibration file with "
                                         "--calibration FILE"};
}

Result<std::vector<ImuSample>> ReadImu(const fs::path& file, std::vector<std::string>& warnings) {
  const Result<TextTable> table = TextTable::Read(file, "lines `t wx wy wz ax ay az`");
  if (!table) return table.error();
  std::vector<ImuSample> samples;
  SpoiltRows spoilt;
  const auto read = table->ForEach(warnings, [&](const TextRow& row) -> Result<Done> {
    if (spoilt.Skip(row, 0, 7)) return Done{};
    const Result<Utime> utime = row.Seconds(0);
    if (!utime) return utime.error();
    const Result<std::vector<double>> v = row.Numbers(1, 6);
    if (!v) return v.error();
    ImuSample sample;
    sample.utime = *utime;
    sample.w_I_rad_s = {(*v)[0], (*v)[1], (*v)[2]};
    sample.a_I_m_s2 = {(*v)[3], (*v)[4], (*v)[5]};
    sample.has_accel = true;
    samples.push_back(sample);
    return Done{};
  });
  if (!read) return read.error();
  const Result<Done> good = spoilt.Report(table->rows().size(), warnings);
  if (!good) return good.error();
  OrderImu(samples, file.filename().string(), warnings);
  return samples;
}

// The two meanings differ by twice the (small) rotation of the matrix, so the data decide only when
// the robot turned enough.
SE3 ChooseImuMatrix(const SE3& T_ItoC, ImuMatrix choice, const std::vector<StampedPose>& T_GC,
                    Recording& recording) {
  SE3 inverse = T_ItoC.inverse();
  if (choice == ImuMatrix::kImuToCamera) return T_ItoC;
  if (choice == ImuMatrix::kCameraToImu) return inverse;
  const double offset = recording.calibration.imu.time_offset_s;
  const double named = GyroDisagreement(T_GC, recording.imu, T_ItoC.rotation(), offset);
  const double inverted = GyroDisagreement(T_GC, recording.imu, inverse.rotation(), offset);
  if (named < 0 || inverted < 0) {
    recording.warnings.emplace_back(
        "T_ItoC: too little ground truth and gyro to check its meaning; taken as named (IMU to "
        "camera)");
    return T_ItoC;
  }
  const std::string text = tools::Format(
      "T_ItoC: gyro against true camera rotation differs by %.5f rad/s as named, %.5f "
      "inverted; taken %s",
      named, inverted, inverted < named ? "inverted" : "as named");
  const bool close = std::abs(named - inverted) < 0.01 * std::max(named, inverted);
  if (close) {
    recording.warnings.emplace_back(text);
  } else {
    recording.notes.emplace_back("imu", text);
  }
  return inverted < named ? inverse : T_ItoC;
}

Result<Done> ReadFrames(const fs::path& source, const ReadOptions& options, Recording& recording) {
  Result<std::vector<FrameFiles>> files =
      ReadAssociations(source, "associations.txt", recording.warnings);
  if (!files) return files.error();
  Result<std::unique_ptr<FrameSource>> frames =
      MakeFileFrames(*std::move(files), options, recording);
  if (!frames) return frames.error();
  recording.frames = *std::move(frames);
  return Done{};
}

// The true poses of the camera; empty where there are none.
Result<std::vector<StampedPose>> ReadTruth(const fs::path& source, Recording& recording) {
  const char* const name = Exists(source / "groundtruth.txt") ? "groundtruth.txt" : "pose.txt";
  if (!Exists(source / name)) {
    recording.warnings.emplace_back(
        "neither groundtruth.txt nor pose.txt is there: no ground truth in the log");
    return std::vector<StampedPose>();
  }
  Result<std::vector<StampedPose>> T_GC = ReadTrueTrajectory(
      source / name, "lines `t px py pz qx qy qz qw` of the camera", recording.warnings);
  if (T_GC) {
    recording.ground_truth = GroundTruthOfBody(*T_GC, recording.calibration.camera.T_BC);
  }
  return T_GC;
}

}  // namespace

Result<SE3> ReadCidSimsCalibration(const fs::path& file, const std::string& mount,
                                   Recording& recording) {
  const Result<SensorYaml> read = SensorYaml::Read(file, "the CID-SIMS calibration");
  if (!read) return read.error();
  const SensorYaml& yaml = *read;
  CameraCalibration& camera = recording.calibration.camera;
  const Result<std::vector<double>> k = yaml.Numbers("cam_k", 4);
  if (!k) return k.error();
  const Result<std::vector<double>> d = yaml.Numbers("cam_d", 4);
  if (!d) return d.error();
  const Result<double> depth_factor = yaml.Number("depth_factor");
  if (!depth_factor) return depth_factor.error();
  if (*depth_factor <= 0) return yaml.BadData("depth_factor", "must be positive");
  camera.kind = CameraKind::kRgbd;
  camera.left = {(*k)[0], (*k)[1], (*k)[2], (*k)[3], {}};
  std::copy(d->begin(), d->end(), camera.left.radtan.begin());
  camera.depth_unit_m = 1.0 / *depth_factor;
  SetDepthSensor(kRealSenseD455, &camera);

  const Result<double> width = yaml.Number("cam_width");
  if (!width) return width.error();
  const Result<double> height = yaml.Number("cam_height");
  if (!height) return height.error();
  camera.width = static_cast<int>(*width);
  camera.height = static_cast<int>(*height);
  if (yaml.Has("T_DtoC")) {
    const Result<SE3> T_CD = yaml.Pose("T_DtoC", recording.warnings);
    if (!T_CD) return T_CD.error();
    if (T_CD->Log().norm() > 1e-6) {
      recording.warnings.emplace_back(
          "T_DtoC is not the identity: depth images that are not aligned to the colour camera give "
          "wrong landmarks; align them first");
    }
  }

  if (mount != "high" && mount != "low") {
    return Error{ErrorCode::kInvalidArgument,
                 "--mount high|low is needed: the calibration holds two camera mountings, and only "
                 "the data set's page says which one a sequence has"};
  }
  const Result<SE3> T_BC = yaml.Pose(mount == "high" ? "T_CHtoW" : "T_CLtoW", recording.warnings);
  if (!T_BC) return T_BC.error();
  camera.T_BC = *T_BC;
  recording.notes.emplace_back("camera", "mounting: " + mount);

  ImuCalibration& imu = recording.calibration.imu;
  for (const auto& [key, value] :
       {std::pair{"gyroscope_noise_density", &imu.gyro_noise},
        {"gyroscope_random_walk", &imu.gyro_walk},
        {"accelerometer_noise_density", &imu.accel_noise},
        {"accelerometer_random_walk", &imu.accel_walk},
        {"timeshift_CtoI", &imu.time_offset_s},
        {"wheel_baseline", &recording.calibration.wheel.track_width_m}}) {
    const Result<double> number = yaml.Number(key);
    if (!number) return number.error();
    *value = *number;
  }
  return yaml.Pose("T_ItoC", recording.warnings);
}

void SetImuPose(const SE3& T_ItoC, ImuMatrix choice, const std::vector<StampedPose>& T_GC,
                Recording& recording) {
  const SE3 T_CI = ChooseImuMatrix(T_ItoC, choice, T_GC, recording);
  recording.calibration.imu.T_BI = recording.calibration.camera.T_BC * T_CI;
}

Result<Recording> ReadCidSims(const fs::path& source, const CidSimsOptions& options) {
  Recording recording;
  recording.format = "cid-sims";
  recording.name = FolderName(source);
  const Result<fs::path> calibration_file = FindCalibration(source, options);
  if (!calibration_file) return calibration_file.error();
  const Result<SE3> T_ItoC = ReadCidSimsCalibration(*calibration_file, options.mount, recording);
  if (!T_ItoC) return T_ItoC.error();
  CameraCalibration& camera = recording.calibration.camera;
  const int stated_width = camera.width;
  const int stated_height = camera.height;

  tools::Faults faults;
  faults.Passed(ReadFrames(source, options, recording));
  if (recording.frames) {
    faults.Passed(FitStatedSize(stated_width, stated_height, calibration_file->string(), camera,
                                &camera.left, recording.warnings));
  }
  const auto T_GC = ReadTruth(source, recording);
  faults.Passed(T_GC);
  if (Exists(source / "imu.txt")) {
    Result<std::vector<ImuSample>> imu = ReadImu(source / "imu.txt", recording.warnings);
    if (faults.Passed(imu)) recording.imu = *std::move(imu);
  } else {
    recording.warnings.emplace_back("imu.txt is not there: no IMU in the log");
  }
  if (Exists(source / "odom.txt")) {
    const Result<std::vector<StampedPose>> odometry =
        ReadTumTrajectory(source / "odom.txt", "lines `t px py pz qx qy qz qw vx vy vz wx wy wz`",
                          recording.warnings);
    if (faults.Passed(odometry)) recording.wheel = WheelIncrements(*odometry);
  } else {
    recording.warnings.emplace_back("odom.txt is not there: no wheel odometry in the log");
  }
  if (!faults.empty()) return faults.error();
  if (!recording.imu.empty()) SetImuPose(*T_ItoC, options.imu_matrix, *T_GC, recording);
  return recording;
}

}  // namespace gw::importer
