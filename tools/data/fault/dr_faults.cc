#include <cmath>
#include <limits>
#include <optional>

#include "tools/data/fault/motion_faults.h"
#include "tools/data/fault/sample_faults.h"

namespace gw::fault {
namespace {

using States = std::vector<Edited<DrState>>;

constexpr double kJump = 5;  // m

// T_OB composed anew of increments that `change` may edit; begins anew at a reset.
class Increments {
 public:
  template <typename Change>
  void Apply(DrState& state, const Change& change) {
    const bool continues = last_ && last_->reset_counter == state.reset_counter;
    const DrState in = state;
    T_OB_ = continues ? T_OB_ * change(last_->T_OB.inverse() * in.T_OB) : in.T_OB;
    state.T_OB = T_OB_;
    last_ = in;
  }

 private:
  std::optional<DrState> last_;  // of the input
  SE3 T_OB_;                     // of the output, at last_
};

// The body's x axis points to its left.
SampleFault<DrState> Turned() {
  return [increments = Increments()](bool inside, States& states) mutable {
    const Eigen::Quaterniond R(Eigen::AngleAxisd(-M_PI / 2, Eigen::Vector3d::UnitZ()));
    for (auto& [state, delay] : states) {
      increments.Apply(state, [&](const SE3& T) {
        return inside ? SE3(R, Eigen::Vector3d::Zero()) * T *
                            SE3(R.conjugate(), Eigen::Vector3d::Zero())
                      : T;
      });
      if (!inside) continue;
      state.v_OB_B = R * state.v_OB_B;
      state.w_OB_B = R * state.w_OB_B;
    }
  };
}

SampleFault<DrState> WayTimes(double factor) {
  return [factor, faults = DrFaults()](bool inside, States& states) mutable {
    for (auto& [state, delay] : states) state = faults.Apply(state, inside ? factor : 1, false);
  };
}

SampleFault<DrState> Stuck() {
  return [increments = Increments()](bool inside, States& states) mutable {
    for (auto& [state, delay] : states) {
      increments.Apply(state, [&](const SE3& T) { return inside ? SE3() : T; });
      if (!inside) continue;
      state.v_OB_B.setZero();
      state.w_OB_B.setZero();
    }
  };
}

SampleFault<DrState> Late(DurationUs by) {
  return [by](bool inside, States& states) {
    if (!inside) return;
    for (auto& [state, delay] : states) {
      state.utime = state.utime + by;
      delay = delay + by;
    }
  };
}

SampleFault<DrState> Jump() {
  return [increments = Increments(), done = false](bool inside, States& states) mutable {
    for (auto& [state, delay] : states) {
      increments.Apply(state, [&](const SE3& T) {
        if (!inside || done) return T;
        done = true;
        return T * SE3(Eigen::Quaterniond::Identity(), {kJump, 0, 0});
      });
    }
  };
}

// From the span on the sum counts from where it began, as after a restart of the driver.
SampleFault<DrState> BackToOrigin() {
  return [T_OB_first = std::optional<SE3>(), T_OB_reset = std::optional<SE3>()](
             bool inside, States& states) mutable {
    for (auto& [state, delay] : states) {
      if (!T_OB_first) T_OB_first = state.T_OB;
      if (inside && !T_OB_reset) T_OB_reset = state.T_OB;
      if (T_OB_reset) state.T_OB = *T_OB_first * T_OB_reset->inverse() * state.T_OB;
    }
  };
}

SampleFault<DrState> NoNumbers() {
  return [](bool inside, States& states) {
    if (!inside) return;
    const Eigen::Vector3d nan = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
    for (auto& [state, delay] : states) {
      state.T_OB = SE3(state.T_OB.rotation(), nan);
      state.v_OB_B = nan;
    }
  };
}

}  // namespace

SampleFault<DrState> MakeDrFault(FaultId id) {
  switch (id) {
    case FaultId::kWheelsTurned:
      return Turned();
    case FaultId::kWheelsReversed:
      return WayTimes(-1);
    case FaultId::kWheelsDouble:
      return WayTimes(2);
    case FaultId::kWheelsHalf:
      return WayTimes(0.5);
    case FaultId::kWheelsMillimetres:
      return WayTimes(1000);
    case FaultId::kWheelsLate47:
      return Late(Milliseconds(47));
    case FaultId::kWheelsLate150:
      return Late(Milliseconds(150));
    case FaultId::kWheelsStuck:
      return Stuck();
    case FaultId::kWheelsJump:
      return Jump();
    case FaultId::kWheelsReset:
      return BackToOrigin();
    case FaultId::kWheelsNan:
      return NoNumbers();
    case FaultId::kWheelsDoubled:
      return [](bool inside, States& states) {
        if (inside) states.insert(states.end(), states.begin(), states.end());
      };
    default:
      return nullptr;
  }
}

}  // namespace gw::fault
