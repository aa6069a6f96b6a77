#include "tools/data/import/gyro_alignment.h"

#include <algorithm>
#include <cmath>

namespace gw::importer {

double GyroDisagreement(const std::vector<StampedPose>& T_GC, const std::vector<ImuSample>& imu,
                        const Eigen::Quaterniond& R_CI, double time_offset_s) {
  constexpr DurationUs kStep = {100000};
  const DurationUs offset = DurationFromSeconds(time_offset_s);
  std::vector<Eigen::Vector3d> differences;
  size_t a = 0;
  for (size_t b = 1; b < T_GC.size(); ++b) {
    const DurationUs dt = T_GC[b].utime - T_GC[a].utime;
    if (dt < kStep) continue;
    const auto at = [&](Utime camera_time) {
      return std::lower_bound(imu.begin(), imu.end(), camera_time + offset,
                              [](const ImuSample& s, Utime t) { return s.utime < t; });
    };
    const auto begin = at(T_GC[a].utime);
    const auto end = at(T_GC[b].utime);
    if (dt.us < 3 * kStep.us && end - begin >= 3) {
      Eigen::Vector3d mean = Eigen::Vector3d::Zero();
      for (auto it = begin; it != end; ++it) mean += it->w_I_rad_s;
      mean /= static_cast<double>(end - begin);
      const Eigen::Vector3d truth =
          LogSO3(T_GC[a].T.rotation().conjugate() * T_GC[b].T.rotation()) / dt.seconds();
      differences.emplace_back(truth - R_CI * mean);
    }
    a = b;
  }
  if (differences.size() < 10) return -1;
  Eigen::Vector3d bias = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& d : differences) bias += d;
  bias /= static_cast<double>(differences.size());
  double sum = 0;
  for (const Eigen::Vector3d& d : differences) sum += (d - bias).squaredNorm();
  return std::sqrt(sum / static_cast<double>(differences.size()));
}

}  // namespace gw::importer
