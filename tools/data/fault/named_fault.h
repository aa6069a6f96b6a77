// Faults with a name: what drivers, cables, mountings and people do to a stream of sensor messages.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "common/core/result.h"
#include "tools/data/log/span.h"

namespace gw::fault {

enum class FaultId {
  // Wheels, and dead reckoning where the log has it in place of wheels.
  kWheelsTurned,
  kWheelsReversed,
  kWheelsDouble,
  kWheelsHalf,
  kWheelsMillimetres,
  kWheelsLate47,
  kWheelsLate150,
  kWheelsResampled,
  kWheelsAlone,
  kWheelsStuck,
  kHeadingStuck,
  kWheelsJump,
  kWheelsReset,
  kWheelsNan,
  kWheelsDoubled,
  // IMU.
  kGyroDegrees,
  kGyroBias,
  kAccelG,
  kImuHourOff,
  kImuStampsRepeat,
  kImuStampsStuck,
  // Camera.
  kDots,
  kRightLate,
  kSameEye,
  kEyesSwapped,
  kDepthLate,
  kDepthScaled,
  kPerson,
  kFlicker,
  kHalfCovered,
  kKeyhole,
};

// Which logs a fault concerns.
enum class FaultTarget { kWheels, kWheelsAndDr, kImu, kCamera, kStereo, kRgbd };

struct FaultKind {
  FaultId id;
  std::string_view name;
  FaultTarget target;
  // When it happens if no span is given, s since the begin of the log; end_s = 0: until the end.
  double begin_s;
  double end_s;
  std::string_view text;
};

// All of them, in the order of FaultId.
std::span<const FaultKind> FaultKinds();

struct NamedFault {
  FaultId id = FaultId::kWheelsTurned;
  tools::Span span;

  const FaultKind& kind() const { return FaultKinds()[static_cast<size_t>(id)]; }
};

// The fault of this kind when nothing is said of its time.
NamedFault WithUsualSpan(const FaultKind& kind);

// "NAME" or "NAME:T0:T1" (s since the begin of the log, each may be empty). Error kInvalidArgument:
// a name that there is not, or no span.
Result<NamedFault> ParseNamedFault(const std::string& text);

}  // namespace gw::fault
