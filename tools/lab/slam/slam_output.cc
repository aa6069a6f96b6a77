#include "tools/lab/slam/slam_output.h"

#include <algorithm>
#include <array>
#include <cinttypes>
#include <filesystem>

#include "common/config/writer.h"
#include "common/contract/tracking_names.h"
#include "common/core/version.h"
#include "tools/data/files/format.h"
#include "tools/data/files/hash_file.h"
#include "tools/data/files/json.h"
#include "tools/data/files/text_file.h"

namespace gw::tools {
namespace {

std::string FramesTable(const std::vector<FramePose>& frames) {
  std::string out =
      "utime,status,n_det,n_trk,n_inliers,q,alpha,dr_share,map_revision,latency_us,"
      "x,y,z,qx,qy,qz,qw,reason\n";
  for (const FramePose& f : frames) {
    const Eigen::Vector3d& p = f.T_WB.translation();
    const Eigen::Quaterniond& q = f.T_WB.rotation();
    out += Format("%" PRId64 ",%s,%d,%d,%d,%.6f,%.6g,%.6f,%" PRId64 ",%" PRId64
                  ",%.9f,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f,%s\n",
                  f.utime.us, StatusName(f.status), f.num_detected, f.num_tracked, f.num_inliers,
                  f.q, f.alpha, f.dr_share, f.map_revision, f.latency_us, p.x(), p.y(), p.z(),
                  q.x(), q.y(), q.z(), q.w(), ReasonName(f.reason));
  }
  return out;
}

// What dead reckoning counted for in each image: translation and rotation, by the law of alpha and
// after its bound.
std::string DrPriorTable(const std::vector<FrameDetail>& details) {
  std::string out = "utime,q,q_close,alpha_t,alpha_r,bounded_t,bounded_r\n";
  for (const FrameDetail& p : details) {
    out += Format("%" PRId64 ",%.6f,%.6f,%.6g,%.6g,%.6g,%.6g\n", p.utime.us, p.q, p.q_close,
                  p.alpha_translation, p.alpha_rotation, p.bounded_translation, p.bounded_rotation);
  }
  return out;
}

// Upper triangles, row by row: c of each pose of trajectory.tum, m of the motion over the motion_us
// before it (all 0 where there is none).
std::string CovarianceTable(const SlamSession& session) {
  const auto fields = [](const char* format, const auto& value) {
    std::string out;
    for (int i = 0; i < 6; ++i) {
      for (int j = i; j < 6; ++j) out += value(format, i, j);
    }
    return out;
  };
  const auto name = [](const char* format, int i, int j) { return Format(format, i, j); };
  std::string out = "utime" + fields(",c%d%d", name) + ",motion_us" + fields(",m%d%d", name) + '\n';
  for (const FramePose& f : session.frames()) {
    out += Format("%" PRId64, f.utime.us);
    out += fields(",%.9g", [&](const char* format, int i, int j) {
      return Format(format, f.cov_T_WB(i, j));
    });
    out += Format(",%" PRId64, f.motion_us);
    out += fields(",%.9g", [&](const char* format, int i, int j) {
      return Format(format, f.cov_motion(i, j));
    });
    out += '\n';
  }
  return out;
}

constexpr std::array kStatuses = {TrackingStatus::kInitializing, TrackingStatus::kTracking,
                                  TrackingStatus::kDegraded,     TrackingStatus::kDrOnly,
                                  TrackingStatus::kRecovering,   TrackingStatus::kLost};

Json StatusCounts(const std::vector<FramePose>& frames, size_t begin, size_t end) {
  Json out = Json::object();
  for (const TrackingStatus status : kStatuses) {
    out[StatusName(status)] = std::count_if(frames.begin() + static_cast<std::ptrdiff_t>(begin),
                                            frames.begin() + static_cast<std::ptrdiff_t>(end),
                                            [&](const FramePose& f) { return f.status == status; });
  }
  return out;
}

Json MapJson(const backend::Mapper& mapper) {
  const backend::MapperCounters& c = mapper.counters();
  return {{"revision", mapper.map().revision()},
          {"keyframes", mapper.map().keyframes().size()},
          {"landmarks", mapper.map().num_landmarks()},
          {"keyframes_inserted", c.keyframes_inserted},
          {"keyframes_rejected", c.keyframes_rejected},
          {"keyframes_culled", c.keyframes_culled},
          {"keyframes_withdrawn", c.keyframes_withdrawn},
          {"landmarks_created", c.landmarks_created},
          {"landmarks_triangulated", c.landmarks_triangulated},
          {"landmarks_merged", c.landmarks_merged},
          {"landmarks_culled", c.landmarks_culled},
          {"local_ba_applied", c.local_ba_applied},
          {"local_ba_failed", c.local_ba_failed}};
}

Json LoopsJson(const backend::Mapper& mapper) {
  const backend::LoopCounters& loops = mapper.loop_counters();
  return {{"candidates", loops.candidates},
          {"fits", loops.fits},
          {"inconsistent", loops.inconsistent},
          {"refused_by_dr", loops.refused_by_dr},
          {"closed", loops.closed},
          {"removed", loops.removed},
          {"global_ba_applied", mapper.counters().global_ba_applied},
          {"global_ba_failed", mapper.counters().global_ba_failed}};
}

Json LapsJson(const RunDescription& run, const SlamSession& session) {
  Json out = Json::array();
  for (const Lap& lap : run.laps.laps) {
    out.push_back({{"images", lap.frames_end - lap.frames_begin},
                   {"poses", StatusCounts(session.frames(), lap.frames_begin, lap.frames_end)},
                   {"keyframes_inserted", lap.keyframes_inserted},
                   {"keyframes", lap.keyframes},
                   {"landmarks", lap.landmarks},
                   {"revision", lap.revision}});
  }
  return out;
}

std::string Report(const RobotConfig& config, const RunDescription& run,
                   const SlamSession& session) {
  return JsonDocument({{"program", "gw-slam"},
                       {"version", Version()},
                       {"log", run.log_name},
                       {"robot", config.robot.name},
                       {"config_hash", HashText(ConfigHash(config))},
                       {"variant", run.variant},
                       {"seed", run.seed},
                       {"frame", run.frame == OutputFrame::kBody ? "body" : "camera"},
                       {"dr_synthetic", session.dr_synthetic()},
                       {"images", session.counters().images},
                       {"poses", StatusCounts(session.frames(), 0, session.frames().size())},
                       {"log_skipped_bytes", run.laps.log.skipped_bytes},
                       {"log_truncated", run.laps.log.truncated},
                       {"time_steps", TimeStepsJson(run.laps.log.time_steps)},
                       {"messages_undecodable", session.counters().undecodable},
                       {"dr_refused", session.counters().dr_refused},
                       {"dr_found", FoundJson(session.dr_found())},
                       {"dr_fault", session.dr_fault()},
                       {"length_fault", session.length_fault()},
                       {"view_fault", session.view_fault()},
                       {"map_gaps", session.counters().map_gaps},
                       {"map", MapJson(session.mapper())},
                       {"loops", LoopsJson(session.mapper())},
                       {"laps", LapsJson(run, session)}});
}

// In times of the log, so that each lap can be held against the same reference.
Result<Done> WriteLap(const std::string& folder, const Lap& lap, const SlamSession& session,
                      const SE3& T_BOut) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    return Error{ErrorCode::kIo, folder + ": cannot be made: " + error.message()};
  }
  std::string live, final, keyframes;
  for (size_t i = lap.frames_begin; i < lap.frames_end; ++i) {
    const FramePose& f = session.frames()[i];
    live += TumLine(f.utime - lap.shift, f.T_WB * T_BOut);
    final += TumLine(f.utime - lap.shift, session.FinalPose(f) * T_BOut);
  }
  for (const TimedKeyframe& keyframe : lap.poses) {
    keyframes += TumLine(keyframe.utime, keyframe.T_WC * session.camera().T_BC.inverse() * T_BOut);
  }
  Result<Done> written = WriteTextFile(folder + "/trajectory.tum", live);
  if (written) written = WriteTextFile(folder + "/trajectory_final.tum", final);
  if (written) written = WriteTextFile(folder + "/keyframes.tum", keyframes);
  return written;
}

}  // namespace

Json TimeStepsJson(const std::vector<TimeStep>& steps) {
  Json out = Json::array();
  for (const TimeStep& step : steps) {
    out.push_back({{"event", step.index}, {"from_us", step.from.us}, {"to_us", step.to.us}});
  }
  return out;
}

std::string TimingTable(const SlamSession& session) {
  std::string out = "utime,tracking_us\n";
  for (size_t i = 0; i < session.tracking_us().size(); ++i) {
    out +=
        Format("%" PRId64 ",%" PRId64 "\n", session.frames()[i].utime.us, session.tracking_us()[i]);
  }
  return out;
}

Result<Done> WriteOutputs(const std::string& folder, const RobotConfig& config,
                          const RunDescription& run, const SlamSession& session) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    return Error{ErrorCode::kIo, folder + ": cannot be made: " + error.message()};
  }
  // The camera of the output is the left one as mounted, before rectification.
  const SE3 T_BOut = run.frame == OutputFrame::kCamera ? config.calibration.camera.T_BC : SE3();
  std::string live;
  std::string final;
  std::string dr;
  for (size_t i = 0; i < session.frames().size(); ++i) {
    const FramePose& f = session.frames()[i];
    live += TumLine(f.utime, f.T_WB * T_BOut);
    final += TumLine(f.utime, session.FinalPose(f) * T_BOut);
    if (const auto& T_OB = session.dr_poses()[i]) dr += TumLine(f.utime, *T_OB * T_BOut);
  }
  const SE3 T_COut = session.camera().T_BC.inverse() * T_BOut;
  std::string keyframes;
  const auto& map = session.mapper().map().keyframes();
  for (auto it = map.upper_bound(session.newest_before()); it != map.end(); ++it) {
    keyframes += TumLine(it->second.frame.utime, it->second.frame.T_WC * T_COut);
  }
  const std::pair<const char*, std::string> files[] = {
      {"trajectory.tum", live},
      {"trajectory_final.tum", final},
      {"keyframes.tum", keyframes},
      {"dr.tum", dr},
      {"frames.csv", FramesTable(session.frames())},
      {"covariance.csv", CovarianceTable(session)},
      {"dr_prior.csv", DrPriorTable(session.details())},
      {"report.json", Report(config, run, session)}};
  for (const auto& [name, text] : files) {
    const Result<Done> written = WriteTextFile(folder + "/" + name, text);
    if (!written) return written.error();
  }
  if (run.laps.laps.size() < 2) return Done{};
  for (size_t i = 0; i < run.laps.laps.size(); ++i) {
    const std::string lap_folder = folder + "/lap" + std::to_string(i + 1);
    const auto written = WriteLap(lap_folder, run.laps.laps[i], session, T_BOut);
    if (!written) return written.error();
  }
  return Done{};
}

}  // namespace gw::tools
