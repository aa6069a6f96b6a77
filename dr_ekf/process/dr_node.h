// gw-dr-ekf as a node: IMU, WHEEL and FRAME_POSE in, DR and POSE out. With source: recorded, DR
// comes from the bus (a replayed log) and only POSE is made.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "common/config/robot_config.h"
#include "common/process/shell.h"
#include "dr_ekf/core/dr_filter.h"
#include "dr_ekf/core/pose_composer.h"
#include "dr_ekf/pose/pose_glide.h"

namespace gw::dr_ekf {

class DrNode : public process::Node {
 public:
  static Result<std::unique_ptr<process::Node>> Create(const RobotConfig& config);

  Result<Done> Start(process::Shell& shell) override;
  bool Step(process::Shell& shell) override;

 private:
  DrNode(std::optional<DrFilter> filter, const GlideRates& rates)
      : filter_(std::move(filter)), glide_(rates) {}

  void Take(const DrFilter::Output& output, process::Shell& shell);
  void PublishPose(const DrState& state, process::Shell& shell);

  std::optional<DrFilter> filter_;  // empty: DR is recorded
  PoseComposer composer_;
  PoseGlide glide_;
  uint32_t pose_resets_ = 0;
  uint32_t first_reset_counter_ = 0;
  DrCounters counters_;  // of the last output, to report what was added
  std::optional<Utime> last_state_;
  std::string found_;  // the newest thing found wrong with the inputs, in words
};

}  // namespace gw::dr_ekf
