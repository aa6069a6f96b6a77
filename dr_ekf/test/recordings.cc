#include "dr_ekf/test/recordings.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>

namespace gw::dr_ekf {
namespace {

namespace fs = std::filesystem;

// Rows of numbers, separated by blanks or commas; lines that begin with # are left out.
std::vector<std::vector<double>> ReadTable(const fs::path& file) {
  std::vector<std::vector<double>> out;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream fields(line);
    std::vector<double> row;
    for (double value; fields >> value;) row.push_back(value);
    out.push_back(std::move(row));
  }
  return out;
}

// trans_matrix.yaml: parent_frame, child_frame and a 4x4 matrix, again and again; by child.
std::map<std::string, SE3> ReadTransforms(const fs::path& file) {
  std::map<std::string, SE3> out;
  std::ifstream in(file);
  std::string child;
  for (std::string line; std::getline(in, line);) {
    if (const size_t at = line.find("child_frame: "); at != std::string::npos) {
      child = line.substr(at + 13);
    }
    const size_t open = line.find("data: [");
    if (open == std::string::npos) continue;
    std::string numbers = line.substr(open + 7);
    std::replace_if(
        numbers.begin(), numbers.end(), [](char c) { return c == ',' || c == ']'; }, ' ');
    std::istringstream fields(numbers);
    Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
    for (int i = 0; i < 16; ++i) fields >> T(i / 4, i % 4);
    const Eigen::Matrix3d R = T.topLeftCorner<3, 3>();
    out[child] = SE3(Eigen::Quaterniond(R).normalized(), T.topRightCorner<3, 1>());
  }
  return out;
}

WheelSample Roll(Utime begin, Utime end, int64_t seq, double left, double right, double track) {
  WheelSample s;
  s.utime_begin = begin;
  s.utime = end;
  s.seq = seq;
  s.dyaw_rad = (right - left) / track;
  s.dx_m = 0.5 * (left + right) * std::cos(0.5 * s.dyaw_rad);
  s.dy_m = 0.5 * (left + right) * std::sin(0.5 * s.dyaw_rad);
  return s;
}

Utime TimeOf(const Sample& sample) {
  return std::visit([](const auto& s) { return s.utime; }, sample);
}

// The wheels' samples become a part of the drive: their sum, and all samples in order of time.
void AddWheels(const std::vector<WheelSample>& wheels, RealDrive* drive) {
  drive->raw = SumOf(wheels);
  drive->samples.insert(drive->samples.end(), wheels.begin(), wheels.end());
  std::stable_sort(drive->samples.begin(), drive->samples.end(),
                   [](const Sample& a, const Sample& b) { return TimeOf(a) < TimeOf(b); });
}

}  // namespace

std::optional<fs::path> FindRecording(const std::string& name) {
  const char* shared = std::getenv("GW_SHARED_DIR");
  const fs::path base =
      shared != nullptr ? fs::path(shared) : fs::path(GW_SOURCE_DIR) / "../shared";
  const fs::path folder = base / "data" / name;
  if (!fs::exists(folder)) return std::nullopt;
  return folder;
}

std::vector<StampedPose> ReadPoses(const fs::path& file) {
  std::vector<StampedPose> out;
  for (const std::vector<double>& r : ReadTable(file)) {
    if (r.size() < 8) continue;
    out.push_back(
        {UtimeFromSeconds(r[0]),
         SE3(Eigen::Quaterniond(r[7], r[4], r[5], r[6]).normalized(), {r[1], r[2], r[3]})});
  }
  return out;
}

std::vector<WheelSample> WheelsFromPoses(const std::vector<StampedPose>& poses) {
  std::vector<WheelSample> out;
  for (size_t i = 1; i < poses.size(); ++i) {
    const SE3 step = poses[i - 1].T.inverse() * poses[i].T;
    WheelSample s;
    s.utime_begin = poses[i - 1].utime;
    s.utime = poses[i].utime;
    s.seq = static_cast<int64_t>(i);
    s.dx_m = step.translation().x();
    s.dy_m = step.translation().y();
    s.dyaw_rad = LogSO3(step.rotation()).z();
    out.push_back(s);
  }
  return out;
}

std::vector<StampedPose> SumOf(const std::vector<WheelSample>& wheels) {
  std::vector<StampedPose> out;
  SE3 T;
  for (const WheelSample& s : wheels) {
    if (out.empty()) out.push_back({s.utime_begin, T});
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(s.dyaw_rad, Eigen::Vector3d::UnitZ()));
    T = T * SE3(turn, {s.dx_m, s.dy_m, 0});
    out.push_back({s.utime, T});
  }
  return out;
}

RealDrive ReadOdometryAlone(const fs::path& folder, const std::string& odometry,
                            const std::string& reference) {
  RealDrive drive;
  drive.calibration.wheel.present = true;
  drive.calibration.wheel.rate_hz = 20;
  AddWheels(WheelsFromPoses(ReadPoses(folder / odometry)), &drive);
  drive.truth = ReadPoses(folder / reference);
  return drive;
}

RealDrive ReadRendered(const fs::path& folder, RenderedWheels wheels) {
  RealDrive drive;
  drive.truth = ReadPoses(folder / "groundtruth.txt");
  const auto transforms = ReadTransforms(folder / "trans_matrix.yaml");

  ImuCalibration& imu = drive.calibration.imu;  // sensors.yaml
  imu.present = true;
  imu.rate_hz = 200;
  imu.T_BI = transforms.at("d400_color_optical_frame") * transforms.at("d400_gyroscope");
  imu.gyro_noise = 2.4e-4;
  imu.gyro_walk = 2e-5;
  imu.accel_noise = 2e-3;
  imu.accel_walk = 3e-4;
  const auto gyro = ReadTable(folder / "d400_gyroscope.txt");
  const auto accel = ReadTable(folder / "d400_accelerometer.txt");
  for (size_t i = 0; i < std::min(gyro.size(), accel.size()); ++i) {
    ImuSample s;
    s.utime = UtimeFromSeconds(gyro[i][0]);
    s.seq = static_cast<int64_t>(i);
    s.has_accel = true;
    s.w_I_rad_s = {gyro[i][1], gyro[i][2], gyro[i][3]};
    s.a_I_m_s2 = {accel[i][1], accel[i][2], accel[i][3]};
    drive.samples.push_back(s);
  }

  WheelCalibration& base = drive.calibration.wheel;  // encoder.txt
  base.present = true;
  base.track_width_m = 0.23;
  base.ticks_per_metre = 2578.33 / (2 * M_PI * 0.035);
  if (wheels == RenderedWheels::kOdometry) {
    base.rate_hz = 20;
    AddWheels(WheelsFromPoses(ReadPoses(folder / "odom.txt")), &drive);
    return drive;
  }
  base.rate_hz = 50;
  std::vector<WheelSample> samples;
  const auto ticks = ReadTable(folder / "encoder.txt");
  for (size_t i = 1; i < ticks.size(); ++i) {
    samples.push_back(
        Roll(UtimeFromSeconds(ticks[i - 1][0]), UtimeFromSeconds(ticks[i][0]),
             static_cast<int64_t>(i), (ticks[i][1] - ticks[i - 1][1]) / base.ticks_per_metre,
             (ticks[i][2] - ticks[i - 1][2]) / base.ticks_per_metre, base.track_width_m));
    samples.back().has_ticks = true;
    samples.back().left_ticks = static_cast<uint16_t>(static_cast<int64_t>(ticks[i][1]));
    samples.back().right_ticks = static_cast<uint16_t>(static_cast<int64_t>(ticks[i][2]));
  }
  AddWheels(samples, &drive);
  return drive;
}

RealDrive ReadSkidSteer(const fs::path& folder, const SkidSteerOptions& options) {
  constexpr double kMetresPerCount = 0.0022;
  RealDrive drive;
  ImuCalibration& imu = drive.calibration.imu;
  imu.present = true;
  imu.has_accel = options.accelerometer;
  imu.rate_hz = 100;
  int64_t seq = 0;
  for (const std::vector<double>& r : ReadTable(folder / "imu.csv")) {
    ImuSample s;
    s.utime = UtimeFromSeconds(r[0]);
    s.seq = ++seq;
    s.w_I_rad_s = {r[1], r[2], r[3]};
    s.has_accel = options.accelerometer;
    s.a_I_m_s2 = options.accel_unit_m_s2 * Eigen::Vector3d(r[4], r[5], r[6]);
    drive.samples.push_back(s);
  }
  WheelCalibration& base = drive.calibration.wheel;
  base.present = true;
  base.rate_hz = 40;
  base.track_width_m = options.track_m;
  base.ticks_per_metre = 1 / kMetresPerCount;
  std::vector<WheelSample> samples;
  const auto rows = ReadTable(folder / "encoders.csv");  // front right, front left, rear right, ...
  for (size_t i = 1; i < rows.size(); ++i) {
    const std::vector<double>& r = rows[i];
    samples.push_back(Roll(UtimeFromSeconds(rows[i - 1][0]), UtimeFromSeconds(r[0]),
                           static_cast<int64_t>(i), 0.5 * (r[2] + r[4]) * kMetresPerCount,
                           0.5 * (r[1] + r[3]) * kMetresPerCount, options.track_m));
  }
  AddWheels(samples, &drive);
  return drive;
}

}  // namespace gw::dr_ekf
