// A log that never ends on a disk that does: files of a limited size, the oldest of which are
// deleted when all of them together grow too large. Single-threaded; no clock of its own.
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/core/result.h"
#include "common/core/time.h"
#include "common/process/event_log.h"

namespace gw::record {

struct SegmentLimits {
  int64_t segment_bytes = int64_t{64} << 20;  // a file is closed when it has grown to this
  int64_t total_bytes = int64_t{15} << 30;    // of all files
};

class SegmentLog {
 public:
  // The folder must exist. Files of an earlier run in it stay and count; those that were cut off by
  // a crash can still be read. Error kIo: the folder cannot be read.
  static Result<SegmentLog> Open(const std::filesystem::path& folder, const SegmentLimits& limits);

  // Error kIo or kNotFound when the disk is full or gone. The message is lost then; the next Append
  // starts a new file, so recording goes on as soon as the disk does.
  Result<Done> Append(Utime received, std::string_view channel, std::span<const uint8_t> message);
  Result<Done> Flush();

  // Closes the current file; the next Append starts one.
  Result<Done> Close();

  // Files that hold messages received at or after `from`, oldest first, the current one included.
  std::vector<std::filesystem::path> FilesSince(Utime from) const;

  int64_t bytes() const { return bytes_; }  // of all files

 private:
  struct Segment {
    std::filesystem::path path;
    Utime last;  // received; files of an earlier run: when they were last written
    int64_t bytes = 0;
  };

  SegmentLog(std::filesystem::path folder, const SegmentLimits& limits)
      : folder_(std::move(folder)), limits_(limits) {}
  Result<Done> Begin(Utime first);
  void DeleteOldest();

  std::filesystem::path folder_;
  SegmentLimits limits_;
  std::deque<Segment> segments_;                   // oldest first
  std::optional<process::EventLogWriter> writer_;  // of segments_.back()
  int64_t bytes_ = 0;
};

// 2026-11-25T20-08-03.123456, UTC: sorts by time and is allowed in a file name.
std::string FileStamp(Utime time);

}  // namespace gw::record
