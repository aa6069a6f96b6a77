// Collects how a process is doing and makes the HEALTH message of it, once a second.
#pragma once

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/contract/health.h"

namespace gw::process {

class HealthReporter {
 public:
  // config_hash: of the effective configuration.
  HealthReporter(std::string process, std::string version, uint64_t config_hash);

  void SetState(HealthState state, std::string message = "");
  // name: "camera.lost", "dr.rejected", ... A counter that is only named (n = 0) is shown as zero.
  void Count(const std::string& name, int64_t n = 1) { counters_[name] += n; }
  // A message of the channel cannot be used: counted as CHANNEL.undecodable. The next report says
  // why, and is kDegraded where the state was kOk.
  void CountUndecodable(const std::string& channel, const std::string& why);
  // For a counter that is kept elsewhere.
  void SetCounter(const std::string& name, int64_t n) { counters_[name] = n; }
  int64_t counter(const std::string& name) const;
  // Adds the latency of one step, from the arrival of its input to its output.
  void AddLatency(DurationUs latency);
  // Messages waiting now.
  void NoteQueue(int64_t depth) { queue_peak_ = std::max(queue_peak_, depth); }

  // A report when at least a second has passed since the last, and at the first call. Percentiles
  // and queue peak are of the time since the last report: exact, up to kMaxLatencies steps.
  std::optional<Health> ReportIfDue(Utime now);

  static constexpr size_t kMaxLatencies = 10000;

 private:
  std::optional<Utime> last_report_;
  Health health_;
  std::string undecodable_;  // since the last report, the newest
  std::map<std::string, int64_t> counters_;
  std::vector<int64_t> latencies_us_;
  int64_t queue_peak_ = 0;
};

}  // namespace gw::process
