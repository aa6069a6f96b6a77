#include "tools/data/import/euroc.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <tuple>

#include "tools/data/files/faults.h"
#include "tools/data/import/body_frame.h"
#include "tools/data/import/image_list.h"
#include "tools/data/import/imu_check.h"
#include "tools/data/import/sensor_yaml.h"
#include "tools/data/import/stated_size.h"
#include "tools/data/import/stereo_range.h"
#include "tools/data/import/streams.h"
#include "tools/data/import/text_table.h"
#include "tools/data/import/trajectory.h"
#include "tools/data/import/undistorted_frames.h"

namespace gw::importer {
namespace {

namespace fs = std::filesystem;

bool Exists(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

struct Eye {
  PinholeIntrinsics intrinsics;
  SE3 T_BC;
  std::vector<double> resolution;  // width, height that the intrinsics are stated for; or empty
  std::vector<double> fisheye;     // k1 k2 k3 k4 of an equidistant lens; or empty
};

// An equidistant lens makes an image of the same focal length without distortion; the front-end
// knows no other. Empty for other lenses.
Result<std::optional<Undistorter>> UndistorterOf(const Eye& eye, const fs::path& file,
                                                 const CameraCalibration& camera) {
  if (eye.fisheye.empty()) return std::optional<Undistorter>();
  if (!eye.resolution.empty() &&
      (eye.resolution[0] != camera.width || eye.resolution[1] != camera.height)) {
    return Error{ErrorCode::kBadData,
                 file.string() +
                     ": resolution is not that of the images; calibrate the fisheye lens in the "
                     "images' own size"};
  }
  RosCameraInfo info;
  info.width = camera.width;
  info.height = camera.height;
  info.model = "equidistant";
  info.D = eye.fisheye;
  const PinholeIntrinsics& k = eye.intrinsics;
  info.K = {k.fx, 0, k.cx, 0, k.fy, k.cy, 0, 0, 1};
  return std::optional<Undistorter>(std::in_place, info, k, Eigen::Matrix3d::Identity());
}

Result<Done> UndistortFisheyes(const fs::path& mav, const Eye& left, const Eye& right,
                               Recording& recording) {
  if (left.fisheye.empty() && right.fisheye.empty()) return Done{};
  const CameraCalibration& camera = recording.calibration.camera;
  auto left_lens = UndistorterOf(left, mav / "cam0" / "sensor.yaml", camera);
  auto right_lens = UndistorterOf(right, mav / "cam1" / "sensor.yaml", camera);
  tools::Faults faults;
  faults.Passed(left_lens);
  faults.Passed(right_lens);
  if (!faults.empty()) return faults.error();
  recording.frames =
      UndistortFrames(std::move(recording.frames), *std::move(left_lens), *std::move(right_lens));
  recording.notes.emplace_back("camera", "equidistant lens, undistorted on import");
  return Done{};
}

Result<Eye> ReadEye(const fs::path& file, std::vector<std::string>& warnings) {
  const Result<SensorYaml> yaml = SensorYaml::Read(file, "the calibration of a camera");
  if (!yaml) return yaml.error();
  if (yaml->Has("camera_model")) {
    const Result<std::string> projection = yaml->Text("camera_model");
    if (!projection) return projection.error();
    if (*projection != "pinhole") {
      return yaml->BadData("camera_model",
                           "is '" + *projection + "'; only pinhole can be imported");
    }
  }
  const Result<std::string> model = yaml->Text("distortion_model");
  if (!model) return model.error();
  const bool fisheye = *model == "equidistant";
  if (*model != "radial-tangential" && !fisheye) {
    return yaml->BadData("distortion_model",
                         "is '" + *model + "'; radial-tangential and equidistant can be imported");
  }
  const Result<std::vector<double>> focal = yaml->Numbers("intrinsics", 4);
  if (!focal) return focal.error();
  if ((*focal)[0] <= 0 || (*focal)[1] <= 0) {
    return yaml->BadData("intrinsics", "holds fx or fy that is not positive (fx, fy, cx, cy)");
  }
  const Result<std::vector<double>> distortion = yaml->Numbers("distortion_coefficients", 0);
  if (!distortion) return distortion.error();
  if (distortion->size() < 4 || distortion->size() > (fisheye ? 4 : 5)) {
    return yaml->BadData(
        "distortion_coefficients",
        fisheye ? "must hold k1, k2, k3, k4" : "must hold k1, k2, p1, p2 and perhaps k3");
  }
  const Result<SE3> T_BC = yaml->Pose("T_BS", warnings);
  if (!T_BC) return T_BC.error();
  Eye eye{{(*focal)[0], (*focal)[1], (*focal)[2], (*focal)[3], {}}, *T_BC, {}, {}};
  if (yaml->Has("resolution")) {
    const Result<std::vector<double>> resolution = yaml->Numbers("resolution", 2);
    if (!resolution) return resolution.error();
    eye.resolution = *resolution;
  }
  if (fisheye) {
    eye.fisheye = *distortion;
  } else {
    std::copy(distortion->begin(), distortion->end(), eye.intrinsics.radtan.begin());
  }
  return eye;
}

struct ImageEntry {
  fs::path file;
  std::string listed_at;
};

// The folder of the images. A checkout that cannot make symbolic links leaves a small text file in
// place of one, which holds the path it should lead to.
fs::path ImageFolder(const fs::path& camera) {
  fs::path data = camera / "data";
  std::error_code ignored;
  if (!fs::is_regular_file(data, ignored)) return data;
  std::string target;
  std::getline(std::ifstream(data), target);
  return fs::is_directory(camera / target, ignored) ? camera / target : data;
}

Result<std::map<int64_t, ImageEntry>> ReadCameraList(const fs::path& camera,
                                                     std::vector<std::string>& warnings) {
  const Result<TextTable> table =
      TextTable::Read(camera / "data.csv", "lines `timestamp_ns,filename` of a camera");
  if (!table) return table.error();
  const fs::path folder = ImageFolder(camera);
  std::map<int64_t, ImageEntry> list;
  const auto read = table->ForEach(warnings, [&](const TextRow& row) -> Result<Done> {
    const Result<int64_t> ns = row.Nanoseconds(0);
    if (!ns) return ns.error();
    if (row.size() < 2) return row.BadData("the file name is missing");
    list.emplace(*ns, ImageEntry{ListedFile(folder, row), row.place()});
    return Done{};
  });
  if (!read) return read.error();
  if (2 * list.size() < table->rows().size()) {
    return Error{ErrorCode::kBadData,
                 table->file().string() + ": " +
                     std::to_string(table->rows().size() - list.size()) + " of " +
                     std::to_string(table->rows().size()) +
                     " lines repeat a time; did the times lose digits when they were written?"};
  }
  return list;
}

std::vector<FrameFiles> PairImages(const std::map<int64_t, ImageEntry>& left,
                                   const std::map<int64_t, ImageEntry>& right,
                                   std::vector<std::string>& warnings) {
  std::vector<Utime> left_times, right_times;
  std::vector<const ImageEntry*> left_entries, right_entries;
  for (const auto& [ns, entry] : left) {
    left_times.push_back(UtimeFromNanoseconds(ns));
    left_entries.push_back(&entry);
  }
  for (const auto& [ns, entry] : right) {
    right_times.push_back(UtimeFromNanoseconds(ns));
    right_entries.push_back(&entry);
  }
  std::vector<FrameFiles> files;
  for (const auto& [i, j] : PairEyes(left_times, right_times, warnings)) {
    files.push_back({left_times[i],
                     left_entries[i]->file,
                     right_entries[j]->file,
                     {},
                     left_entries[i]->listed_at});
  }
  return files;
}

Result<Done> ReadCameras(const fs::path& mav, const ReadOptions& options, Recording& recording) {
  if (!Exists(mav / "cam1")) {
    return Error{ErrorCode::kNotFound,
                 (mav / "cam1").string() + ": not there; only stereo recordings can be imported"};
  }
  tools::Faults faults;
  const Result<Eye> left = ReadEye(mav / "cam0" / "sensor.yaml", recording.warnings);
  const Result<Eye> right = ReadEye(mav / "cam1" / "sensor.yaml", recording.warnings);
  const auto left_images = ReadCameraList(mav / "cam0", recording.warnings);
  const auto right_images = ReadCameraList(mav / "cam1", recording.warnings);
  faults.Passed(left);
  faults.Passed(right);
  faults.Passed(left_images);
  faults.Passed(right_images);
  if (!faults.empty()) return faults.error();
  CameraCalibration& camera = recording.calibration.camera;
  camera.kind = CameraKind::kStereo;
  camera.left = left->intrinsics;
  camera.right = right->intrinsics;
  camera.T_BC = left->T_BC;
  camera.T_C0C1 = left->T_BC.inverse() * right->T_BC;
  std::vector<FrameFiles> files = PairImages(*left_images, *right_images, recording.warnings);
  if (files.empty()) {
    return Error{ErrorCode::kBadData, (mav / "cam1" / "data.csv").string() +
                                          ": no stamp is near one of cam0 (within a quarter of a "
                                          "frame's time); are both eyes on one clock?"};
  }
  const size_t unpaired = left_images->size() + right_images->size() - 2 * files.size();
  if (unpaired > 0) {
    recording.warnings.push_back(std::to_string(unpaired) +
                                 " images have no partner in time; left out");
  }
  Result<std::unique_ptr<FrameSource>> frames =
      MakeFileFrames(std::move(files), options, recording);
  if (!frames) return frames.error();
  recording.frames = *std::move(frames);
  for (const auto& [name, eye, intrinsics] :
       {std::tuple{"cam0", &*left, &camera.left}, {"cam1", &*right, &camera.right}}) {
    if (eye->resolution.empty() || !eye->fisheye.empty()) continue;
    const Result<Done> fits =
        FitStatedSize(eye->resolution[0], eye->resolution[1], (mav / name / "sensor.yaml").string(),
                      camera, intrinsics, recording.warnings);
    if (!fits) return fits.error();
  }
  SetStereoRange(camera);
  return UndistortFisheyes(mav, *left, *right, recording);
}

Result<Done> ReadImu(const fs::path& folder, Recording& recording) {
  const Result<SensorYaml> yaml = SensorYaml::Read(folder / "sensor.yaml", "the IMU's calibration");
  if (!yaml) return yaml.error();
  ImuCalibration& imu = recording.calibration.imu;
  const Result<SE3> T_BI = yaml->Pose("T_BS", recording.warnings);
  if (!T_BI) return T_BI.error();
  imu.present = true;
  imu.T_BI = *T_BI;
  for (const auto& [key, value] : {std::pair{"rate_hz", &imu.rate_hz},
                                   {"gyroscope_noise_density", &imu.gyro_noise},
                                   {"gyroscope_random_walk", &imu.gyro_walk},
                                   {"accelerometer_noise_density", &imu.accel_noise},
                                   {"accelerometer_random_walk", &imu.accel_walk}}) {
    const Result<double> number = yaml->Number(key);
    if (!number) return number.error();
    *value = *number;
  }
  const Result<TextTable> table =
      TextTable::Read(folder / "data.csv", "lines `timestamp_ns,wx,wy,wz,ax,ay,az`");
  if (!table) return table.error();
  SpoiltRows spoilt;
  const auto read = table->ForEach(recording.warnings, [&](const TextRow& row) -> Result<Done> {
    if (spoilt.Skip(row, 0, 7)) return Done{};
    const Result<int64_t> ns = row.Nanoseconds(0);
    if (!ns) return ns.error();
    const Result<std::vector<double>> v = row.Numbers(1, 6);
    if (!v) return v.error();
    ImuSample sample;
    sample.utime = UtimeFromNanoseconds(*ns);
    sample.w_I_rad_s = {(*v)[0], (*v)[1], (*v)[2]};
    sample.a_I_m_s2 = {(*v)[3], (*v)[4], (*v)[5]};
    sample.has_accel = true;
    recording.imu.push_back(sample);
    return Done{};
  });
  if (!read) return read.error();
  OrderImu(recording.imu, "imu0/data.csv", recording.warnings);
  return spoilt.Report(table->rows().size(), recording.warnings);
}

// Track and ticks, where they are stated (none of them is in ASL's own format).
Result<Done> ReadBase(const SensorYaml& yaml, WheelCalibration& wheel) {
  double radius_m = 0;
  double ticks_per_turn = 0;
  for (const auto& [key, value] : {std::pair{"wheel_base", &wheel.track_width_m},
                                   {"wheel_radius", &radius_m},
                                   {"ticks_per_rev", &ticks_per_turn}}) {
    if (!yaml.Has(key)) continue;
    const Result<double> number = yaml.Number(key);
    if (!number) return number.error();
    if (*number <= 0) return yaml.BadData(key, "must be positive");
    *value = *number;
  }
  if (radius_m > 0 && ticks_per_turn > 0) {
    wheel.ticks_per_metre = ticks_per_turn / (2 * M_PI * radius_m);
  }
  return Done{};
}

// Takes the wheels' frame as the body, and what else is stated about the base.
Result<Done> UseWheelFrame(const fs::path& file, Recording& recording) {
  if (Exists(file)) {
    const Result<SensorYaml> yaml = SensorYaml::Read(file, "the wheels' frame");
    if (!yaml) return yaml.error();
    const Result<Done> base = ReadBase(*yaml, recording.calibration.wheel);
    if (!base) return base.error();
    if (yaml->Has("T_BS")) {
      const Result<SE3> T_BN = yaml->Pose("T_BS", recording.warnings);
      if (!T_BN) return T_BN.error();
      MoveBodyToWheels(*T_BN, recording);
      recording.notes.emplace_back(
          "body",
          "the wheels' frame (T_BS of odom0/sensor.yaml); cameras, IMU and ground truth are "
          "expressed in it");
      return Done{};
    }
  }
  recording.warnings.emplace_back(
      "odom0: the wheels' frame is not stated (T_BS in odom0/sensor.yaml); taken as the data set's "
      "body, with x forward and z up. If it is another, dead reckoning is wrong");
  return Done{};
}

Result<Done> ReadWheels(const fs::path& folder, Recording& recording) {
  const Result<TextTable> table =
      TextTable::Read(folder / "data.csv", "lines `t_ns,x_m,y_m,yaw_rad,v_mps,w_radps`");
  if (!table) return table.error();
  std::vector<StampedPose> T_OB;
  SpoiltRows spoilt;
  const auto read = table->ForEach(recording.warnings, [&](const TextRow& row) -> Result<Done> {
    if (spoilt.Skip(row, 0, 4)) return Done{};
    const Result<int64_t> ns = row.Nanoseconds(0);
    if (!ns) return ns.error();
    const Result<std::vector<double>> v = row.Numbers(1, 3);
    if (!v) return v.error();
    T_OB.push_back(
        {UtimeFromNanoseconds(*ns), SE3(ExpSO3({0, 0, (*v)[2]}), {(*v)[0], (*v)[1], 0})});
    return Done{};
  });
  if (!read) return read.error();
  Result<Done> good = spoilt.Report(table->rows().size(), recording.warnings);
  if (good) good = MakeOrdered(T_OB, "odom0/data.csv", recording.warnings);
  recording.wheel = WheelIncrements(T_OB);
  return good;
}

Result<Done> ReadGroundTruth(const fs::path& folder, Recording& recording) {
  SE3 T_BS;
  if (Exists(folder / "sensor.yaml")) {
    const Result<SensorYaml> yaml =
        SensorYaml::Read(folder / "sensor.yaml", "the frame of the ground truth");
    if (!yaml) return yaml.error();
    const Result<SE3> stated = yaml->Pose("T_BS", recording.warnings);
    if (!stated) return stated.error();
    T_BS = *stated;
  }
  const Result<TextTable> table =
      TextTable::Read(folder / "data.csv", "lines `timestamp_ns,px,py,pz,qw,qx,qy,qz,...`");
  if (!table) return table.error();
  std::vector<StampedPose> T_GS;
  SpoiltRows spoilt;
  const auto read = table->ForEach(recording.warnings, [&](const TextRow& row) -> Result<Done> {
    if (spoilt.Skip(row, 0, 8)) return Done{};
    const Result<int64_t> ns = row.Nanoseconds(0);
    if (!ns) return ns.error();
    const Result<std::vector<double>> v = row.Numbers(1, 7);
    if (!v) return v.error();
    const Eigen::Quaterniond q((*v)[3], (*v)[4], (*v)[5], (*v)[6]);
    if (std::abs(q.norm() - 1) > 0.05) {
      spoilt.Add(row, "the quaternion's norm is not 1");
      return Done{};
    }
    T_GS.push_back({UtimeFromNanoseconds(*ns), SE3(q, {(*v)[0], (*v)[1], (*v)[2]})});
    return Done{};
  });
  if (!read) return read.error();
  Result<Done> good = spoilt.Report(table->rows().size(), recording.warnings);
  if (good) {
    good = MakeOrdered(T_GS, folder.filename().string() + "/data.csv", recording.warnings);
  }
  if (!good) {
    recording.warnings.push_back(good.error().message + ": no ground truth in the log");
    return Done{};
  }
  recording.ground_truth = GroundTruthOfBody(T_GS, T_BS);
  return Done{};
}

}  // namespace

Result<Recording> ReadEuroc(const fs::path& source, const ReadOptions& options) {
  const fs::path mav = Exists(source / "mav0") ? source / "mav0" : source;
  if (!Exists(mav / "cam0")) {
    return Error{ErrorCode::kNotFound, source.string() +
                                           ": holds neither mav0/cam0 nor cam0; name the folder "
                                           "that holds mav0"};
  }
  Recording recording;
  recording.format = "euroc";
  recording.name = FolderName(source);
  tools::Faults faults;
  faults.Passed(ReadCameras(mav, options, recording));
  if (Exists(mav / "imu0")) {
    faults.Passed(ReadImu(mav / "imu0", recording));
  } else {
    recording.warnings.emplace_back("imu0 is not there: no IMU in the log");
  }
  if (Exists(mav / "state_groundtruth_estimate0")) {
    faults.Passed(ReadGroundTruth(mav / "state_groundtruth_estimate0", recording));
  } else {
    recording.warnings.emplace_back(
        "state_groundtruth_estimate0 is not there: no ground truth in the log");
  }
  if (Exists(mav / "odom0") && faults.Passed(ReadWheels(mav / "odom0", recording))) {
    faults.Passed(UseWheelFrame(mav / "odom0" / "sensor.yaml", recording));
  }
  if (!faults.empty()) return faults.error();
  recording.notes.emplace_back(
      "calibration",
      "images are not rectified; the calibration holds distortion and the pose between the eyes");
  recording.notes.emplace_back("licence", "as the data set's (EuRoC MAV); cite Burri et al. 2016");
  return recording;
}

}  // namespace gw::importer
