// A recording as an LCM log and a robot configuration.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>

#include "common/config/robot_config.h"
#include "tools/data/import/recording.h"

namespace gw::importer {

struct LogSummary {
  std::map<std::string, int64_t> messages;  // per channel
  Utime begin, end;
  int64_t bytes = 0;
  int64_t broken_frames = 0;  // left out
};

using Progress = std::function<void(size_t images_done, size_t images_total)>;

// Writes all channels in time order; at equal times NOTE, IMU, WHEEL, DR, CAMERA, GROUND_TRUTH.
// seq counts from 1 in each channel, the events carry the messages' utime as receive time. Notes
// and warnings stand at the begin, with the time of the first message. The log appears under its
// name only when it is complete; until then it is FILE.partial, which is removed on failure.
// Frames that cannot be read: with skip_broken left out and counted, also in a NOTE at the end;
// else an error that names all of them.
Result<LogSummary> WriteLog(const Recording& recording, const std::filesystem::path& file,
                            bool skip_broken, const Progress& progress);

// The recording's calibration, everything else at its default. Error: kBadConfig when the
// calibration breaks a rule of the configuration; lists all of them.
Result<RobotConfig> MakeRobotConfig(const Recording& recording);

enum class TrajectoryFrame { kBody, kCamera };
// TUM trajectory `t tx ty tz qx qy qz qw` of the ground truth.
std::string GroundTruthText(const Recording& recording, TrajectoryFrame frame);

}  // namespace gw::importer
