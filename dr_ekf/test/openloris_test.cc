// Real wheel odometry through the filter: it must not make it worse. Six runs of OpenLORIS-Scene,
// 5 to 220 m, odometry at 20 or 40 Hz, no IMU in this copy; so the filter runs on wheels alone.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "dr_ekf/core/dr_filter.h"

namespace gw::dr_ekf {
namespace {

namespace fs = std::filesystem;

struct StampedPose {
  Utime utime;
  SE3 T;
};

fs::path DataDir() {
  const char* shared = std::getenv("GW_SHARED_DIR");
  const fs::path base =
      shared != nullptr ? fs::path(shared) : fs::path(GW_SOURCE_DIR) / "../shared";
  return base / "data" / "openloris_odometry";
}

std::vector<StampedPose> ReadPoses(const fs::path& file) {
  std::vector<StampedPose> out;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream fields(line);
    double t, x, y, z, qx, qy, qz, qw;
    if (fields >> t >> x >> y >> z >> qx >> qy >> qz >> qw) {
      out.push_back({UtimeFromSeconds(t), SE3(Eigen::Quaterniond(qw, qx, qy, qz), {x, y, z})});
    }
  }
  return out;
}

// RMSE of the position after the best turn about z and shift; poses of `estimate` are interpolated
// to the times of the reference.
double ApeRmse(const std::vector<StampedPose>& reference,
               const std::vector<StampedPose>& estimate) {
  std::vector<Eigen::Vector2d> ref, est;
  size_t i = 0;
  for (const StampedPose& r : reference) {
    while (i + 1 < estimate.size() && estimate[i + 1].utime < r.utime) ++i;
    if (i + 1 >= estimate.size() || r.utime < estimate[i].utime) continue;
    const StampedPose &a = estimate[i], &b = estimate[i + 1];
    if (b.utime - a.utime > Milliseconds(500)) continue;
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

TEST(OpenLoris, FilteredWheelsAreNoWorseThanRawOdometry) {
  if (!fs::exists(DataDir())) GTEST_SKIP() << "no recordings at " << DataDir();
  std::printf("%-14s %8s %9s %10s %10s %7s %9s %6s\n", "run", "way m", "samples", "raw APE m",
              "filter m", "ratio", "rejected", "slips");
  for (const char* name :
       {"cafe-1-1", "corridor-1-1", "corridor-1-3", "home-1-1", "home-1-2", "market-1-1"}) {
    const std::vector<StampedPose> odometry = ReadPoses(DataDir() / name / "odom.txt");
    const std::vector<StampedPose> truth = ReadPoses(DataDir() / name / "groundtruth.txt");
    ASSERT_GT(odometry.size(), 100u) << name;
    Calibration calibration;
    calibration.wheel.present = true;
    calibration.wheel.rate_hz = 20;
    Result<DrFilter> filter = DrFilter::Create({}, calibration);
    ASSERT_TRUE(filter.ok());

    double way = 0;
    std::vector<StampedPose> filtered;
    DrFilter::Output out;
    for (size_t i = 1; i < odometry.size(); ++i) {
      const SE3 step = odometry[i - 1].T.inverse() * odometry[i].T;
      WheelSample s;
      s.utime_begin = odometry[i - 1].utime;
      s.utime = odometry[i].utime;
      s.seq = static_cast<int64_t>(i);
      s.dx_m = step.translation().x();
      s.dy_m = step.translation().y();
      s.dyaw_rad = LogSO3(step.rotation()).z();
      way += step.translation().norm();
      out = filter->Push(s);
      for (const DrState& state : out.states) filtered.push_back({state.utime, state.T_OB});
    }
    const DrCounters& n = out.counters;
    const int64_t rejected =
        n.rejected_non_monotonic + n.rejected_absurd + n.rejected_late + n.rejected_future;
    const double raw = ApeRmse(truth, odometry);
    const double ours = ApeRmse(truth, filtered);
    std::printf("%-14s %8.1f %9zu %10.4f %10.4f %7.4f %9lld %6lld\n", name, way, odometry.size(),
                raw, ours, ours / raw, static_cast<long long>(rejected),
                static_cast<long long>(n.step.slips));
    EXPECT_GT(raw, 0) << name;
    EXPECT_LE(ours, 1.02 * raw) << name;
  }
}

}  // namespace
}  // namespace gw::dr_ekf
