#include "tools/lab/study/fault_table.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

namespace gw::study {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

RobotConfig Robot(CameraKind kind) {
  RobotConfig robot;
  robot.calibration.camera.kind = kind;
  robot.calibration.camera.T_C0C1 = SE3(Eigen::Quaterniond::Identity(), {0.05, 0, 0});
  robot.calibration.camera.T_BC = SE3(ExpSO3({0.1, 0.2, 0.3}), {0.2, 0, 0.3});
  robot.calibration.imu.present = robot.calibration.wheel.present = true;
  return robot;
}

std::vector<std::string> Names(FaultMatrix matrix, const RobotConfig& robot) {
  std::vector<std::string> out;
  for (const FaultCase& c : FaultCases(matrix, robot, Milliseconds(60000))) out.push_back(c.name);
  return out;
}
bool Has(const std::vector<std::string>& names, const std::string& name) {
  return std::count(names.begin(), names.end(), name) == 1;
}

TEST(FaultCases, FaultsOfSensorsThatTheRobotHas) {
  const auto dr = Names(FaultMatrix::kDr, Robot(CameraKind::kStereo));
  EXPECT_TRUE(Has(dr, "wheels_resampled") && Has(dr, "gyro_deg") && Has(dr, "camera_yaw_10deg"));
  EXPECT_FALSE(Has(dr, "dots"));
  RobotConfig recorded = Robot(CameraKind::kRgbd);
  recorded.dr_ekf.source = DrSource::kRecorded;
  const auto of_recorded = Names(FaultMatrix::kDr, recorded);
  EXPECT_TRUE(Has(of_recorded, "wheels_x2"));
  EXPECT_FALSE(Has(of_recorded, "wheels_resampled") || Has(of_recorded, "gyro_deg"));
  const auto stereo = Names(FaultMatrix::kVision, Robot(CameraKind::kStereo));
  EXPECT_TRUE(Has(stereo, "right_late") && Has(stereo, "baseline_x1.2") && Has(stereo, "dots"));
  EXPECT_FALSE(Has(stereo, "depth_late"));
  const auto rgbd = Names(FaultMatrix::kVision, recorded);
  EXPECT_TRUE(Has(rgbd, "depth_late") && Has(rgbd, "person"));
  EXPECT_FALSE(Has(rgbd, "right_late") || Has(rgbd, "baseline_x1.2"));
}

TEST(FaultCases, EventsHappenInTheMiddleOfTheLog) {
  const auto cases = FaultCases(FaultMatrix::kDr, Robot(CameraKind::kStereo), Milliseconds(60000));
  const auto chosen = ChooseCases(cases, {"wheels_nan", "gyro_deg"});
  ASSERT_TRUE(chosen);
  ASSERT_EQ(chosen->size(), 2u);
  EXPECT_EQ((*chosen)[0].begin, Milliseconds(30000));
  EXPECT_EQ((*chosen)[0].plan.named[0].span.end, Milliseconds(31000));
  EXPECT_EQ((*chosen)[1].begin, Milliseconds(0));
  const auto unknown = ChooseCases(cases, {"dots"});
  ASSERT_FALSE(unknown);
  EXPECT_THAT(unknown.error().message, HasSubstr("wheels_turned"));
}

TEST(FaultCases, BeginOnTheWay) {
  const auto cases = FaultCases(FaultMatrix::kDr, Robot(CameraKind::kStereo), Milliseconds(60000),
                                Milliseconds(12000));
  const auto chosen = ChooseCases(cases, {"wheels_nan", "wheels_x2"});
  ASSERT_TRUE(chosen);
  EXPECT_EQ((*chosen)[0].begin, Milliseconds(30000));
  EXPECT_EQ((*chosen)[0].plan.named[0].span.end, Milliseconds(31000));
  EXPECT_EQ((*chosen)[1].begin, Milliseconds(12000));
  EXPECT_EQ((*chosen)[1].plan.named[0].span.begin, Milliseconds(12000));
  EXPECT_FALSE(ChooseCases(cases, {"camera_yaw_10deg"})) << "a configuration does not change";
}

// A camera that is where it is, in a run that believes it elsewhere: what vision says of it,
// brought to the body by T_BB, is the body.
TEST(FaultCases, WrongExtrinsicsAreUndone) {
  const RobotConfig robot = Robot(CameraKind::kStereo);
  const auto cases = FaultCases(FaultMatrix::kDr, robot, Milliseconds(60000));
  const auto chosen = ChooseCases(cases, {"camera_yaw_10deg", "camera_moved_10cm"});
  ASSERT_TRUE(chosen);
  const SE3 T_WB(ExpSO3({0, 0, 0.7}), {1, 2, 0});
  const SE3 T_WC = T_WB * robot.calibration.camera.T_BC;
  for (const FaultCase& c : *chosen) {
    const SE3 T_WB_said = T_WC * c.config.calibration.camera.T_BC.inverse();
    EXPECT_GT((T_WB_said.inverse() * T_WB).Log().norm(), 0.05) << c.name;
    EXPECT_LT(((T_WB_said * c.T_BB).inverse() * T_WB).Log().norm(), 1e-9) << c.name;
  }
}

FaultRow Row(double full_m) {
  FaultRow row;
  row.name = "fault";
  row.guilty = Accused::kWheels;
  FaultOutcome outcome;
  outcome.numbers.ape_m = full_m;
  outcome.sayings = {{"slip", 0.5, 3, Accused::kWheels, false},
                     {"dr_contradicts_vision", 3, 20, Accused::kDr, true}};
  row.full = {outcome};
  row.none_m = 0.1;
  row.dr_m = 0.2;
  row.wheels_m = 1;
  row.sound_full_m = 0.08;
  return row;
}

TEST(FaultTable, FaultsOfDrAreHeldAgainstVisionOrTheWheels) {
  EXPECT_THAT(Judge(FaultMatrix::kDr, true, Row(0.109)).misses, IsEmpty());
  EXPECT_THAT(Judge(FaultMatrix::kDr, true, Row(0.111)).misses, ElementsAre("error"));
  EXPECT_THAT(Judge(FaultMatrix::kDr, false, Row(1.04)).misses, IsEmpty());
  EXPECT_THAT(Judge(FaultMatrix::kDr, false, Row(1.06)).misses, ElementsAre("error"));
  FaultRow without_wheels = Row(0.22);
  without_wheels.wheels_m.reset();
  EXPECT_THAT(Judge(FaultMatrix::kDr, false, without_wheels).misses, ElementsAre("error"));
}

TEST(FaultTable, OnlyHealthNamesAndTheNameMustComeInTime) {
  FaultRow row = Row(0.1);
  EXPECT_EQ(Judge(FaultMatrix::kDr, true, row).named_after_s, 3);
  row.full[0].sayings[1].after_s = 11;
  EXPECT_THAT(Judge(FaultMatrix::kDr, true, row).misses, ElementsAre("not named"));
  row.full[0].sayings[1] = {"accel_unfit", 2, 1, Accused::kImu, true};  // the wrong one
  EXPECT_THAT(Judge(FaultMatrix::kDr, true, row).misses, ElementsAre("not named"));
  row.guilty = Accused::kImu;
  EXPECT_THAT(Judge(FaultMatrix::kDr, true, row).misses, IsEmpty());
}

TEST(FaultTable, FaultsOfVisionMayBeAsBadAsDrButNotSureOfIt) {
  FaultRow row = Row(0.24);
  row.guilty = Accused::kVision;
  EXPECT_THAT(Judge(FaultMatrix::kVision, true, row).misses, ElementsAre("not named"));
  row.full[0].sayings.push_back({"too_few_matches", 30, 5, Accused::kVision, true});
  EXPECT_THAT(Judge(FaultMatrix::kVision, true, row).misses, IsEmpty());
  row.full[0].numbers.too_sure_s = 2.5;
  EXPECT_THAT(Judge(FaultMatrix::kVision, true, row).misses, ElementsAre("too sure"));
  row.full[0].numbers.ape_m = 0.26;
  row.full[0].sayings.pop_back();
  EXPECT_THAT(Judge(FaultMatrix::kVision, true, row).misses,
              ElementsAre("error", "too sure", "not named"));
}

TEST(FaultTable, TheWorstSeedCounts) {
  FaultRow row = Row(0.1);
  row.full.push_back(row.full[0]);
  row.full[1].numbers.ape_m = 0.14;
  row.full[1].numbers.without_pose = 4;
  row.full[1].sayings.clear();
  const FaultVerdict verdict = Judge(FaultMatrix::kDr, true, row);
  EXPECT_NEAR(*verdict.full_m, 0.12, 1e-12);
  EXPECT_THAT(verdict.misses, ElementsAre("error", "no pose", "not named"));
  row.full[1].numbers.ape_m.reset();
  EXPECT_FALSE(Judge(FaultMatrix::kDr, true, row).ratio);
}

TEST(FaultTable, OnlyWhatTheSoundRunDoesNotSayCounts) {
  const Findings sound = {{"too_few_matches", {{1000000}, 3, Accused::kVision, true}}};
  const Findings faulty = {{"too_few_matches", {{2000000}, 30, Accused::kVision, true}},
                           {"slip", {{9000000}, 1, Accused::kWheels, false}},
                           {"accel_in_g", {{1500000}, 1, Accused::kImu, true}}};
  const auto sayings = SayingsOf(faulty, sound, Utime{4000000});
  ASSERT_EQ(sayings.size(), 2u);
  EXPECT_EQ(sayings[0].name, "accel_in_g");
  EXPECT_EQ(sayings[0].after_s, 0);
  EXPECT_EQ(sayings[0].accused, Accused::kImu);
  EXPECT_TRUE(sayings[0].in_health);
  EXPECT_EQ(sayings[1].after_s, 5);
  EXPECT_EQ(sayings[1].accused, Accused::kWheels);
  EXPECT_FALSE(sayings[1].in_health);
}

TEST(FaultTable, SaysWhatCameOut) {
  const StudyFiles files = RenderFaults(FaultMatrix::kDr, true, "log x", 0.4, {Row(0.1), Row(0.2)});
  EXPECT_THAT(files.markdown, HasSubstr("| fault | 0.1000 | 0.1000 | 0.200 | 1.000 | 0.0800 | "
                                        "0.91 | slip (0.5 s; 3; *), dr_contradicts_vision (3.0 s; "
                                        "20) | 0 | 0.0 | met |"));
  EXPECT_THAT(files.markdown, HasSubstr("**error**"));
  EXPECT_THAT(files.csv, HasSubstr("\nfault,0.1,0.1,0.2,1,0.08,"));
  EXPECT_THAT(files.drawing.svg, HasSubstr("log x"));
}

// A circle that is followed well, but for 3 s in the middle half a metre beside it.
TEST(FaultMeasures, ErrorsBeyondTheCovarianceAreTimed) {
  eval::Trajectory truth;
  measure::SlamRun run;
  for (int i = 0; i < 600; ++i) {
    const double t = i / 30.0;
    const SE3 T(ExpSO3({0, 0, 0.6 * t}), {2 * std::sin(0.6 * t), -2 * std::cos(0.6 * t), 0.0});
    truth.push_back({UtimeFromSeconds(t), T});
    FramePose f;
    f.utime = truth.back().utime;
    const bool off = i >= 300 && i < 390;
    f.T_WB = SE3(T.rotation(), T.translation() + Eigen::Vector3d(0, 0, off ? 0.5 : 0));
    f.cov_T_WB = 0.03 * 0.03 * Matrix6d::Identity();
    f.status = i == 0 ? TrackingStatus::kInitializing : TrackingStatus::kTracking;
    if (i == 330) f.status = TrackingStatus::kDegraded;
    if (i == 500) f.status = TrackingStatus::kLost;
    run.frames.push_back(f);
  }
  const FaultNumbers numbers = MeasureFault(run, SE3(), truth, eval::Alignment::kNone);
  EXPECT_EQ(numbers.without_pose, 1);
  EXPECT_NEAR(numbers.too_sure_s, 58 / 30.0, 1e-3);  // images 331 to 389
  EXPECT_NEAR(numbers.too_sure_share, 89 / 597.0, 1e-9);
  EXPECT_NEAR(*numbers.ape_m, 0.5 * std::sqrt(90 / 600.0), 1e-9);
  for (FramePose& f : run.frames) f.cov_T_WB *= 100;
  EXPECT_EQ(MeasureFault(run, SE3(), truth, eval::Alignment::kNone).too_sure_s, 0);
  EXPECT_NEAR(FirstMotion(truth).seconds(), 1 / 30.0 * 2, 1e-3);
}

// A drift of 2 cm/s that is known, where the map is surest of its begin: laid over the truth as a
// whole it would be off there.
TEST(FaultMeasures, TheCovarianceIsHeldAgainstTheErrorSinceTheBegin) {
  const SE3 T_GW(ExpSO3({0, 0, 0.7}), {3, 4, 0});
  eval::Trajectory truth;
  measure::SlamRun run;
  for (int i = 0; i < 600; ++i) {
    const double t = i / 30.0;
    const SE3 T(ExpSO3({0, 0, 0.6 * t}), {2 * std::sin(0.6 * t), -2 * std::cos(0.6 * t), 0.0});
    truth.push_back({UtimeFromSeconds(t), T_GW * T});
    FramePose f;
    f.utime = truth.back().utime;
    f.T_WB = SE3(T.rotation(), T.translation() + Eigen::Vector3d(0, 0, 0.02 * t));
    f.cov_T_WB = std::pow(0.001 + 0.01 * t, 2) * Matrix6d::Identity();
    f.status = TrackingStatus::kTracking;
    run.frames.push_back(f);
  }
  const auto too_sure = [&] {
    return MeasureFault(run, SE3(), truth, eval::Alignment::kSe3).too_sure_s;
  };
  EXPECT_LT(too_sure(), 1);
  for (FramePose& f : run.frames) f.cov_T_WB /= 100;
  EXPECT_GT(too_sure(), 15);
}

}  // namespace
}  // namespace gw::study
