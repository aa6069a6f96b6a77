#include "tools/data/import/odometry.h"

#include "tools/data/files/faults.h"
#include "tools/data/import/imu_check.h"
#include "tools/data/import/nominal_camera.h"
#include "tools/data/import/text_table.h"
#include "tools/data/import/trajectory.h"

namespace gw::importer {
namespace {

Result<Done> ReadImu(const OdometryOptions& options, Recording& recording) {
  const bool accel_first = options.imu_columns == ImuColumns::kAccelGyro;
  const Result<TextTable> table =
      TextTable::Read(options.imu, accel_first ? "lines `t ax ay az wx wy wz`"
                                               : "lines `t wx wy wz` or `t wx wy wz ax ay az`");
  if (!table) return table.error();
  SpoiltRows spoilt;
  const auto read = table->ForEach(recording.warnings, [&](const TextRow& row) -> Result<Done> {
    const bool has_accel = accel_first || row.size() > 4;
    const size_t columns = has_accel ? 6 : 3;
    if (spoilt.Skip(row, 0, columns + 1)) return Done{};
    const Result<Utime> utime = row.Seconds(0);
    if (!utime) return utime.error();
    const Result<std::vector<double>> v = row.Numbers(1, columns);
    if (!v) return v.error();
    const auto vector = [&](size_t at) {
      return Eigen::Vector3d((*v)[at], (*v)[at + 1], (*v)[at + 2]);
    };
    ImuSample sample;
    sample.utime = *utime;
    sample.has_accel = has_accel;
    sample.w_I_rad_s = vector(accel_first ? 3 : 0);
    if (has_accel) sample.a_I_m_s2 = vector(accel_first ? 0 : 3);
    recording.imu.push_back(sample);
    return Done{};
  });
  if (!read) return read.error();
  Result<Done> good = spoilt.Report(table->rows().size(), recording.warnings);
  if (good) OrderImu(recording.imu, options.imu.filename().string(), recording.warnings);
  recording.notes.emplace_back(
      "imu", "axes taken as the body's (x forward, y left, z up); noise densities are defaults");
  return good;
}

}  // namespace

Result<Recording> ReadOdometry(const std::filesystem::path& source,
                               const OdometryOptions& options) {
  Recording recording;
  recording.format = "odometry";
  recording.name = FolderName(std::filesystem::absolute(source).parent_path());
  SetNominalCamera("odometry alone", recording);
  tools::Faults faults;
  const auto T_OB =
      ReadTumTrajectory(source, "lines `t x y z qx qy qz qw` of odometry", recording.warnings);
  if (faults.Passed(T_OB)) {
    recording.wheel = WheelIncrements(*T_OB);
    if (recording.wheel.empty()) {
      faults.Add({ErrorCode::kBadData,
                  source.string() + ": holds a single pose; increments need at least two"});
    }
  }
  recording.notes.emplace_back("wheel",
                               "increments between the poses of " + source.filename().string());
  if (!options.imu.empty()) faults.Passed(ReadImu(options, recording));
  if (!options.ground_truth.empty()) {
    const auto T_GB = ReadTrueTrajectory(
        options.ground_truth, "lines `t x y z qx qy qz qw` of the body", recording.warnings);
    if (faults.Passed(T_GB)) recording.ground_truth = GroundTruthOfBody(*T_GB, SE3());
  }
  if (!faults.empty()) return faults.error();
  return recording;
}

}  // namespace gw::importer
