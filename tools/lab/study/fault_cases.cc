#include "tools/lab/study/fault_cases.h"

#include <algorithm>

namespace gw::study {
namespace {

constexpr double kYaw = 10 * M_PI / 180;  // rad
constexpr double kMoved = 0.1;            // m
constexpr double kBaselineScale = 1.2;

bool IsOfCamera(fault::FaultTarget target) {
  using enum fault::FaultTarget;
  return target == kCamera || target == kStereo || target == kRgbd;
}

bool Concerns(const fault::FaultKind& kind, const RobotConfig& robot) {
  using enum fault::FaultTarget;
  const bool sensors = robot.dr_ekf.source == DrSource::kSensors;
  const ImuCalibration& imu = robot.calibration.imu;
  const bool stereo = robot.calibration.camera.kind == CameraKind::kStereo;
  switch (kind.target) {
    case kWheels:
      return sensors && robot.calibration.wheel.present;
    case kWheelsAndDr:
      return !sensors || robot.calibration.wheel.present;
    case kImu:
      return sensors && imu.present && (kind.id != fault::FaultId::kAccelG || imu.has_accel);
    case kCamera:
      return true;
    case kStereo:
      return stereo;
    case kRgbd:
      return !stereo;
  }
  return false;
}

Accused Guilty(const fault::FaultKind& kind) {
  if (kind.target == fault::FaultTarget::kImu) return Accused::kImu;
  return IsOfCamera(kind.target) ? Accused::kVision : Accused::kWheels;
}

FaultCase OfLog(const fault::FaultKind& kind, const RobotConfig& robot, DurationUs log_length,
                DurationUs from) {
  fault::NamedFault fault = fault::WithUsualSpan(kind);
  if (kind.begin_s > 0 && !IsOfCamera(kind.target)) {
    const DurationUs length = fault.span.end - fault.span.begin;
    const bool to_the_end = fault.span.end == tools::Span().end;
    fault.span.begin = {log_length.us / 2};
    if (!to_the_end) fault.span.end = fault.span.begin + length;
  } else {
    fault.span.begin = std::max(fault.span.begin, from);
  }
  FaultCase out{std::string(kind.name), std::string(kind.text), {}, robot,
                fault.span.begin,       Guilty(kind),           {}};
  out.plan.named = {fault};
  out.plan.optics = fault::OpticsOf(robot.calibration.camera);
  return out;
}

// The camera where the configuration does not say, T_BC_wrong = T * T_BC.
FaultCase WithExtrinsics(const std::string& name, const std::string& text, const SE3& T_BC_wrong,
                         const RobotConfig& robot) {
  FaultCase out{name, text, {}, robot, {}, Accused::kDr, {}};
  CameraCalibration& camera = out.config.calibration.camera;
  out.T_BB = T_BC_wrong * camera.T_BC.inverse();
  camera.T_BC = T_BC_wrong;
  return out;
}

void AddOfConfiguration(FaultMatrix matrix, const RobotConfig& robot,
                        std::vector<FaultCase>* cases) {
  const CameraCalibration& camera = robot.calibration.camera;
  if (matrix == FaultMatrix::kDr) {
    const SE3& T_BC = camera.T_BC;
    const Eigen::Quaterniond R(Eigen::AngleAxisd(kYaw, Eigen::Vector3d::UnitZ()));
    cases->push_back(WithExtrinsics("camera_yaw_10deg",
                                    "configuration: camera turned by 10 degrees about the vertical",
                                    SE3(R * T_BC.rotation(), T_BC.translation()), robot));
    cases->push_back(WithExtrinsics(
        "camera_moved_10cm", "configuration: camera 10 cm too far ahead",
        SE3(T_BC.rotation(), T_BC.translation() + Eigen::Vector3d(kMoved, 0, 0)), robot));
  } else if (camera.kind == CameraKind::kStereo) {
    FaultCase fault{"baseline_x1.2",
                    "configuration: baseline a fifth too long",
                    {},
                    robot,
                    {},
                    Accused::kVision,
                    {}};
    SE3& T_C0C1 = fault.config.calibration.camera.T_C0C1;
    T_C0C1 = SE3(T_C0C1.rotation(), kBaselineScale * T_C0C1.translation());
    cases->push_back(fault);
  }
}

}  // namespace

std::vector<FaultCase> FaultCases(FaultMatrix matrix, const RobotConfig& robot,
                                  DurationUs log_length, DurationUs from) {
  std::vector<FaultCase> out;
  for (const fault::FaultKind& kind : fault::FaultKinds()) {
    const bool in_matrix = IsOfCamera(kind.target) == (matrix == FaultMatrix::kVision);
    if (in_matrix && Concerns(kind, robot)) out.push_back(OfLog(kind, robot, log_length, from));
  }
  if (from == DurationUs()) AddOfConfiguration(matrix, robot, &out);
  return out;
}

Result<std::vector<FaultCase>> ChooseCases(const std::vector<FaultCase>& cases,
                                           const std::vector<std::string>& names) {
  if (names.empty()) return cases;
  std::vector<FaultCase> out;
  for (const std::string& name : names) {
    const auto found = std::find_if(cases.begin(), cases.end(),
                                    [&](const FaultCase& c) { return c.name == name; });
    if (found == cases.end()) {
      std::string all;
      for (const FaultCase& c : cases) all += " " + c.name;
      return Error{ErrorCode::kInvalidArgument, "--faults " + name + ": this robot can have" + all};
    }
    out.push_back(*found);
  }
  return out;
}

}  // namespace gw::study
