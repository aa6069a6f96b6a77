#include "tools/data/fault/named_fault.h"

#include <algorithm>

namespace gw::fault {
namespace {

using enum FaultId;
using enum FaultTarget;

// Events that happen once begin late enough that any log is under way, and early enough for all.
constexpr double kOnceAt = 5;

constexpr FaultKind kKinds[] = {
    {kWheelsTurned, "wheels_turned", kWheelsAndDr, 0, 0,
     "frame turned by 90 degrees: x of the wheels is the robot's left"},
    {kWheelsReversed, "wheels_reversed", kWheelsAndDr, 0, 0,
     "both wheels count backwards (way and turn; of DR the way alone)"},
    {kWheelsDouble, "wheels_x2", kWheelsAndDr, 0, 0,
     "both wheels count twice (way and turn; of DR the way alone)"},
    {kWheelsHalf, "wheels_x0.5", kWheelsAndDr, 0, 0,
     "both wheels count half (way and turn; of DR the way alone)"},
    {kWheelsMillimetres, "wheels_mm", kWheelsAndDr, 0, 0, "way in millimetres for metres"},
    {kWheelsLate47, "wheels_late_47ms", kWheelsAndDr, 0, 0, "stamped and received 47 ms late"},
    {kWheelsLate150, "wheels_late_150ms", kWheelsAndDr, 0, 0, "stamped and received 150 ms late"},
    {kWheelsResampled, "wheels_resampled", kWheels, 0, 0,
     "20 Hz of 50 Hz: sums of 40 and of 60 ms in turn, stamped every 50 ms"},
    {kWheelsAlone, "wheels_alone_5hz", kWheels, 0, 0,
     "no IMU, and wheels that tell five times a second what they have counted"},
    {kWheelsStuck, "wheels_stuck", kWheelsAndDr, 0, 0,
     "increments of zero, counters stand still (of DR the whole pose)"},
    {kHeadingStuck, "heading_stuck", kWheels, 0, 0,
     "the base's heading stands still; without one, the wheels' turn is zero"},
    {kWheelsJump, "wheels_jump", kWheelsAndDr, kOnceAt, 0, "one increment is 5 m too long"},
    {kWheelsReset, "wheels_reset", kWheelsAndDr, kOnceAt, 0,
     "one increment leads back to where the sum was zero"},
    {kWheelsNan, "wheels_nan", kWheelsAndDr, kOnceAt, kOnceAt + 1, "increments are no numbers"},
    {kWheelsDoubled, "wheels_doubled", kWheelsAndDr, 0, 0, "every message comes twice"},
    {kGyroDegrees, "gyro_deg", kImu, 0, 0, "gyro in degrees per second"},
    {kGyroBias, "gyro_bias", kImu, 0, 0, "3 degrees per second on each axis of the gyro"},
    {kAccelG, "accel_g", kImu, 0, 0, "accelerometer in g"},
    {kImuHourOff, "imu_hour_off", kImu, 0, 0, "the IMU's clock is an hour ahead"},
    {kImuStampsRepeat, "imu_stamps_repeat", kImu, 0, 0,
     "every second sample has the stamp of the one before"},
    {kImuStampsStuck, "imu_stamps_stuck", kImu, 0, 0, "all samples have the stamp of the first"},
    {kDots, "dots", kCamera, 0, 0,
     "projector dots fixed in the image, with the disparity of the depth behind them (stereo: of "
     "1.5 m)"},
    {kRightLate, "right_late", kStereo, 0, 0, "the right image is that of the moment before"},
    {kSameEye, "same_eye", kStereo, 0, 0, "the right image is the left one"},
    {kEyesSwapped, "eyes_swapped", kStereo, 0, 0, "left and right image exchanged"},
    {kDepthLate, "depth_late", kRgbd, 0, 0, "the depth image is that of the moment before"},
    {kDepthScaled, "depth_x1.1", kRgbd, 0, 0, "depths are a tenth too large"},
    {kPerson, "person", kCamera, kOnceAt, 0,
     "a person at 1 m walks through the view and stays, covering three quarters of it, again and "
     "again"},
    {kFlicker, "flicker", kCamera, 0, 0, "exposure gain 0.6 and 1.4 in turn, clipped"},
    {kHalfCovered, "half_covered", kCamera, 0, 0,
     "the left half of the (left) lens is covered: grey, blurred, without depth"},
    {kKeyhole, "keyhole", kCamera, kOnceAt, 0,
     "all is dark but a tenth of the width in the middle: little is in sight"},
};

}  // namespace

std::span<const FaultKind> FaultKinds() {
  return kKinds;
}

NamedFault WithUsualSpan(const FaultKind& kind) {
  NamedFault out{kind.id, {}};
  out.span.begin = DurationFromSeconds(kind.begin_s);
  if (kind.end_s > 0) out.span.end = DurationFromSeconds(kind.end_s);
  return out;
}

Result<NamedFault> ParseNamedFault(const std::string& text) {
  const size_t colon = text.find(':');
  const std::string name = text.substr(0, colon);
  const auto kind = std::find_if(std::begin(kKinds), std::end(kKinds),
                                 [&](const FaultKind& k) { return k.name == name; });
  if (kind == std::end(kKinds)) {
    return Error{ErrorCode::kInvalidArgument,
                 "--fault " + text + ": there is no fault of that name; see gw-fault --help"};
  }
  NamedFault out = WithUsualSpan(*kind);
  if (colon == std::string::npos) return out;
  const auto span = tools::ParseSpan("--fault", text.substr(colon + 1));
  if (!span) return span.error();
  out.span = span->span;
  return out;
}

}  // namespace gw::fault
