// A log that appears under its name only when it is complete.
#pragma once

#include <memory>
#include <string>

#include "common/process/event_log.h"

namespace gw::tools {

// Writes FILE.partial; Commit renames it to FILE. Without Commit the partial file is removed, so
// that no half-written log is taken for a whole one, and an older FILE stays as it was.
class SafeLogWriter {
 public:
  // Error: kIo.
  static Result<SafeLogWriter> Create(const std::string& file);
  SafeLogWriter(SafeLogWriter&&) = default;
  SafeLogWriter& operator=(SafeLogWriter&&) = delete;
  ~SafeLogWriter();

  // As EventLogWriter::Append.
  Result<Done> Append(Utime received, std::string_view channel, std::span<const uint8_t> data) {
    return writer_->Append(received, channel, data);
  }
  int64_t bytes_written() const { return writer_->bytes_written(); }

  // Once, at the end. Error: kIo.
  Result<Done> Commit();

 private:
  SafeLogWriter(std::string file, process::EventLogWriter writer)
      : file_(std::move(file)),
        writer_(std::make_unique<process::EventLogWriter>(std::move(writer))) {}
  std::string partial() const { return file_ + ".partial"; }

  std::string file_;
  std::unique_ptr<process::EventLogWriter> writer_;  // null: moved from, or committed
};

}  // namespace gw::tools
