#include "tools/lab/slam/dr_report.h"

#include <algorithm>
#include <cinttypes>
#include <cmath>
#include <filesystem>

#include "common/config/writer.h"
#include "common/core/version.h"
#include "common/wire/channels.h"
#include "tools/data/files/format.h"
#include "tools/data/files/hash_file.h"
#include "tools/data/files/json.h"
#include "tools/data/files/text_file.h"

namespace gw::tools {
namespace {

constexpr double kDegrees = 180 / M_PI;
// Bars of the verdict, as a user of a wheeled robot on a floor may expect them; they steer nothing.
constexpr double kWayTolerance = 0.02;       // of the wheels' way
constexpr double kTurnToleranceDeg = 3;      // of the gyro's turn, for ten minutes and less
constexpr double kTurnDriftDegPerMin = 0.3;  // a MEMS gyro's bias between standstills
constexpr double kHeightTolerance = 0.2;     // m
constexpr double kUnusedTolerance = 0.01;    // of a stream's messages
constexpr size_t kSlipSpansInText = 5;

int64_t MessagesOn(const DrOnlyRun& run, const char* channel) {
  const auto entry = run.messages.find(channel);
  return entry == run.messages.end() ? 0 : entry->second;
}

// One sensor stream: what came, what was used, and why the rest was not.
void JudgeStream(const DrOnlyRun& run, const char* channel, bool calibrated, int64_t used,
                 DrVerdict* verdict) {
  const int64_t messages = MessagesOn(run, channel);
  const auto undecodable = run.undecodable.find(channel);
  const int64_t bad = undecodable == run.undecodable.end() ? 0 : undecodable->second;
  verdict->facts.push_back(Format("%s: %" PRId64 " messages, %" PRId64 " used, %" PRId64
                                  " undecodable",
                                  channel, messages, used, bad));
  if (messages > 0 && !calibrated) {
    verdict->problems.push_back(
        Format("%s is not used: the log has it, but the configuration says that the robot has none",
               channel));
  } else if (messages == 0 && calibrated) {
    verdict->problems.push_back(
        Format("%s is not used: the configuration has it, but the log holds no message", channel));
  } else if (calibrated && static_cast<double>(messages - used) >
                               kUnusedTolerance * static_cast<double>(messages)) {
    verdict->problems.push_back(Format("%s: %" PRId64 " of %" PRId64
                                       " messages were not used; the counters say why",
                                       channel, messages - used, messages));
  }
}

void JudgeStreams(const DrOnlyRun& run, const RobotConfig& config, DrVerdict* verdict) {
  if (!run.counters) {
    verdict->facts.push_back(Format("DR: %" PRId64 " messages of the log passed on (dr_ekf.source: "
                                    "recorded); no filter ran",
                                    MessagesOn(run, wire::kDr)));
    return;
  }
  const dr_ekf::DrCounters& c = *run.counters;
  JudgeStream(run, wire::kImu, config.calibration.imu.present, c.imu_used, verdict);
  JudgeStream(run, wire::kWheel, config.calibration.wheel.present, c.wheel_used, verdict);
  verdict->facts.push_back(Format("refused samples: %" PRId64 " invalid, %" PRId64 " late, %" PRId64
                                  " repeated or overlapping, "
                                  "%" PRId64 " from the future, %" PRId64 " absurd; %" PRId64
                                  " came late and were used",
                                  c.rejected_invalid, c.rejected_late, c.rejected_non_monotonic,
                                  c.rejected_future, c.rejected_absurd, c.reordered));
}

void JudgeWay(const DrMotion& motion, DrVerdict* verdict) {
  if (!motion.wheel_way_m) {
    verdict->facts.push_back(Format("way: %.3f m by dead reckoning; no wheels", motion.way_m));
    return;
  }
  const double wheels = *motion.wheel_way_m;
  const double difference = wheels > 0 ? motion.way_m / wheels - 1 : 0;
  verdict->facts.push_back(
      Format("way: %.3f m by dead reckoning, %.3f m by the wheels' own sum (%+.2f %%)",
             motion.way_m, wheels, 100 * difference));
  // A robot that only turns on the spot drives no way to compare.
  if (wheels > 1 && std::abs(difference) > kWayTolerance) {
    verdict->problems.push_back(Format(
        "the way differs from the wheels' by %+.1f %%: slip, a wrong scale of the wheels, or "
        "samples that were refused",
        100 * difference));
  }
  if (motion.uncovered.us > 0) {
    verdict->facts.push_back(Format("not covered by dead reckoning: %.3f s of %.3f s of the wheels",
                                    motion.uncovered.seconds(),
                                    (motion.covered + motion.uncovered).seconds()));
  }
}

void JudgeHeading(const DrMotion& motion, DrVerdict* verdict) {
  std::string text =
      Format("heading: turned by %+.2f deg in sum by dead reckoning", kDegrees * motion.turn_rad);
  if (motion.wheel_turn_rad) {
    text += Format(", %+.2f by the wheels' own sum", kDegrees * *motion.wheel_turn_rad);
  }
  verdict->facts.push_back(text);
  if (!motion.gyro) return;
  const GyroWitness& gyro = *motion.gyro;
  const double off = kDegrees * std::abs(gyro.dr_turn_rad - gyro.turn_rad);
  verdict->facts.push_back(Format(
      "gyro alone: turned by %+.2f deg (bias of %zu standstills), where dead reckoning says %+.2f "
      "and the wheels %+.2f",
      kDegrees * gyro.turn_rad, gyro.standstills.size(), kDegrees * gyro.dr_turn_rad,
      kDegrees * gyro.wheel_turn_rad));
  // Without a standstill the gyro's bias is unknown, and its integral no witness.
  if (gyro.standstills.empty()) return;
  const double bar =
      std::max(kTurnToleranceDeg, kTurnDriftDegPerMin * motion.covered.seconds() / 60);
  if (off > bar) {
    verdict->problems.push_back(
        Format("the heading differs from the gyro's integral by %.1f deg", off));
  }
}

void JudgeShape(const DrOnlyRun& run, const DrMotion& motion, DrVerdict* verdict) {
  const double range = motion.height_max_m - motion.height_min_m;
  verdict->facts.push_back(Format("height: %.3f to %.3f m; largest tilt %.2f deg",
                                  motion.height_min_m, motion.height_max_m,
                                  kDegrees * motion.tilt_max_rad));
  if (!run.wheels.empty() && range > kHeightTolerance) {
    verdict->problems.push_back(
        Format("height wanders by %.2f m: right on a ramp, wrong on a floor", range));
  }
}

void JudgeSlip(const DrOnlyRun& run, DrVerdict* verdict) {
  const std::vector<SlipSpan> spans = SlipSpans(run.poses);
  if (spans.empty()) {
    verdict->facts.emplace_back("slip: none flagged");
    return;
  }
  const Utime begin = run.poses.front().utime;
  DurationUs total;
  std::string text;
  for (size_t i = 0; i < spans.size(); ++i) {
    total = total + (spans[i].end - spans[i].begin);
    if (i >= kSlipSpansInText) continue;
    text += Format("%s%.2f-%.2f", i == 0 ? "" : ", ", (spans[i].begin - begin).seconds(),
                   (spans[i].end - begin).seconds());
  }
  if (spans.size() > kSlipSpansInText) text += ", ...";
  verdict->facts.push_back(
      Format("slip: flagged %zu times, %.2f s in all (at s: ", spans.size(), total.seconds()) +
      text + ")");
}

void JudgeFindings(const DrOnlyRun& run, DrVerdict* verdict) {
  for (const DrFinding& found : run.found) {
    const Utime first = run.poses.empty() ? found.utime : run.poses.front().utime;
    verdict->problems.push_back(Describe(found, first));
  }
}

// Where the counter moved on; the first state may have any value.
int64_t Resets(const std::vector<DrPose>& poses) {
  int64_t resets = 0;
  for (size_t i = 1; i < poses.size(); ++i) {
    if (poses[i].reset_counter != poses[i - 1].reset_counter) ++resets;
  }
  return resets;
}

void JudgeContinuity(const DrOnlyRun& run, const WheelSum& sum, const DrRunDescription& description,
                     DrVerdict* verdict) {
  const int64_t resets = Resets(run.poses);
  verdict->facts.push_back(Format("resets: %" PRId64, resets));
  if (resets > 0) {
    verdict->problems.push_back(Format(
        "dead reckoning began anew %" PRId64 " times: T_OB is not continuous there", resets));
  }
  if (sum.gaps > 0) {
    verdict->problems.push_back(Format("%" PRId64
                                       " wheel samples do not begin where the one before ended: "
                                       "the way between is lost",
                                       sum.gaps));
  }
  for (const TimeStep& step : run.clock.steps()) verdict->problems.push_back(Describe(step));
  if (description.log_skipped_bytes > 0 || description.log_truncated) {
    verdict->problems.push_back(Format(
        "the log is damaged: %" PRId64 " bytes skipped%s; see gw-log check",
        description.log_skipped_bytes, description.log_truncated ? ", last event cut off" : ""));
  }
}

void JudgeEstimates(const DrOnlyRun& run, const RobotConfig& config, DrVerdict* verdict) {
  if (!run.last) return;
  const DrState& s = *run.last;
  verdict->facts.push_back(Format("scales: way %.4f +- %.4f, turn %.4f +- %.4f (true / measured)",
                                  s.wheel_scale, s.way_scale_sigma, s.turn_scale,
                                  s.turn_scale_sigma));
  verdict->facts.push_back(
      Format("biases: gyro %.5f %.5f %.5f rad/s, accelerometer %.4f %.4f %.4f m/s^2",
             s.gyro_bias_rad_s.x(), s.gyro_bias_rad_s.y(), s.gyro_bias_rad_s.z(),
             s.accel_bias_m_s2.x(), s.accel_bias_m_s2.y(), s.accel_bias_m_s2.z()));
  verdict->facts.push_back(
      Format("clock offsets: IMU %.6f s, wheels %.6f s, as configured; not estimated here",
             config.calibration.imu.time_offset_s, config.calibration.wheel.time_offset_s));
  const double along = std::sqrt(s.cov_T_OB(0, 0) + s.cov_T_OB(1, 1));
  verdict->facts.push_back(Format("doubt at the end: %.3f m, heading %.2f deg (one sigma)", along,
                                  kDegrees * std::sqrt(s.cov_T_OB(5, 5))));
}

std::string UpperTriangle(const Matrix6d& m) {
  std::string out;
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) out += Format(",%.9g", m(i, j));
  }
  return out;
}

std::string CovarianceTable(const std::vector<DrCovarianceRow>& rows) {
  std::string out = "utime";
  const auto names = [&](char letter) {
    for (int i = 0; i < 6; ++i) {
      for (int j = i; j < 6; ++j) out += Format(",%c%d%d", letter, i, j);
    }
  };
  names('c');
  out += ",motion_us";
  names('m');
  out += '\n';
  for (const DrCovarianceRow& row : rows) {
    out += Format("%" PRId64, row.utime.us) + UpperTriangle(row.cov_T_OB);
    out += Format(",%" PRId64, row.motion.us) + UpperTriangle(row.cov_motion) + '\n';
  }
  return out;
}

Json VectorJson(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

Json CountersJson(const dr_ekf::DrCounters& c) {
  return {{"imu_used", c.imu_used},
          {"wheel_used", c.wheel_used},
          {"reordered", c.reordered},
          {"rejected_invalid", c.rejected_invalid},
          {"rejected_late", c.rejected_late},
          {"rejected_non_monotonic", c.rejected_non_monotonic},
          {"rejected_future", c.rejected_future},
          {"rejected_absurd", c.rejected_absurd},
          {"resets", c.resets}};
}

Json GyroJson(const GyroWitness& gyro) {
  return {{"turn_rad", gyro.turn_rad},
          {"dr_turn_rad", gyro.dr_turn_rad},
          {"wheel_turn_rad", gyro.wheel_turn_rad},
          {"wheel_turned_rad", gyro.wheel_turned_rad},
          {"standstills", gyro.standstills.size()}};
}

Json MotionJson(const DrMotion& m) {
  return {{"way_m", m.way_m},
          {"turn_rad", m.turn_rad},
          {"height_min_m", m.height_min_m},
          {"height_max_m", m.height_max_m},
          {"tilt_max_rad", m.tilt_max_rad},
          {"wheel_way_m", ValueOrNull(m.wheel_way_m)},
          {"wheel_turn_rad", ValueOrNull(m.wheel_turn_rad)},
          {"gyro", m.gyro ? GyroJson(*m.gyro) : Json(nullptr)},
          {"covered_s", m.covered.seconds()},
          {"uncovered_s", m.uncovered.seconds()}};
}

Json EstimatesJson(const DrState& s) {
  return {{"wheel_scale", s.wheel_scale},
          {"wheel_scale_sigma", s.way_scale_sigma},
          {"turn_scale", s.turn_scale},
          {"turn_scale_sigma", s.turn_scale_sigma},
          {"gyro_bias_rad_s", VectorJson(s.gyro_bias_rad_s)},
          {"accel_bias_m_s2", VectorJson(s.accel_bias_m_s2)},
          {"gravity_aligned", s.gravity_aligned},
          {"synthetic", s.synthetic}};
}

Json SlipJson(const std::vector<DrPose>& poses) {
  Json out = Json::array();
  for (const SlipSpan& span : SlipSpans(poses)) {
    out.push_back({{"begin_us", span.begin.us}, {"end_us", span.end.us}});
  }
  return out;
}

std::string Report(const DrOnlyRun& run, const DrMotion& motion, const WheelSum& sum,
                   const RobotConfig& config, const DrRunDescription& description,
                   const DrVerdict& verdict) {
  return JsonDocument({{"program", "gw-slam"},
                       {"version", Version()},
                       {"mode", "dr-only"},
                       {"log", description.log_name},
                       {"robot", config.robot.name},
                       {"config_hash", HashText(ConfigHash(config))},
                       {"frame", description.frame == OutputFrame::kBody ? "body" : "camera"},
                       {"log_skipped_bytes", description.log_skipped_bytes},
                       {"log_truncated", description.log_truncated},
                       {"time_steps", TimeStepsJson(run.clock.steps())},
                       {"messages", run.messages},
                       {"messages_undecodable", run.undecodable},
                       {"states", run.poses.size()},
                       {"resets", Resets(run.poses)},
                       {"wheel_gaps", sum.gaps},
                       {"counters", run.counters ? CountersJson(*run.counters) : Json(nullptr)},
                       {"motion", MotionJson(motion)},
                       {"estimates", run.last ? EstimatesJson(*run.last) : Json(nullptr)},
                       {"slip", SlipJson(run.poses)},
                       {"found", FoundJson(run.found)},
                       {"facts", verdict.facts},
                       {"problems", verdict.problems}});
}

}  // namespace

DrVerdict JudgeDrRun(const DrOnlyRun& run, const DrMotion& motion, const WheelSum& sum,
                     const RobotConfig& config, const DrRunDescription& description) {
  DrVerdict verdict;
  JudgeStreams(run, config, &verdict);
  JudgeWay(motion, &verdict);
  JudgeHeading(motion, &verdict);
  JudgeShape(run, motion, &verdict);
  JudgeSlip(run, &verdict);
  JudgeFindings(run, &verdict);
  JudgeContinuity(run, sum, description, &verdict);
  JudgeEstimates(run, config, &verdict);
  return verdict;
}

std::string VerdictText(const DrVerdict& verdict) {
  std::string out;
  for (const std::string& fact : verdict.facts) out += fact + "\n";
  for (const std::string& problem : verdict.problems) out += "problem: " + problem + "\n";
  return out + (verdict.problems.empty() ? "verdict: nothing to complain of\n"
                                         : "verdict: look at the problems above\n");
}

Result<Done> WriteDrOutputs(const std::string& folder, const DrOnlyRun& run, const DrMotion& motion,
                            const WheelSum& sum, const RobotConfig& config,
                            const DrRunDescription& description, const DrVerdict& verdict) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    return Error{ErrorCode::kIo, folder + ": cannot be made: " + error.message()};
  }
  const SE3 T_BOut =
      description.frame == OutputFrame::kCamera ? config.calibration.camera.T_BC : SE3();
  std::string dr, wheels;
  for (const DrPose& pose : run.poses) dr += TumLine(pose.utime, pose.T_OB * T_BOut);
  for (const auto& [utime, T_OB] : sum.poses) wheels += TumLine(utime, T_OB * T_BOut);
  Result<Done> written = WriteTextFile(folder + "/dr.tum", dr);
  if (written && !wheels.empty()) written = WriteTextFile(folder + "/raw_wheels.tum", wheels);
  if (written) {
    written = WriteTextFile(folder + "/dr_covariance.csv", CovarianceTable(run.covariance));
  }
  if (written) {
    written = WriteTextFile(folder + "/report.json",
                            Report(run, motion, sum, config, description, verdict));
  }
  return written;
}

}  // namespace gw::tools
