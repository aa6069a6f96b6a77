#include <cmath>
#include <limits>
#include <optional>

#include "tools/data/fault/motion_faults.h"
#include "tools/data/fault/sample_faults.h"
#include "tools/data/fault/wheel_resampler.h"

namespace gw::fault {
namespace {

using Samples = std::vector<Edited<WheelSample>>;

constexpr double kJump = 5;  // m

// `change` for every sample inside the span.
template <typename Change>
SampleFault<WheelSample> Each(const Change& change) {
  return [change](bool inside, Samples& samples) {
    if (!inside) return;
    for (auto& [sample, delay] : samples) change(sample);
  };
}

// Both wheels count `factor` times: increments and ticks.
SampleFault<WheelSample> Counts(double factor) {
  return [factor, faults = WheelFaults()](bool inside, Samples& samples) mutable {
    for (auto& [sample, delay] : samples) {
      const double dy_m = sample.dy_m;
      sample = faults.Apply(sample, inside ? factor : 1, false);
      // An arc whose way and turn are both negated keeps its part to the side.
      if (inside && factor < 0) sample.dy_m = dy_m;
    }
  };
}

SampleFault<WheelSample> Late(DurationUs by) {
  return [by](bool inside, Samples& samples) {
    if (!inside) return;
    for (auto& [sample, delay] : samples) {
      sample.utime = sample.utime + by;
      sample.utime_begin = sample.utime_begin + by;
      delay = delay + by;
    }
  };
}

SampleFault<WheelSample> StuckHeading() {
  return [held = std::optional<double>()](bool inside, Samples& samples) mutable {
    if (!inside) return;
    for (auto& [sample, delay] : samples) {
      if (sample.has_heading) {
        if (!held) held = sample.heading_rad;
        sample.heading_rad = *held;
      } else {
        sample.dx_m = std::copysign(std::hypot(sample.dx_m, sample.dy_m), sample.dx_m);
        sample.dy_m = sample.dyaw_rad = 0;
      }
    }
  };
}

SampleFault<WheelSample> Jump() {
  return [done = false](bool inside, Samples& samples) mutable {
    if (!inside || done || samples.empty()) return;
    samples.front().sample.dx_m += kJump;
    done = true;
  };
}

SampleFault<WheelSample> BackToOrigin() {
  return [T_OB = SE3(), done = false](bool inside, Samples& samples) mutable {
    if (done) return;
    for (auto& [sample, delay] : samples) {
      if (!inside) {
        T_OB = T_OB * SE3(ExpSO3({0, 0, sample.dyaw_rad}), {sample.dx_m, sample.dy_m, 0});
        continue;
      }
      const SE3 T_BO = T_OB.inverse();
      sample.dx_m = T_BO.translation().x();
      sample.dy_m = T_BO.translation().y();
      sample.dyaw_rad = LogSO3(T_BO.rotation()).z();
      done = true;
      return;
    }
  };
}

SampleFault<WheelSample> Resampled(const WheelResampler& by) {
  return [resampler = by](bool inside, Samples& samples) mutable {
    Samples out;
    for (const auto& [sample, delay] : samples) {
      if (!inside) {
        out.push_back({sample, delay});
        continue;
      }
      for (const WheelSample& made : resampler.Push(sample)) out.push_back({made, delay});
    }
    samples = std::move(out);
  };
}

}  // namespace

SampleFault<WheelSample> MakeWheelFault(FaultId id) {
  switch (id) {
    case FaultId::kWheelsTurned:
      return Each([](WheelSample& s) {
        const double dx_m = s.dx_m;
        s.dx_m = s.dy_m;
        s.dy_m = -dx_m;
      });
    case FaultId::kWheelsReversed:
      return Counts(-1);
    case FaultId::kWheelsDouble:
      return Counts(2);
    case FaultId::kWheelsHalf:
      return Counts(0.5);
    case FaultId::kWheelsStuck:
      return Counts(0);
    case FaultId::kWheelsMillimetres:
      return Each([](WheelSample& s) {
        s.dx_m *= 1000;
        s.dy_m *= 1000;
      });
    case FaultId::kWheelsLate47:
      return Late(Milliseconds(47));
    case FaultId::kWheelsLate150:
      return Late(Milliseconds(150));
    case FaultId::kWheelsResampled:
      return Resampled(WheelResampler(Milliseconds(50), Milliseconds(10)));
    case FaultId::kWheelsAlone:
      return Resampled(WheelResampler(Milliseconds(200), {}));
    case FaultId::kHeadingStuck:
      return StuckHeading();
    case FaultId::kWheelsJump:
      return Jump();
    case FaultId::kWheelsReset:
      return BackToOrigin();
    case FaultId::kWheelsNan:
      return Each([](WheelSample& s) {
        s.dx_m = s.dy_m = s.dyaw_rad = std::numeric_limits<double>::quiet_NaN();
      });
    case FaultId::kWheelsDoubled:
      return [](bool inside, Samples& samples) {
        if (inside) samples.insert(samples.end(), samples.begin(), samples.end());
      };
    default:
      return nullptr;
  }
}

}  // namespace gw::fault
