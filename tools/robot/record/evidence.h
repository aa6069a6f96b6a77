// What is kept when something goes wrong. Each fault gets a folder of its own, say
// FOLDER/2026-11-25T20-08-03.123456-gw-frontend/, that holds
// - gw-*.lcm: the log from kBefore before the fault to kAfter behind it (whole files of the
//   recorder),
// - robot.yaml: the configuration that ran, every key,
// - fault.txt: process, state, message, counters, map revision.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "common/contract/health.h"
#include "tools/robot/record/segment_log.h"

namespace gw::record {

// Notices that a process got worse: its HEALTH falls to DEGRADED or FAILED, or stops coming.
class FaultWatch {
 public:
  // A process that says nothing for this long is counted as gone.
  static constexpr DurationUs kSilent = Milliseconds(3000);

  // The fault, for people, when this report begins one.
  std::optional<std::string> Observe(const Health& health, Utime now);
  // The same for processes that have fallen silent; each is told once.
  std::optional<std::string> CheckSilence(Utime now);

 private:
  struct Process {
    HealthState state = HealthState::kInvalid;
    Utime last;
    bool silent = false;
  };
  std::map<std::string, Process> processes_;
};

class EvidenceKeeper {
 public:
  static constexpr DurationUs kBefore = Milliseconds(30'000);
  static constexpr DurationUs kAfter = Milliseconds(5'000);
  // A fault that follows another this closely is part of it.
  static constexpr DurationUs kQuiet = Milliseconds(60'000);

  // config: as YAML. max_bytes: of all evidence; the oldest is deleted.
  EvidenceKeeper(std::filesystem::path folder, std::string config, int64_t max_bytes)
      : folder_(std::move(folder)), config_(std::move(config)), max_bytes_(max_bytes) {}

  // A fault begins. False: it belongs to the one before.
  bool Begin(const std::string& fault, Utime now);
  // Once kAfter has passed: closes the log's file and keeps what is due. Gives the folder made.
  // Error kIo: nothing, or not everything, could be kept.
  Result<std::optional<std::filesystem::path>> KeepIfDue(SegmentLog& log, const std::string& note,
                                                         Utime now);

 private:
  void DeleteOldest();

  std::filesystem::path folder_;
  std::string config_;
  int64_t max_bytes_;
  std::optional<Utime> begun_;
  std::optional<Utime> last_;
  std::string fault_;
};

}  // namespace gw::record
