// Dead reckoning alone on recordings that this project did not make: never worse than the wheels'
// own sum, whatever the robot.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "common/good_weights/dr_history.h"
#include "dr_ekf/test/drive_report.h"
#include "dr_ekf/test/reference_body.h"

namespace gw::dr_ekf {
namespace {

namespace fs = std::filesystem;

struct Folder {
  const char* name;  // below the data folder
  // Share of windows whose error is in the band that the covariance says, at least: what it is
  // today. Wheels alone cannot know how bad they are; the configuration says.
  double honest = 0;
  double of_raw = 0.6;  // APE of DR at most, as a share of the wheels'
};
void PrintTo(const Folder& folder, std::ostream* os) {
  *os << folder.name;
}
std::string TestName(const testing::TestParamInfo<Folder>& info) {
  std::string name = info.param.name;
  for (char& c : name) {
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  }
  return name;
}

class WheelsAlone : public testing::TestWithParam<Folder> {};
INSTANTIATE_TEST_SUITE_P(OpenLoris, WheelsAlone,
                         testing::Values(Folder{"openloris_odometry/cafe-1-1", 0.8},
                                         Folder{"openloris_odometry/corridor-1-1", 0.75},
                                         Folder{"openloris_odometry/corridor-1-3", 0.75},
                                         Folder{"openloris_odometry/home-1-1", 0.75},
                                         Folder{"openloris_odometry/home-1-2", 0.85},
                                         Folder{"openloris_odometry/market-1-1", 0.55}),
                         TestName);
INSTANTIATE_TEST_SUITE_P(Carmen, WheelsAlone,
                         testing::Values(Folder{"carmen_odometry/acapulco", 0.85},
                                         Folder{"carmen_odometry/aces", 0.8},
                                         Folder{"carmen_odometry/fhw", 0.75},
                                         Folder{"carmen_odometry/intel", 0.35}),
                         TestName);

TEST_P(WheelsAlone, AreNoWorseThanTheirSum) {
  const auto folder = FindRecording(GetParam().name);
  if (!folder) GTEST_SKIP() << "no recording " << GetParam().name;
  const bool carmen = fs::exists(*folder / "laser_pose.txt");
  const RealDrive drive = carmen ? ReadOdometryAlone(*folder, "odom_raw.txt", "laser_pose.txt")
                                 : ReadOdometryAlone(*folder, "odom.txt", "groundtruth.txt");
  const DriveReport report = RunDrive(drive);
  PrintReport(GetParam().name, report);
  ASSERT_GT(report.ape_raw, 0);
  EXPECT_LE(report.ape_dr, 1.02 * report.ape_raw);
  EXPECT_NEAR(report.way_dr, report.way_raw, 0.01 * std::abs(report.way_raw));
  EXPECT_EQ(report.slips, 0);
  EXPECT_EQ(report.counters.resets, 0);
}

// Share of the windows whose error is in the 95 % band of what the published covariance says, in
// the plane. The reference counts with the errors that its maker states or that its steps show.
struct Honesty {
  int windows = 0, inside = 0, above = 0;
  double share() const { return windows == 0 ? 0 : static_cast<double>(inside) / windows; }
};

// Of the reference: place, heading, and the time of a pose or of the wheels beside it.
struct TruthNoise {
  double m = 0, rad = 0, s = 0;
};

Honesty NeesOf(const std::vector<StampedPose>& reference, const DriveReport& report,
               double window_s, const TruthNoise& noise) {
  DrHistory history(Milliseconds(100'000'000));
  for (const DrState& s : report.states) history.Push(s);
  Honesty out;
  size_t j = 0;
  for (size_t i = 0; i < reference.size(); i = std::max(i + 1, j)) {
    j = i;
    const Utime a = reference[i].utime;
    while (j < reference.size() && (reference[j].utime - a).seconds() < window_s) ++j;
    if (j >= reference.size()) break;
    const Utime b = reference[j].utime;
    if ((b - a).seconds() > 1.5 * window_s + 3) continue;
    const auto increment = history.Increment(a, b);
    if (!increment) continue;
    const SE3 truth = reference[i].T.inverse() * reference[j].T;
    if (truth.translation().norm() < 0.02 * window_s) continue;  // parked
    const Vector6d error = (increment->T_BaBb.inverse() * truth).Log();
    Eigen::Matrix3d cov;
    Eigen::Vector3d e;
    const int axes[3] = {0, 1, 5};
    for (int r = 0; r < 3; ++r) {
      e[r] = error[axes[r]];
      for (int c = 0; c < 3; ++c) cov(r, c) = increment->cov(axes[r], axes[c]);
    }
    const double late = noise.s * truth.translation().norm() / (b - a).seconds();
    cov.diagonal() += 2 * Eigen::Vector3d(noise.m * noise.m + late * late, noise.m * noise.m,
                                          noise.rad * noise.rad);
    const double nees = e.dot(cov.ldlt().solve(e));
    ++out.windows;
    out.inside += nees > 0.216 && nees < 9.348;
    out.above += nees >= 9.348;
  }
  return out;
}

TEST_P(WheelsAlone, SayHowWrongTheyMayBe) {
  const auto folder = FindRecording(GetParam().name);
  if (!folder) GTEST_SKIP() << "no recording " << GetParam().name;
  const bool carmen = fs::exists(*folder / "laser_pose.txt");
  const RealDrive drive = carmen ? ReadOdometryAlone(*folder, "odom_raw.txt", "laser_pose.txt")
                                 : ReadOdometryAlone(*folder, "odom.txt", "groundtruth.txt");
  const DriveReport report = RunDrive(drive);
  const ReferenceBody body = FitReferenceBody(drive.truth, drive.raw);
  std::printf("%s: reference is of a body at %.3f %.3f m, %.1f deg, its clock %.2f s ahead\n",
              GetParam().name, body.T_BR.translation().x(), body.T_BR.translation().y(),
              LogSO3(body.T_BR.rotation()).z() * 180 / M_PI, body.clock_ahead_s);
  const std::vector<StampedPose> reference = InBodyOfWheels(drive.truth, body);
  // Laser poses of a few centimetres; nothing tells when between two samples a wheel turned.
  const TruthNoise noise{carmen ? 0.03 : 0.01, carmen ? 0.01 : 0.003,
                         0.5 * MedianPeriod(drive.raw)};
  Honesty all;
  for (const double window_s : {1.0, 5.0, 20.0}) {
    const Honesty h = NeesOf(reference, report, window_s, noise);
    std::printf("%s, %2.0f s: %d windows, %.0f %% inside the band, %.0f %% above\n",
                GetParam().name, window_s, h.windows, 100 * h.share(),
                h.windows == 0 ? 0.0 : 100.0 * h.above / h.windows);
    all.windows += h.windows;
    all.inside += h.inside;
  }
  EXPECT_GE(all.share(), GetParam().honest);
}

class Rendered : public testing::TestWithParam<Folder> {};
INSTANTIATE_TEST_SUITE_P(Drives, Rendered,
                         testing::Values(Folder{"wheels_and_imu/rendered_office_easy"},
                                         Folder{"rendered_night/openloris", 0, 1.0},
                                         Folder{"rendered_corridor/openloris"}),
                         TestName);

TEST_P(Rendered, IsBetterThanTheWheelsByTheGyroAndTheSameForJitteredOdometry) {
  const auto folder = FindRecording(GetParam().name);
  if (!folder) GTEST_SKIP() << "no recording " << GetParam().name;
  const DriveReport odometry = RunDrive(ReadRendered(*folder, RenderedWheels::kOdometry));
  const DriveReport encoder = RunDrive(ReadRendered(*folder, RenderedWheels::kEncoder));
  PrintReport(std::string(GetParam().name) + " 20Hz", odometry);
  PrintReport(std::string(GetParam().name) + " 50Hz", encoder);
  for (const DriveReport* report : {&odometry, &encoder}) {
    EXPECT_LE(report->ape_dr, GetParam().of_raw * report->ape_raw);
    EXPECT_EQ(report->slips, 0);
    EXPECT_EQ(report->counters.resets, 0);
  }
  EXPECT_NEAR(odometry.ape_dr, encoder.ape_dr, 0.1 * encoder.ape_raw);
}

TEST(RenderedSlip, IsFlaggedInJitteredOdometryAsInTheReadings) {
  const auto folder = FindRecording("wheels_and_imu/rendered_slip");
  if (!folder) GTEST_SKIP() << "no recording wheels_and_imu/rendered_slip";
  for (const auto wheels : {RenderedWheels::kOdometry, RenderedWheels::kEncoder}) {
    const RealDrive drive = ReadRendered(*folder, wheels);
    const DriveReport report = RunDrive(drive);
    PrintReport("rendered_slip", report);
    EXPECT_EQ(report.slips, 2);  // both wheels, then the left one
    EXPECT_EQ(report.counters.resets, 0);
    EXPECT_LE(report.ape_dr, 0.6 * report.ape_raw);
  }
}

class SkidSteer : public testing::TestWithParam<Folder> {};
INSTANTIATE_TEST_SUITE_P(Drives, SkidSteer,
                         testing::Values(Folder{"wheels_and_imu/skid_steer_run20"},
                                         Folder{"wheels_and_imu/skid_steer_run21"}),
                         TestName);

// Mean of the gyro in a span, seconds after the begin of the recording.
double MeanRate(const RealDrive& drive, double from_s, double to_s) {
  const Utime begin = std::visit([](const auto& s) { return s.utime; }, drive.samples.front());
  double sum = 0;
  int n = 0;
  for (const Sample& sample : drive.samples) {
    const auto* imu = std::get_if<ImuSample>(&sample);
    if (imu == nullptr) continue;
    const double t = (imu->utime - begin).seconds();
    if (t < from_s || t > to_s) continue;
    sum += imu->w_I_rad_s.z();
    ++n;
  }
  return sum / n;
}

// Integral of the gyro with the bias of the standstills at begin and end, a line between them.
double TurnOfGyro(const RealDrive& drive) {
  const Utime begin = std::visit([](const auto& s) { return s.utime; }, drive.samples.front());
  const Utime end = std::visit([](const auto& s) { return s.utime; }, drive.samples.back());
  const double length = (end - begin).seconds();
  constexpr double kStill = 8;  // s, at either end
  const double first = MeanRate(drive, 0, kStill);
  const double last = MeanRate(drive, length - kStill, length);
  double turn = 0;
  std::optional<ImuSample> before;
  for (const Sample& sample : drive.samples) {
    const auto* imu = std::get_if<ImuSample>(&sample);
    if (imu == nullptr) continue;
    if (before) {
      const double share = (imu->utime - begin).seconds() / length;
      turn +=
          (0.5 * (before->w_I_rad_s.z() + imu->w_I_rad_s.z()) - first - share * (last - first)) *
          (imu->utime - before->utime).seconds();
    }
    before = *imu;
  }
  return turn;
}

TEST_P(SkidSteer, HasTheWayOfItsWheelsAndTheTurnOfItsGyroOnAFlatFloor) {
  const auto folder = FindRecording(GetParam().name);
  if (!folder) GTEST_SKIP() << "no recording " << GetParam().name;
  for (const bool accelerometer : {true, false}) {
    const RealDrive drive = ReadSkidSteer(*folder, {.accelerometer = accelerometer});
    const DriveReport report = RunDrive(drive);
    PrintReport(std::string(GetParam().name) + (accelerometer ? " imu" : " gyro"), report);
    const double gyro = TurnOfGyro(drive);
    std::printf("    turn of the gyro %.2f deg\n", gyro * 180 / M_PI);
    EXPECT_NEAR(report.way_dr, report.way_raw, 0.02 * report.way_raw);
    // Run 21 drives over four ramps of 17 to 20 degrees (gyro and accelerometer both say so, for
    // four seconds each) and comes back to the floor.
    const bool ramps = std::string(GetParam().name).find("run21") != std::string::npos;
    std::printf("    last height %.3f m\n", report.poses.back().T.translation().z());
    EXPECT_NEAR(report.turn_dr, gyro, (ramps ? 4 : 3) * M_PI / 180);
    if (!ramps) {
      EXPECT_LT(report.highest - report.lowest, 0.2);
    }
    EXPECT_LT(std::abs(report.poses.back().T.translation().z()), 0.2);
    EXPECT_EQ(report.slips, 0);
    EXPECT_EQ(report.counters.resets, 0);
  }
}

}  // namespace
}  // namespace gw::dr_ekf
