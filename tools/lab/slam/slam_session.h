// The whole system in one process: log events in, poses and a map out. The same cores as the live
// processes, joined by BackendSchedule instead of a bus. No clocks: same events, same result.
// (A clock that is handed in to measure with has no influence.)
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/camera/camera_model.h"
#include "common/config/robot_config.h"
#include "common/good_weights/dr_history.h"
#include "common/process/event_log.h"
#include "common/wire/wire.h"
#include "dr_ekf/core/dr_filter.h"
#include "frontend/core/tracking/tracker.h"
#include "tools/lab/slam/backend_schedule.h"
#include "tools/lab/slam/dr_finding.h"

namespace gw::tools {

// What went wrong with single messages; the run goes on.
struct SlamCounters {
  int64_t images = 0;
  int64_t undecodable = 0;
  int64_t dr_refused = 0;  // not newer than the state before
  int64_t map_gaps = 0;    // a map update that did not follow
};

// The map that a run begins with.
struct MapStart {
  backend::Map map;
  std::vector<Keyframe> pending;  // recorded but not taken in yet, see LoadedMap
  backend::MapUse use = backend::MapUse::kGrow;
};

class SlamSession {
 public:
  static Result<SlamSession> Create(const RobotConfig& config, MapStart start = {});

  void Process(const process::LogEvent& event);

  // The same log follows again, with all its times moved by `shift` (> 0). Nothing is known of how
  // the robot came from its end to its begin, so front-end and dead reckoning start anew, as if
  // their processes had been restarted: the reset counter moves on, no DR edge crosses the seam,
  // and the pose is found again in the map. Back-end and map go on.
  void BeginLap(DurationUs shift);
  // After the last event: lets the back-end finish.
  void Finish();

  // From now on notes how long the front-end takes for each image, and each local BA; now_us: a
  // monotonic clock.
  void MeasureTimes(const std::function<int64_t()>& now_us) {
    now_us_ = now_us;
    backend_.MeasureLocalBa(now_us);
  }

  // From now on shows everything that the DR filter gives out; it has no influence.
  void WatchDr(std::function<void(const dr_ekf::DrFilter::Output&)> watch) {
    watch_dr_ = std::move(watch);
  }

  // From now on shows every image with its pose, and every update of the map, as the front-end gets
  // them; it has no influence.
  struct Watch {
    std::function<void(const CameraFrame& frame, const FramePose& pose)> image;
    std::function<void(const MapUpdate& update)> map;
  };
  void WatchMapping(Watch watch) { watch_ = std::move(watch); }

  // Every image's pose, as it was published.
  const std::vector<FramePose>& frames() const { return frames_; }
  // Details of the same images, without their features.
  const std::vector<FrameDetail>& details() const { return details_; }
  // The same image's pose expressed by the final keyframes.
  SE3 FinalPose(const FramePose& frame) const;
  // Per image: T_OB of dead reckoning alone, as far as it was known when the image came; whatever
  // the variant. Empty where dead reckoning had nothing to say; jumps where its process restarted.
  const std::vector<std::optional<SE3>>& dr_poses() const { return dr_poses_; }
  // Per image, us; empty without MeasureTimes().
  const std::vector<int64_t>& tracking_us() const { return tracking_us_; }
  const std::vector<MeasuredTime>& local_ba_times() const { return backend_.local_ba_times(); }
  // In words: why healthy vision contradicts dead reckoning at the end; empty where it does not, or
  // no constant explains it.
  std::string dr_fault() const { return frontend::Describe(stages_.tracker.dr_fault()); }
  // In words: what is wrong with the lengths that the camera tells; empty for nothing.
  std::string length_fault() const { return frontend::Describe(stages_.tracker.length_fault()); }
  // In words: what is wrong with the images themselves, or was last; empty for nothing.
  std::string view_fault() const { return std::string(frontend::Describe(view_fault_)); }
  const backend::Mapper& mapper() const { return backend_.mapper(); }
  // Newest keyframe of the map that the run began with; those after it are its own.
  KeyframeId newest_before() const { return newest_before_; }
  const SlamCounters& counters() const { return counters_; }
  const std::optional<dr_ekf::DrCounters>& dr_counters() const { return dr_counters_; }
  // What the DR filter found wrong with its inputs, and the time of its first state.
  const std::vector<DrFinding>& dr_found() const { return dr_found_; }
  Utime first_dr() const { return first_dr_; }
  bool dr_synthetic() const { return dr_synthetic_; }
  const RectifiedCamera& camera() const { return geometry_.rectified; }

 private:
  // What a lap begins with.
  struct Stages {
    frontend::Tracker tracker;
    std::optional<dr_ekf::DrFilter> dr_filter;
  };
  static Result<Stages> MakeStages(const RobotConfig& config, const CameraGeometry& geometry);

  SlamSession(const RobotConfig& config, const CameraGeometry& geometry, Stages stages,
              BackendSchedule backend);

  Utime OnLap(Utime utime) const { return utime + lap_shift_; }
  void ProcessImage(const CameraFrame& frame);
  void FollowLengths(double length_factor);
  void ProcessDr(DrState state);
  void Deliver(const std::vector<MapUpdate>& updates);
  void Deliver(const dr_ekf::DrFilter::Output& output);

  RobotConfig config_;
  CameraGeometry geometry_;
  Stages stages_;
  BackendSchedule backend_;
  KeyframeId newest_before_;
  DrHistory dr_;
  DurationUs lap_shift_;
  uint32_t reset_base_ = 0;    // added to the reset counter: each lap is a new life of DR
  uint32_t newest_reset_ = 0;  // as given to the front-end
  std::function<int64_t()> now_us_;
  std::function<void(const dr_ekf::DrFilter::Output&)> watch_dr_;
  Watch watch_;
  std::vector<FramePose> frames_;
  double length_factor_ = 1;  // in which they are told
  std::vector<FrameDetail> details_;
  std::vector<std::optional<SE3>> dr_poses_;
  std::vector<int64_t> tracking_us_;
  SlamCounters counters_;
  std::optional<dr_ekf::DrCounters> dr_counters_;
  std::vector<DrFinding> dr_found_;
  Utime first_dr_, newest_dr_;  // states of the filter; 0: none
  bool dr_synthetic_ = false;
  frontend::ViewFault view_fault_ = frontend::ViewFault::kNone;
};

}  // namespace gw::tools
