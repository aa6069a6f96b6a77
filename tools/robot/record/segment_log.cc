#include "tools/robot/record/segment_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <system_error>

namespace gw::record {
namespace {

namespace fs = std::filesystem;

constexpr char kSuffix[] = ".lcm";

Utime WriteTime(const fs::path& path) {
  std::error_code error;
  const auto time = fs::last_write_time(path, error);
  if (error) return Utime{};
  const auto since_epoch = std::chrono::file_clock::to_sys(time).time_since_epoch();
  return Utime{std::chrono::duration_cast<std::chrono::microseconds>(since_epoch).count()};
}

}  // namespace

std::string FileStamp(Utime time) {
  const std::time_t seconds = time.us / 1000000;
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  return fmt::format("{:04}-{:02}-{:02}T{:02}-{:02}-{:02}.{:06}", parts.tm_year + 1900,
                     parts.tm_mon + 1, parts.tm_mday, parts.tm_hour, parts.tm_min, parts.tm_sec,
                     time.us % 1000000);
}

Result<SegmentLog> SegmentLog::Open(const fs::path& folder, const SegmentLimits& limits) {
  SegmentLog log(folder, limits);
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (!it->is_regular_file() || it->path().extension() != kSuffix) continue;
    const auto bytes = static_cast<int64_t>(it->file_size());
    log.segments_.push_back({it->path(), WriteTime(it->path()), bytes});
    log.bytes_ += bytes;
  }
  if (error) return Error{ErrorCode::kIo, folder.string() + ": " + error.message()};
  std::sort(log.segments_.begin(), log.segments_.end(),
            [](const Segment& a, const Segment& b) { return a.path < b.path; });
  return log;
}

Result<Done> SegmentLog::Begin(Utime first) {
  const fs::path path = folder_ / ("gw-" + FileStamp(first) + kSuffix);
  auto writer = process::EventLogWriter::Create(path.string());
  if (!writer) return writer.error();
  writer_.emplace(*std::move(writer));
  segments_.push_back({path, first, 0});
  return Done{};
}

void SegmentLog::DeleteOldest() {
  // The current file is never deleted.
  while (bytes_ > limits_.total_bytes && segments_.size() > 1) {
    std::error_code ignored;  // what cannot be deleted is forgotten; Open counts it again
    fs::remove(segments_.front().path, ignored);
    bytes_ -= segments_.front().bytes;
    segments_.pop_front();
  }
}

Result<Done> SegmentLog::Append(Utime received, std::string_view channel,
                                std::span<const uint8_t> message) {
  if (!writer_) {
    if (const auto begun = Begin(received); !begun) return begun.error();
  }
  const Result<Done> written = writer_->Append(received, channel, message);
  Segment& segment = segments_.back();
  bytes_ += writer_->bytes_written() - segment.bytes;
  segment.bytes = writer_->bytes_written();
  segment.last = received;
  if (!written) {
    writer_.reset();
    return written.error();
  }
  DeleteOldest();
  if (segment.bytes >= limits_.segment_bytes) return Close();
  return Done{};
}

Result<Done> SegmentLog::Flush() {
  return writer_ ? writer_->Flush() : Result<Done>(Done{});
}

Result<Done> SegmentLog::Close() {
  if (!writer_) return Done{};
  const Result<Done> closed = writer_->Close();
  writer_.reset();
  return closed;
}

std::vector<fs::path> SegmentLog::FilesSince(Utime from) const {
  std::vector<fs::path> files;
  for (const Segment& segment : segments_) {
    if (segment.last >= from) files.push_back(segment.path);
  }
  return files;
}

}  // namespace gw::record
