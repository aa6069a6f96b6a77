#include "common/process/health_reporter.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gw::process {
namespace {

constexpr DurationUs kInterval{1'000'000};

// Smallest value that at least `share` of the sorted values do not exceed; 0 when there are none.
int64_t Percentile(const std::vector<int64_t>& sorted, double share) {
  if (sorted.empty()) return 0;
  const auto rank = static_cast<size_t>(std::ceil(share * static_cast<double>(sorted.size())));
  return sorted[std::max<size_t>(rank, 1) - 1];
}

}  // namespace

HealthReporter::HealthReporter(std::string process, std::string version, uint64_t config_hash) {
  health_.process = std::move(process);
  health_.version = std::move(version);
  health_.config_hash = config_hash;
  health_.state = HealthState::kStarting;
}

void HealthReporter::SetState(HealthState state, std::string message) {
  health_.state = state;
  health_.message = std::move(message);
}

void HealthReporter::CountUndecodable(const std::string& channel, const std::string& why) {
  Count(channel + ".undecodable");
  undecodable_ = "messages on " + channel + " are refused: " + why + "; check who sends them";
}

int64_t HealthReporter::counter(const std::string& name) const {
  const auto found = counters_.find(name);
  return found == counters_.end() ? 0 : found->second;
}

void HealthReporter::AddLatency(DurationUs latency) {
  if (latencies_us_.size() < kMaxLatencies) latencies_us_.push_back(latency.us);
}

std::optional<Health> HealthReporter::ReportIfDue(Utime now) {
  if (last_report_ && now - *last_report_ < kInterval) return std::nullopt;
  last_report_ = now;
  health_.utime = now;
  ++health_.seq;
  health_.counters.assign(counters_.begin(), counters_.end());
  std::sort(latencies_us_.begin(), latencies_us_.end());
  health_.latency_p50_us = Percentile(latencies_us_, 0.50);
  health_.latency_p99_us = Percentile(latencies_us_, 0.99);
  health_.latency_max_us = Percentile(latencies_us_, 1.0);
  health_.queue_peak = queue_peak_;
  latencies_us_.clear();
  queue_peak_ = 0;
  Health report = health_;
  if (!undecodable_.empty()) {
    if (report.state == HealthState::kOk) report.state = HealthState::kDegraded;
    report.message += (report.message.empty() ? "" : "; ") + undecodable_;
    undecodable_.clear();
  }
  return report;
}

}  // namespace gw::process
