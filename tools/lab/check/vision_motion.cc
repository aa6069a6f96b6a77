#include "tools/lab/check/vision_motion.h"

#include "tools/lab/slam/run_log.h"
#include "tools/lab/slam/slam_session.h"

namespace gw::check {

Result<VisionRun> RunVision(const std::string& log, RobotConfig config) {
  config.frontend.variant = Variant::kNone;
  auto session = tools::SlamSession::Create(config);
  if (!session) return session.error();
  auto reader = process::EventLogReader::Open(log);
  if (!reader) return reader.error();
  const auto clock = tools::RunLog(*reader, {}, &*session);
  if (!clock) return clock.error();
  VisionRun run;
  for (const FramePose& frame : session->frames()) {
    const bool seen =
        frame.status == TrackingStatus::kTracking || frame.status == TrackingStatus::kDegraded;
    if (!seen && !run.poses.empty()) ++run.blind;
    if (!seen && run.poses.empty()) continue;
    run.poses.push_back({frame.utime, seen ? session->FinalPose(frame) : frame.T_WB, seen});
  }
  return run;
}

}  // namespace gw::check
