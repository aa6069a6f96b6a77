#include "dr_ekf/test/drive_report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace gw::dr_ekf {
namespace {

double DegOf(double rad) {
  return rad * 180 / M_PI;
}

}  // namespace

double PlanarApe(const std::vector<StampedPose>& reference,
                 const std::vector<StampedPose>& estimate) {
  std::vector<Eigen::Vector2d> ref, est;
  size_t i = 0;
  for (const StampedPose& r : reference) {
    while (i + 1 < estimate.size() && estimate[i + 1].utime < r.utime) ++i;
    if (i + 1 >= estimate.size() || r.utime < estimate[i].utime) continue;
    const StampedPose &a = estimate[i], &b = estimate[i + 1];
    if (b.utime - a.utime > Milliseconds(4000)) continue;
    const double f = (r.utime - a.utime).seconds() / (b.utime - a.utime).seconds();
    est.push_back(Interpolate(a.T, b.T, f).translation().head<2>());
    ref.push_back(r.T.translation().head<2>());
  }
  if (ref.size() < 10) return -1;
  Eigen::Vector2d mean_r = Eigen::Vector2d::Zero(), mean_e = Eigen::Vector2d::Zero();
  for (size_t k = 0; k < ref.size(); ++k) {
    mean_r += ref[k] / static_cast<double>(ref.size());
    mean_e += est[k] / static_cast<double>(ref.size());
  }
  double c = 0, s = 0;
  for (size_t k = 0; k < ref.size(); ++k) {
    const Eigen::Vector2d a = est[k] - mean_e, b = ref[k] - mean_r;
    c += a.dot(b);
    s += a.x() * b.y() - a.y() * b.x();
  }
  const Eigen::Rotation2Dd turn(std::atan2(s, c));
  double sum = 0;
  for (size_t k = 0; k < ref.size(); ++k) {
    sum += (ref[k] - mean_r - turn * (est[k] - mean_e)).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(ref.size()));
}

double WayOf(const std::vector<StampedPose>& poses) {
  double way = 0;
  for (size_t i = 1; i < poses.size(); ++i) {
    const SE3 step = poses[i - 1].T.inverse() * poses[i].T;
    way += std::copysign(step.translation().norm(), step.translation().x());
  }
  return way;
}

double TurnOf(const std::vector<StampedPose>& poses) {
  double turn = 0;
  for (size_t i = 1; i < poses.size(); ++i) {
    turn += LogSO3((poses[i - 1].T.inverse() * poses[i].T).rotation()).z();
  }
  return turn;
}

DriveReport RunDrive(const RealDrive& drive, const DrEkfConfig& config) {
  DriveReport report;
  DrFilter filter = std::move(DrFilter::Create(config, drive.calibration)).value();
  bool slip = false;
  for (const Sample& sample : drive.samples) {
    DrFilter::Output out = Feed(filter, sample);
    report.counters = out.counters;
    report.found.insert(report.found.end(), out.found.begin(), out.found.end());
    report.events.insert(report.events.end(), out.events.begin(), out.events.end());
    for (DrState& state : out.states) {
      report.slips += state.slip && !slip;
      slip = state.slip;
      report.lowest = std::min(report.lowest, state.T_OB.translation().z());
      report.highest = std::max(report.highest, state.T_OB.translation().z());
      report.poses.push_back({state.utime, state.T_OB});
      report.states.push_back(std::move(state));
    }
  }
  if (!drive.truth.empty()) {
    report.ape_dr = PlanarApe(drive.truth, report.poses);
    report.ape_raw = PlanarApe(drive.truth, drive.raw);
  }
  report.way_dr = WayOf(report.poses);
  report.way_raw = WayOf(drive.raw);
  report.turn_dr = TurnOf(report.poses);
  report.turn_raw = TurnOf(drive.raw);
  return report;
}

void PrintReport(const std::string& name, const DriveReport& r) {
  if (r.states.empty()) {
    std::printf("%s: no states\n", name.c_str());
    return;
  }
  const DrState& last = r.states.back();
  const DrCounters& n = r.counters;
  const long long rejected = static_cast<long long>(n.rejected_non_monotonic + n.rejected_absurd +
                                                    n.rejected_late + n.rejected_future);
  std::printf(
      "%-28s APE dr %.4f raw %.4f ratio %.3f; way %.2f raw %.2f; turn %.1f raw %.1f deg; height "
      "%.3f..%.3f; slips %d resets %lld rejected %lld gated way %lld yaw %lld bias jumps %lld\n"
      "    gyro bias %.5f %.5f %.5f accel bias %.3f %.3f %.3f wheel scale %.4f+-%.4f turn scale "
      "%.4f+-%.4f\n",
      name.c_str(), r.ape_dr, r.ape_raw, r.ape_dr / r.ape_raw, r.way_dr, r.way_raw,
      DegOf(r.turn_dr), DegOf(r.turn_raw), r.lowest, r.highest, r.slips,
      static_cast<long long>(n.resets), rejected, static_cast<long long>(n.step.gated_wheel_way),
      static_cast<long long>(n.step.gated_wheel_yaw),
      static_cast<long long>(n.step.gyro_bias_jumps), last.gyro_bias_rad_s.x(),
      last.gyro_bias_rad_s.y(), last.gyro_bias_rad_s.z(), last.accel_bias_m_s2.x(),
      last.accel_bias_m_s2.y(), last.accel_bias_m_s2.z(), last.wheel_scale, last.way_scale_sigma,
      last.turn_scale, last.turn_scale_sigma);
  bool slip = false;
  for (const DrState& state : r.states) {
    if (state.slip != slip) {
      std::printf("    %s at %.2f s\n", state.slip ? "slip" : "over",
                  (state.utime - r.states.front().utime).seconds());
    }
    slip = state.slip;
  }
  for (const DrDiagnosis diagnosis : r.found) {
    std::printf("    found: %s\n", std::string(Name(diagnosis)).c_str());
  }
}

}  // namespace gw::dr_ekf
