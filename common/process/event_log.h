// LCM's event log: the files of lcm-logger, lcm-logplayer and of our own tools.
//
// Format (big-endian, repeated, no file header): u32 0xEDA1DA01, i64 event number, i64 receive time
// in us, i32 channel length, i32 data length, channel (no NUL), data. Source: LCM 1.3.1 eventlog.c,
// checked against logs that lcm-logger wrote.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/core/result.h"
#include "common/core/time.h"
#include "common/process/file_handle.h"

namespace gw::process {

inline constexpr size_t kMaxChannelLength = 63;
inline constexpr size_t kMaxMessageBytes = size_t{1} << 28;  // LCM's own limit

struct LogEvent {
  int64_t number = 0;
  Utime received;
  std::string_view channel;       // both valid until the reader's next call
  std::span<const uint8_t> data;  // the message: fingerprint first
};

// Reads events in file order through a window of a few MB; the file may be larger than the memory.
// Damage does not stop it: bytes that are no event are skipped and counted.
class EventLogReader {
 public:
  // Error kNotFound or kIo: the path, what the system says.
  static Result<EventLogReader> Open(const std::string& path);

  // Empty at the end of the file; then error() and truncated() say whether it was a good end.
  std::optional<LogEvent> Next();

  int64_t skipped_bytes() const { return skipped_bytes_; }
  // The file ends inside an event: normal after a crash of the logger. That event is not given out
  // and does not count as skipped.
  bool truncated() const { return truncated_; }
  // Set when reading failed half-way.
  const std::optional<Error>& error() const { return error_; }

  int64_t position() const { return position_; }  // bytes, of the next event; for progress
  void Rewind();                                  // to the first event
  int64_t size() const { return size_; }

 private:
  struct EventHeader {
    int64_t number = 0, received_us = 0;
    size_t channel_length = 0, data_length = 0;
    int64_t total() const;
  };
  EventLogReader(std::string path, FileHandle file, int64_t size)
      : path_(std::move(path)), file_(std::move(file)), size_(size) {}

  // `length` bytes at `offset`; null when the file does not have them or cannot be read.
  const uint8_t* View(int64_t offset, size_t length);
  // An event header at `offset` that could be true, whether or not the event fits into the file.
  std::optional<EventHeader> HeaderAt(int64_t offset);
  // An event or the end of the file may begin here.
  bool BoundaryAt(int64_t offset);
  // First offset in [begin, end) where an event starts that fits into the file.
  std::optional<int64_t> FindEvent(int64_t begin, int64_t end);

  std::string path_;
  FileHandle file_;
  int64_t size_;
  int64_t position_ = 0;
  int64_t skipped_bytes_ = 0;
  bool truncated_ = false;
  std::optional<Error> error_;
  std::vector<uint8_t> window_;
  int64_t window_begin_ = 0;
  size_t window_length_ = 0;
};

// Writes a log that lcm-logplayer and all of our tools read. The bytes depend only on the events.
class EventLogWriter {
 public:
  // Creates or overwrites. Error kIo: the path, what the system says.
  static Result<EventLogWriter> Create(const std::string& path);
  EventLogWriter(EventLogWriter&&) = default;
  EventLogWriter& operator=(EventLogWriter&&) = delete;
  // Writes what is buffered, without a way to report failure: call Close() where it matters.
  ~EventLogWriter();

  // Events are numbered 0, 1, 2, ... Error kIo (path, reason) when the disk is full or gone, then
  // and on every call after; kInvalidArgument for a channel name or size that LCM cannot carry.
  Result<Done> Append(Utime received, std::string_view channel, std::span<const uint8_t> data);
  // Hands buffered events to the system; with `sync`, to the disk.
  Result<Done> Flush(bool sync = false);
  // Flushes and closes; the writer must not be used afterwards.
  Result<Done> Close();

  int64_t bytes_written() const { return bytes_written_; }  // including those still buffered

 private:
  EventLogWriter(std::string path, FileHandle file)
      : path_(std::move(path)), file_(std::move(file)) {}
  Result<Done> WriteOut(std::span<const uint8_t> bytes);
  Error Fail(int error_number);

  std::string path_;
  FileHandle file_;
  int64_t next_number_ = 0;
  int64_t bytes_written_ = 0;
  std::vector<uint8_t> buffer_;
  std::optional<Error> failed_;
};

}  // namespace gw::process
