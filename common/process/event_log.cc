#include "common/process/event_log.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace gw::process {
namespace {

constexpr uint32_t kSyncWord = 0xEDA1DA01;
constexpr uint8_t kSyncBytes[] = {0xED, 0xA1, 0xDA, 0x01};
constexpr size_t kHeaderBytes = 28;
constexpr size_t kWindowBytes = 4u << 20;
constexpr size_t kWriteBufferBytes = 1u << 20;

template <typename U>
U BigAt(const uint8_t* bytes) {
  uint64_t value = 0;
  for (size_t i = 0; i < sizeof(U); ++i) value = (value << 8) | bytes[i];
  return static_cast<U>(value);
}

template <typename U>
void AppendBig(std::vector<uint8_t>& out, U value) {
  for (size_t i = sizeof(U); i-- > 0;)
    out.push_back(static_cast<uint8_t>(uint64_t{value} >> (8 * i)));
}

Error IoError(const std::string& action, const std::string& path, int error_number) {
  const ErrorCode code = error_number == ENOENT ? ErrorCode::kNotFound : ErrorCode::kIo;
  return {code, "cannot " + action + " " + path + ": " + std::strerror(error_number)};
}

}  // namespace

int64_t EventLogReader::EventHeader::total() const {
  return static_cast<int64_t>(kHeaderBytes + channel_length + data_length);
}

Result<EventLogReader> EventLogReader::Open(const std::string& path) {
  FileHandle file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat info {};
  if (!file.valid() || ::fstat(file.get(), &info) != 0) return IoError("open", path, errno);
  if (!S_ISREG(info.st_mode)) return Error{ErrorCode::kIo, path + " is not a file"};
  return EventLogReader(path, std::move(file), info.st_size);
}

void EventLogReader::Rewind() {
  position_ = 0;
  skipped_bytes_ = 0;
  truncated_ = false;
}

const uint8_t* EventLogReader::View(int64_t offset, size_t length) {
  if (offset + static_cast<int64_t>(length) > size_ || error_) return nullptr;
  const int64_t end = window_begin_ + static_cast<int64_t>(window_length_);
  if (offset < window_begin_ || offset + static_cast<int64_t>(length) > end) {
    const size_t wanted =
        static_cast<size_t>(std::min<int64_t>(std::max(length, kWindowBytes), size_ - offset));
    if (window_.size() < wanted) window_.resize(wanted);
    // Keep what the old window already has of the new one.
    size_t kept = 0;
    if (offset >= window_begin_ && offset < end) {
      kept = static_cast<size_t>(end - offset);
      std::memmove(window_.data(), window_.data() + (offset - window_begin_), kept);
    }
    window_begin_ = offset;
    window_length_ = kept;
    while (window_length_ < wanted) {
      const ssize_t got =
          ::pread(file_.get(), window_.data() + window_length_, wanted - window_length_,
                  static_cast<off_t>(window_begin_ + static_cast<int64_t>(window_length_)));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) {
        error_ = got < 0 ? IoError("read", path_, errno)
                         : Error{ErrorCode::kIo, path_ + " became shorter while it was read"};
        return nullptr;
      }
      window_length_ += static_cast<size_t>(got);
    }
  }
  return window_.data() + (offset - window_begin_);
}

std::optional<EventLogReader::EventHeader> EventLogReader::HeaderAt(int64_t offset) {
  const uint8_t* bytes = View(offset, kHeaderBytes);
  if (bytes == nullptr || BigAt<uint32_t>(bytes) != kSyncWord) return std::nullopt;
  EventHeader header;
  header.number = BigAt<int64_t>(bytes + 4);
  header.received_us = BigAt<int64_t>(bytes + 12);
  header.channel_length = BigAt<uint32_t>(bytes + 20);
  header.data_length = BigAt<uint32_t>(bytes + 24);
  if (header.number < 0 || header.channel_length == 0 ||
      header.channel_length > kMaxChannelLength || header.data_length > kMaxMessageBytes) {
    return std::nullopt;
  }
  const auto visible = static_cast<size_t>(std::min<int64_t>(
      static_cast<int64_t>(header.channel_length), size_ - offset - kHeaderBytes));
  bytes = View(offset, kHeaderBytes + visible);
  if (bytes == nullptr || !std::all_of(bytes + kHeaderBytes, bytes + kHeaderBytes + visible,
                                       [](uint8_t c) { return c > ' ' && c < 0x7F; })) {
    return std::nullopt;
  }
  return header;
}

bool EventLogReader::BoundaryAt(int64_t offset) {
  const auto available = static_cast<size_t>(std::clamp<int64_t>(size_ - offset, 0, 4));
  if (offset > size_) return false;
  const uint8_t* bytes = View(offset, available);
  return available == 0 || (bytes != nullptr && std::memcmp(bytes, kSyncBytes, available) == 0);
}

std::optional<int64_t> EventLogReader::FindEvent(int64_t begin, int64_t end) {
  for (int64_t offset = begin; offset < end;) {
    const auto length = static_cast<size_t>(std::min<int64_t>(end - offset, kWindowBytes / 2));
    const uint8_t* bytes = View(offset, length);
    if (bytes == nullptr) return std::nullopt;
    const void* found = std::memchr(bytes, kSyncBytes[0], length);
    if (found == nullptr) {
      offset += static_cast<int64_t>(length);
      continue;
    }
    offset += static_cast<const uint8_t*>(found) - bytes;
    const auto header = HeaderAt(offset);
    if (header && offset + header->total() <= size_) return offset;
    ++offset;
  }
  return std::nullopt;
}

std::optional<LogEvent> EventLogReader::Next() {
  if (truncated_) return std::nullopt;
  while (position_ < size_ && !error_) {
    const auto header = HeaderAt(position_);
    const int64_t end = position_ + (header ? header->total() : 0);
    if (!header || !BoundaryAt(end)) {
      // Damage, or the cut-off end of the file. Should a whole event begin inside the reach of this
      // header, then the header lies.
      const bool reaches = header && end <= size_;
      const auto next = FindEvent(position_ + 1, reaches ? end : size_);
      if (error_) break;
      if (!next && !reaches) {
        truncated_ =
            header.has_value() ||
            (size_ - position_ < static_cast<int64_t>(kHeaderBytes) && BoundaryAt(position_));
        if (!truncated_) skipped_bytes_ += size_ - position_;
        position_ = size_;
        return std::nullopt;
      }
      if (next) {
        skipped_bytes_ += *next - position_;
        position_ = *next;
        continue;
      }
    }
    const uint8_t* bytes = View(position_, static_cast<size_t>(header->total()));
    if (bytes == nullptr) break;
    position_ = end;
    const uint8_t* channel = bytes + kHeaderBytes;
    return LogEvent{header->number,
                    Utime{header->received_us},
                    {reinterpret_cast<const char*>(channel), header->channel_length},
                    {channel + header->channel_length, header->data_length}};
  }
  return std::nullopt;
}

Result<EventLogWriter> EventLogWriter::Create(const std::string& path) {
  FileHandle file(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
  if (!file.valid()) return IoError("create", path, errno);
  return EventLogWriter(path, std::move(file));
}

EventLogWriter::~EventLogWriter() {
  if (file_.valid()) (void)Close();
}

Error EventLogWriter::Fail(int error_number) {
  buffer_.clear();
  failed_ = IoError("write", path_, error_number);
  return *failed_;
}

Result<Done> EventLogWriter::WriteOut(std::span<const uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file_.get(), bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return Fail(written < 0 ? errno : ENOSPC);
    bytes = bytes.subspan(static_cast<size_t>(written));
  }
  return Done{};
}

Result<Done> EventLogWriter::Append(Utime received, std::string_view channel,
                                    std::span<const uint8_t> data) {
  if (failed_) return *failed_;
  if (channel.empty() || channel.size() > kMaxChannelLength || data.size() > kMaxMessageBytes) {
    return Error{ErrorCode::kInvalidArgument,
                 "event refused for " + path_ + ": channel of " + std::to_string(channel.size()) +
                     " characters (1 to 63), " + std::to_string(data.size()) +
                     " bytes of data (at most 268435456)"};
  }
  AppendBig(buffer_, kSyncWord);
  AppendBig(buffer_, static_cast<uint64_t>(next_number_++));
  AppendBig(buffer_, static_cast<uint64_t>(received.us));
  AppendBig(buffer_, static_cast<uint32_t>(channel.size()));
  AppendBig(buffer_, static_cast<uint32_t>(data.size()));
  buffer_.insert(buffer_.end(), channel.begin(), channel.end());
  bytes_written_ += static_cast<int64_t>(kHeaderBytes + channel.size() + data.size());
  if (buffer_.size() + data.size() <= kWriteBufferBytes) {
    buffer_.insert(buffer_.end(), data.begin(), data.end());
    return Done{};
  }
  if (auto flushed = Flush(); !flushed) return flushed;
  if (data.size() > kWriteBufferBytes / 4) return WriteOut(data);  // large ones go past the buffer
  buffer_.insert(buffer_.end(), data.begin(), data.end());
  return Done{};
}

Result<Done> EventLogWriter::Flush(bool sync) {
  if (failed_) return *failed_;
  if (auto written = WriteOut(buffer_); !written) return written;
  buffer_.clear();
  if (sync && ::fdatasync(file_.get()) != 0) return Fail(errno);
  return Done{};
}

Result<Done> EventLogWriter::Close() {
  auto flushed = Flush();
  const bool closed = file_.Close();
  if (!flushed) return flushed;
  if (!closed) return Fail(errno);
  return Done{};
}

}  // namespace gw::process
