// How a process is doing, once a second.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "common/core/time.h"

namespace gw {

enum class HealthState : int32_t {
  kInvalid = 0,
  kStarting = 1,
  kOk = 2,
  kDegraded = 3,
  kFailed = 4
};

struct Health {
  Utime utime;
  int64_t seq = 0;
  std::string process;  // program name
  HealthState state = HealthState::kInvalid;
  std::string message;  // for people: what is wrong and what to do; empty when kOk
  // Monotonic since the start: "camera.lost", "dr.rejected_nan", ... sorted by name.
  std::vector<std::pair<std::string, int64_t>> counters;
  int64_t latency_p50_us = 0, latency_p99_us = 0, latency_max_us = 0;  // of the last second's steps
  int64_t queue_peak = 0;
  uint64_t config_hash = 0;
  std::string version;
};

}  // namespace gw
