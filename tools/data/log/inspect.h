// What is in a log, and what is wrong with it.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/core/result.h"
#include "common/core/time.h"
#include "tools/data/log/log_clock.h"

namespace gw::tools {

struct ChannelReport {
  int64_t messages = 0;
  int64_t bytes = 0;
  bool known = false;      // one of our channels
  Utime first, last;       // of the messages (of the events on a channel that is not ours)
  DurationUs largest_gap;  // between neighbours
  Utime largest_gap_begin;
  int64_t lost = 0;             // sequence numbers that never came
  int64_t restarts = 0;         // senders that began again at 1: legal
  int64_t sequence_faults = 0;  // repeated or backward sequence numbers
  int64_t time_faults = 0;      // utime that does not increase
  int64_t undecodable = 0;

  double rate_hz() const {
    const double seconds = (last - first).seconds();
    return messages > 1 && seconds > 0 ? static_cast<double>(messages - 1) / seconds : 0;
  }
};

struct LogNote {
  Utime utime;
  std::string key, text;
};

struct LogReport {
  int64_t file_bytes = 0;
  int64_t events = 0;
  Utime begin, end;                  // receive times: of the first event, and the latest
  DurationUs length;                 // of the log, see LogClock
  std::vector<TimeStep> time_steps;  // where the receive time goes back or jumps
                                     // ahead: joined logs, a clock that was set
  int64_t receive_time_faults = 0;   // events received before the one in front of them
  int64_t skipped_bytes = 0;         // no events: garbage
  bool truncated = false;            // ends inside an event
  std::map<std::string, ChannelReport> channels;
  std::vector<LogNote> notes;
  // One line each, in file order, at most kMaxProblemsPerKind of one kind and channel.
  std::vector<std::string> problems;
  bool ok = true;  // false: there are problems
};

inline constexpr int kMaxProblemsPerKind = 5;

enum class InspectDepth {
  kHeaders,  // times and sequence numbers
  kDecode,   // every message
};

// Reads the whole file. Truncated logs are read up to the damage, garbage is skipped. Error:
// kNotFound, kIo, or kBadData when the file holds no event at all.
Result<LogReport> InspectLog(const std::string& file, InspectDepth depth);

// For people, and as JSON.
std::string ReportText(const LogReport& report);
std::string ReportJson(const LogReport& report);

}  // namespace gw::tools
