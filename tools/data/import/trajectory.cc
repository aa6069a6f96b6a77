#include "tools/data/import/trajectory.h"

#include <algorithm>
#include <cmath>

#include "tools/data/import/streams.h"
#include "tools/data/import/text_table.h"

namespace gw::importer {

Result<std::vector<StampedPose>> ReadTumTrajectory(const std::filesystem::path& file,
                                                   const std::string& what,
                                                   std::vector<std::string>& warnings) {
  const Result<TextTable> table = TextTable::Read(file, what);
  if (!table) return table.error();
  std::vector<StampedPose> trajectory;
  for (const TextRow& row : table->rows()) {
    const Result<Utime> utime = row.Seconds(0);
    if (!utime) return utime.error();
    const Result<SE3> pose = row.PoseXyzQxyzw(1);
    if (!pose) return pose.error();
    trajectory.push_back({*utime, *pose});
  }
  MakeOrdered(trajectory, file.filename().string(), warnings);
  return trajectory;
}

std::vector<GroundTruth> GroundTruthOfBody(const std::vector<StampedPose>& T_GS, const SE3& T_BS) {
  const SE3 T_SB = T_BS.inverse();
  std::vector<GroundTruth> out;
  for (const StampedPose& pose : T_GS) {
    GroundTruth truth;
    truth.utime = pose.utime;
    truth.T_GB = pose.T * T_SB;
    out.push_back(truth);
  }
  return out;
}

std::vector<WheelSample> WheelIncrements(const std::vector<StampedPose>& T_OB) {
  std::vector<WheelSample> out;
  for (size_t i = 1; i < T_OB.size(); ++i) {
    const SE3 T_BaBb = T_OB[i - 1].T.inverse() * T_OB[i].T;
    const Eigen::Vector3d x_b = T_BaBb.rotation() * Eigen::Vector3d::UnitX();
    WheelSample sample;
    sample.utime_begin = T_OB[i - 1].utime;
    sample.utime = T_OB[i].utime;
    sample.dx_m = T_BaBb.translation().x();
    sample.dy_m = T_BaBb.translation().y();
    sample.dyaw_rad = std::atan2(x_b.y(), x_b.x());
    out.push_back(sample);
  }
  return out;
}

SE3 PoseAt(const std::vector<StampedPose>& trajectory, Utime utime) {
  const auto after =
      std::lower_bound(trajectory.begin(), trajectory.end(), utime,
                       [](const StampedPose& pose, Utime t) { return pose.utime < t; });
  if (after == trajectory.end()) return trajectory.back().T;
  if (after == trajectory.begin() || after->utime == utime) return after->T;
  const auto before = std::prev(after);
  const double fraction =
      (utime - before->utime).seconds() / (after->utime - before->utime).seconds();
  return Interpolate(before->T, after->T, fraction);
}

}  // namespace gw::importer
