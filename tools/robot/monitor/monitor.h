// Watches a running system on the bus: who is alive, how fast poses come, what got lost. Writes
// what gw-slam writes for a recording, so that live and offline runs compare.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/contract/health.h"
#include "common/contract/samples.h"
#include "common/contract/tracking.h"
#include "common/core/result.h"
#include "common/process/bus.h"
#include "common/wire/wire.h"

namespace gw::tools {

class Monitor {
 public:
  // The bus must live as long as the monitor.
  static Result<Done> Attach(process::Bus& bus, Monitor& monitor);

  // One line for people: poses, latency, losses, states of the processes.
  std::string StatusLine() const;

  // trajectory.tum (T_WB of every FRAME_POSE), frames.csv (utime, status, inliers, latency from the
  // arrival of the image to the arrival of its pose), pose_times.csv (arrival and utime of every
  // POSE), health.csv (every HEALTH message), ground_truth.tum where there is any. Error kIo.
  Result<Done> Write(const std::string& folder) const;

  int64_t images() const { return static_cast<int64_t>(image_received_.size()); }
  int64_t poses() const { return static_cast<int64_t>(frames_.size()); }
  // Images whose FRAME_POSE never came.
  int64_t images_without_pose() const;
  // Quantile of the latency of images with pose, us; q in [0, 1]. 0 when there is none.
  int64_t LatencyQuantile(double q) const;

  struct Frame {
    FramePose pose;
    int64_t latency_us = 0;  // 0: its image was not seen
  };
  const std::vector<Frame>& frames() const { return frames_; }
  const std::vector<GroundTruth>& truth() const { return truth_; }
  const std::vector<wire::Note>& notes() const { return notes_; }
  // The newest of every process, by name.
  std::map<std::string, Health> NewestHealth() const;

 private:
  struct PoseArrival {
    Utime received;
    Utime utime;
  };
  std::map<int64_t, Utime> image_received_;  // by utime
  std::vector<Frame> frames_;
  std::vector<PoseArrival> pose_arrivals_;
  std::vector<Health> health_;
  std::vector<GroundTruth> truth_;
  std::vector<wire::Note> notes_;
};

}  // namespace gw::tools
