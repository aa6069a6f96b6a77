#include "frontend/core/tracking/health_cause.h"

namespace gw::frontend {
namespace {

std::string CauseOf(TrackingStatus status) {
  switch (status) {
    case TrackingStatus::kInitializing:
      return "no map can be begun: too few features of the image have a depth. Check lens and "
             "light, the baseline, the unit of depth";
    case TrackingStatus::kLost:
      return "neither vision nor dead reckoning: check lens, light and gw-dr-ekf";
    case TrackingStatus::kRecovering:
      return "where in the map is not known: drive to where it was made, or begin a new map";
    default:
      return "";
  }
}

}  // namespace

std::string HealthCause(const FramePose& frame, const DrConstantFault& fault,
                        const LengthFault& lengths, ViewFault view) {
  if (frame.status == TrackingStatus::kRecovering && frame.reason == TrackingReason::kPoseJump) {
    return "what the camera sees does not fit to where dead reckoning is: somebody before the "
           "camera, slipping wheels, or the robot was carried";
  }
  if (frame.reason == TrackingReason::kOneEyeTwice) {
    return "left and right image are the same image: one eye comes twice, check the topics or the "
           "driver's streams";
  }
  if (frame.reason == TrackingReason::kEyesExchanged) {
    return "left and right image are exchanged: swap the topics, the streams or the cables";
  }
  std::string cause = CauseOf(frame.status);
  if (!cause.empty()) return cause;
  if (frame.reason == TrackingReason::kEyesApart) {
    return "left and right image are not of one instant, depth is not used: check the camera's "
           "synchronisation and that pairs are not mixed up";
  }
  if (frame.reason == TrackingReason::kFixedInImage) {
    return "most of what the camera sees does not move when the robot does: is the infrared "
           "projector on, the lens dirty, or part of the robot in view?";
  }
  if (frame.status == TrackingStatus::kDrOnly) {
    return "vision sees nothing, dead reckoning carries the pose: check lens and light";
  }
  if (lengths.found()) return Describe(lengths);
  if (frame.reason == TrackingReason::kDrContradictsVision) {
    const std::string named = Describe(fault);
    return "dead reckoning contradicts healthy vision and is not used: " +
           (named.empty() ? "check wheel calibration, axes, signs and units (gw-slam LOG --dr-only "
                            "names more)"
                          : named);
  }
  if (!fault.empty()) {
    return "dead reckoning is wrong by a constant, which vision has measured and which is taken "
           "out "
           "of it: " +
           Describe(fault);
  }
  return std::string(Describe(view));
}

}  // namespace gw::frontend
