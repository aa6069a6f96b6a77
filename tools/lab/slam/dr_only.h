// Dead reckoning alone: IMU and WHEEL (or recorded DR) of a log through the DR filter, without a
// single image, and the wheels' own sum beside it.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/config/robot_config.h"
#include "common/contract/samples.h"
#include "common/process/event_log.h"
#include "dr_ekf/core/dr_filter.h"
#include "tools/data/log/log_clock.h"
#include "tools/lab/slam/dr_finding.h"

namespace gw::tools {

// What the files and the verdict need of a published state; a log of hours has millions of them.
struct DrPose {
  Utime utime;
  uint32_t reset_counter = 0;
  SE3 T_OB;
  bool slip = false;
  size_t wheels_before = 0;  // wheel samples in the log before it was published
};

struct GyroReading {
  Utime utime;  // of the IMU's clock
  Eigen::Vector3d w_I_rad_s = Eigen::Vector3d::Zero();
  size_t wheels_before = 0;  // wheel samples in the log before it
};

// Once a second: covariance of the pose, and of the motion over the second before.
struct DrCovarianceRow {
  Utime utime;
  Matrix6d cov_T_OB = Matrix6d::Zero();  // m^2, rad^2; right perturbation
  DurationUs motion;                     // 0: a reset lies in the second before
  Matrix6d cov_motion = Matrix6d::Zero();
};

struct DrOnlyRun {
  std::vector<DrPose> poses;  // every state that the filter published; times of the camera
  std::vector<DrCovarianceRow> covariance;
  std::vector<DrFinding> found;
  std::optional<DrState> last;
  std::optional<dr_ekf::DrCounters> counters;  // none when the log's own DR is passed on
  // The samples as the log has them, in its order.
  std::vector<GyroReading> gyro;
  std::vector<WheelSample> wheels;
  std::map<std::string, int64_t> messages;     // per channel of the log, all channels
  std::map<std::string, int64_t> undecodable;  // of those that dead reckoning reads
  LogClock clock;
};

// The same, event by event.
class DrOnlyRunner {
 public:
  // Error: kBadConfig when the configuration has nothing to reckon with (neither IMU nor wheels, no
  // recorded DR).
  static Result<DrOnlyRunner> Create(const RobotConfig& config);
  DrOnlyRunner(DrOnlyRunner&&) noexcept;
  ~DrOnlyRunner();

  void Add(const process::LogEvent& event);
  // What came of the events so far; the runner must not be used afterwards.
  DrOnlyRun Take();

 private:
  class Impl;
  explicit DrOnlyRunner(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// A whole log. Error: as of DrOnlyRunner; kIo when reading fails half-way.
Result<DrOnlyRun> RunDrOnly(process::EventLogReader& log, const RobotConfig& config,
                            const std::function<void()>& after_event = nullptr);

}  // namespace gw::tools
