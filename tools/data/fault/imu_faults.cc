#include <cmath>
#include <optional>

#include "tools/data/fault/sample_faults.h"

namespace gw::fault {
namespace {

using Samples = std::vector<Edited<ImuSample>>;

constexpr double kDegrees = 180 / M_PI;
constexpr double kBias = 3 / kDegrees;  // rad/s
constexpr double kGravity = 9.80665;    // m/s^2, standard gravity
constexpr DurationUs kHour{3'600'000'000};

template <typename Change>
SampleFault<ImuSample> Each(Change change) {
  return [change](bool inside, Samples& samples) mutable {
    if (!inside) return;
    for (auto& [sample, delay] : samples) change(sample);
  };
}

}  // namespace

SampleFault<ImuSample> MakeImuFault(FaultId id) {
  switch (id) {
    case FaultId::kGyroDegrees:
      return Each([](ImuSample& s) { s.w_I_rad_s *= kDegrees; });
    case FaultId::kGyroBias:
      return Each([](ImuSample& s) { s.w_I_rad_s.array() += kBias; });
    case FaultId::kAccelG:
      return Each([](ImuSample& s) { s.a_I_m_s2 /= kGravity; });
    case FaultId::kImuHourOff:
      return Each([](ImuSample& s) { s.utime = s.utime + kHour; });
    case FaultId::kWheelsAlone:
      return [](bool inside, Samples& samples) {
        if (inside) samples.clear();
      };
    case FaultId::kImuStampsRepeat:
      return Each([stamp = std::optional<Utime>()](ImuSample& s) mutable {
        if (stamp) {
          s.utime = *stamp;
          stamp.reset();
        } else {
          stamp = s.utime;
        }
      });
    case FaultId::kImuStampsStuck:
      return Each([stamp = std::optional<Utime>()](ImuSample& s) mutable {
        if (!stamp) stamp = s.utime;
        s.utime = *stamp;
      });
    default:
      return nullptr;
  }
}

}  // namespace gw::fault
