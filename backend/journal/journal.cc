#include "backend/journal/journal.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>

#include "backend/journal/record.h"
#include "lcmtypes/wire/wire.h"

namespace gw::backend {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPrefix = "map-";
constexpr std::string_view kSuffix = ".gwj";

std::string FilePath(const std::string& directory, int64_t generation) {
  char name[48];
  std::snprintf(name, sizeof(name), "map-%08lld.gwj", static_cast<long long>(generation));
  return directory + "/" + name;
}

Error IoError(const std::string& what, const std::string& path) {
  return {ErrorCode::kIo, "map journal: cannot " + what + " " + path + ": " + std::strerror(errno)};
}

// Generations in the directory, newest first.
std::vector<int64_t> Generations(const std::string& directory) {
  std::vector<int64_t> out;
  std::error_code ignored;  // a directory that cannot be read holds nothing; Open says why
  for (const auto& entry : fs::directory_iterator(directory, ignored)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(kPrefix) || !name.ends_with(kSuffix)) continue;
    int64_t generation = 0;
    const char* begin = name.data() + kPrefix.size();
    const char* end = name.data() + name.size() - kSuffix.size();
    const auto parsed = std::from_chars(begin, end, generation);
    if (parsed.ec == std::errc() && parsed.ptr == end && generation > 0) out.push_back(generation);
  }
  std::sort(out.rbegin(), out.rend());
  return out;
}

Result<std::vector<uint8_t>> ReadFile(const std::string& path) {
  const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return IoError("open", path);
  std::vector<uint8_t> out;
  std::vector<uint8_t> block(1 << 20);
  ssize_t n = 0;
  while ((n = read(fd, block.data(), block.size())) != 0) {
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) break;
    out.insert(out.end(), block.begin(), block.begin() + n);
  }
  const Error error = IoError("read", path);
  close(fd);
  if (n < 0) return error;
  return out;
}

// False with errno set when not all could be written.
bool WriteAll(int fd, const std::vector<uint8_t>& bytes) {
  size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t n = write(fd, bytes.data() + done, bytes.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return false;
    done += static_cast<size_t>(n);
  }
  return true;
}

// A new or renamed file is only safe once its directory is synced too.
bool SyncDirectory(const std::string& directory) {
  const int fd = open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return false;
  const bool ok = fsync(fd) == 0;
  close(fd);
  return ok;
}

void AppendHash(uint64_t hash, std::vector<uint8_t>& out) {
  std::vector<uint8_t> payload(sizeof hash);
  for (size_t i = 0; i < payload.size(); ++i) payload[i] = static_cast<uint8_t>(hash >> (8 * i));
  AppendRecord(RecordType::kCheckpoint, payload, out);
}

// Replays records one by one; `fault` says why it cannot go on.
class Replay {
 public:
  explicit Replay(LoadedMap& out) : out_(out) {}

  bool Take(const RecordView& record) {
    switch (record.type) {
      case RecordType::kKeyframe: {
        auto keyframe = wire::Decode<Keyframe>(record.payload);
        if (!keyframe) return Fault(keyframe.error().message);
        out_.pending.push_back(std::move(*keyframe));
        return true;
      }
      case RecordType::kMapUpdate: {
        const auto update = wire::Decode<MapUpdate>(record.payload);
        if (!update) return Fault(update.error().message);
        if (!update->snapshot && update->base_revision != out_.map.revision()) {
          return Fault("an update does not follow the one before");
        }
        for (const Keyframe& keyframe : out_.pending) out_.map.AddKeyframe(keyframe);
        out_.pending.clear();
        out_.map.Apply(*update);
        return true;
      }
      case RecordType::kCheckpoint: {
        uint64_t hash = 0;
        if (record.payload.size() != 8) return Fault("checkpoint record of wrong size");
        for (size_t i = 0; i < 8; ++i) hash |= uint64_t{record.payload[i]} << (8 * i);
        if (hash != out_.map.Hash()) return Fault("the checkpoint is not the map that was written");
        checkpoint_end_ = record.end;
        return true;
      }
    }
    return Fault("record of unknown type");
  }
  size_t checkpoint_end() const { return checkpoint_end_; }
  const std::string& fault() const { return fault_; }

 private:
  bool Fault(std::string text) {
    fault_ = std::move(text);
    return false;
  }
  LoadedMap& out_;
  size_t checkpoint_end_ = 0;
  std::string fault_;
};

struct GenerationContent {
  LoadedMap loaded;
  size_t checkpoint_bytes = 0;  // 0: the checkpoint is not whole, nothing here can be used
};

GenerationContent ReplayFile(const std::vector<uint8_t>& bytes, const std::string& path) {
  GenerationContent out;
  RecordReader reader(bytes);
  Replay replay(out.loaded);
  RecordView record{};
  RecordReader::State state;
  out.loaded.good_bytes = reader.good_end();
  while ((state = reader.Next(record)) == RecordReader::State::kOk) {
    if (!replay.Take(record)) break;
    out.loaded.good_bytes = record.end;
    ++out.loaded.num_records;
  }
  out.checkpoint_bytes = replay.checkpoint_end();
  out.loaded.cut_bytes = bytes.size() - out.loaded.good_bytes;
  out.loaded.torn = state == RecordReader::State::kTorn;
  const std::string where = " in " + path + " at byte " + std::to_string(out.loaded.good_bytes) +
                            "; the map is the one " + "recorded before it";
  if (!replay.fault().empty()) {
    out.loaded.damage = replay.fault() + where;
  } else if (state == RecordReader::State::kDamaged) {
    out.loaded.damage = "wrong checksum" + where;
  }
  return out;
}

struct DirectoryContent {
  LoadedMap loaded;
  size_t checkpoint_bytes = 0;
  int64_t newest_generation = 0;  // also of those that cannot be used
};

Result<DirectoryContent> ReadDirectory(const std::string& directory) {
  DirectoryContent out;
  const std::vector<int64_t> generations = Generations(directory);
  if (generations.empty()) return out;
  out.newest_generation = generations.front();
  std::string unusable;
  for (const int64_t generation : generations) {
    const std::string path = FilePath(directory, generation);
    const auto bytes = ReadFile(path);
    if (!bytes) return bytes.error();
    GenerationContent content = ReplayFile(*bytes, path);
    if (content.checkpoint_bytes == 0) {
      unusable += "the checkpoint of " + path + " cannot be read; ";
      continue;
    }
    out.loaded = std::move(content.loaded);
    out.loaded.generation = generation;
    out.loaded.damage = unusable + out.loaded.damage;
    out.checkpoint_bytes = content.checkpoint_bytes;
    return out;
  }
  return Error{ErrorCode::kBadData, "map journal: " + unusable +
                                        "no older one is left. Move the directory away to start "
                                        "a new map"};
}

}  // namespace

Result<LoadedMap> LoadMap(const std::string& directory) {
  auto content = ReadDirectory(directory);
  if (!content) return content.error();
  return std::move(content->loaded);
}

Journal::Journal(Journal&& other) noexcept {
  *this = std::move(other);
}

Journal& Journal::operator=(Journal&& other) noexcept {
  if (this == &other) return *this;
  Close();
  directory_ = std::move(other.directory_);
  options_ = other.options_;
  lock_fd_ = std::exchange(other.lock_fd_, -1);
  fd_ = std::exchange(other.fd_, -1);
  generation_ = other.generation_;
  bytes_ = other.bytes_;
  checkpoint_bytes_ = other.checkpoint_bytes_;
  oldest_unsynced_ = other.oldest_unsynced_;
  failure_ = std::move(other.failure_);
  return *this;
}

Journal::~Journal() {
  Close();
}

void Journal::Close() {
  if (fd_ >= 0) {
    if (oldest_unsynced_) fdatasync(fd_);
    close(fd_);
  }
  if (lock_fd_ >= 0) close(lock_fd_);
  fd_ = lock_fd_ = -1;
}

Result<Journal> Journal::Open(const std::string& directory, const JournalOptions& options,
                              LoadedMap& loaded) {
  std::error_code error;
  fs::create_directories(directory, error);
  if (error) {
    return Error{ErrorCode::kIo,
                 "map journal: cannot make directory " + directory + ": " + error.message()};
  }
  Journal out;
  out.directory_ = directory;
  out.options_ = options;
  const std::string lock_path = directory + "/lock";
  out.lock_fd_ = open(lock_path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (out.lock_fd_ < 0) return IoError("open", lock_path);
  if (flock(out.lock_fd_, LOCK_EX | LOCK_NB) != 0) {
    return Error{ErrorCode::kIo,
                 "map journal: another process writes to " + directory + "; stop it first"};
  }
  auto content = ReadDirectory(directory);
  if (!content) return content.error();
  loaded = std::move(content->loaded);
  out.generation_ = content->newest_generation;

  if (loaded.generation == 0 || !loaded.damage.empty()) {
    // The pending keyframes are in the damaged file only; they go into the new one as well.
    const auto started = out.Checkpoint(loaded.map);
    if (!started) return started.error();
    for (const Keyframe& keyframe : loaded.pending) {
      const auto appended = out.Append(keyframe, keyframe.utime);
      if (!appended) return appended.error();
    }
    return out;
  }
  const std::string path = FilePath(directory, out.generation_);
  out.fd_ = open(path.c_str(), O_WRONLY | O_CLOEXEC);
  if (out.fd_ < 0) return IoError("open for writing", path);
  if (ftruncate(out.fd_, static_cast<off_t>(loaded.good_bytes)) != 0) {
    return IoError("cut the torn end of", path);
  }
  if (lseek(out.fd_, 0, SEEK_END) < 0) return IoError("seek in", path);
  out.bytes_ = loaded.good_bytes;
  out.checkpoint_bytes_ = content->checkpoint_bytes;
  return out;
}

Result<Done> Journal::Fail(const std::string& what) {
  failure_ = what;
  return Error{ErrorCode::kIo, what};
}

Result<Done> Journal::AppendBytes(const std::vector<uint8_t>& bytes, Utime now) {
  if (failed()) return Error{ErrorCode::kIo, failure_};
  if (!WriteAll(fd_, bytes)) {
    const std::string what = IoError("write to", FilePath(directory_, generation_)).message;
    // Cut what was written of it. When even that fails, the next reader takes it for a torn end.
    if (ftruncate(fd_, static_cast<off_t>(bytes_)) == 0) lseek(fd_, 0, SEEK_END);
    return Fail(what);
  }
  bytes_ += bytes.size();
  if (!oldest_unsynced_) oldest_unsynced_ = now;
  return Done{};
}

Result<Done> Journal::Append(const Keyframe& keyframe, Utime now) {
  std::vector<uint8_t> bytes;
  AppendRecord(RecordType::kKeyframe, wire::Encode(keyframe), bytes);
  return AppendBytes(bytes, now);
}

Result<Done> Journal::Append(const MapUpdate& update, Utime now) {
  std::vector<uint8_t> bytes;
  AppendRecord(RecordType::kMapUpdate, wire::Encode(update), bytes);
  return AppendBytes(bytes, now);
}

Result<Done> Journal::Sync() {
  if (fdatasync(fd_) != 0) {
    return Fail(IoError("sync", FilePath(directory_, generation_)).message);
  }
  oldest_unsynced_.reset();
  return Done{};
}

Result<Done> Journal::SyncIfDue(Utime now) {
  if (failed()) return Error{ErrorCode::kIo, failure_};
  if (!oldest_unsynced_ || now - *oldest_unsynced_ < options_.sync_interval) return Done{};
  return Sync();
}

bool Journal::CheckpointDue() const {
  const size_t grown = bytes_ - checkpoint_bytes_;
  return failed() ||
         (grown > options_.min_bytes_between_checkpoints && grown > 4 * checkpoint_bytes_);
}

Result<Done> Journal::Checkpoint(const Map& map) {
  const std::string temporary = directory_ + "/checkpoint.tmp";
  const std::string path = FilePath(directory_, generation_ + 1);
  const int fd = open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (fd < 0) return Fail(IoError("open", temporary).message);

  size_t written = 0;
  std::vector<uint8_t> bytes(kFileMagic.begin(), kFileMagic.end());
  const auto flush = [&] {
    if (!WriteAll(fd, bytes)) return false;
    written += bytes.size();
    bytes.clear();
    return true;
  };
  bool ok = true;
  for (const auto& [id, keyframe] : map.keyframes()) {
    AppendRecord(RecordType::kKeyframe, wire::Encode(keyframe.frame), bytes);
    if (bytes.size() > (size_t{1} << 20)) ok = ok && flush();
  }
  AppendRecord(RecordType::kMapUpdate, wire::Encode(map.Snapshot()), bytes);
  AppendHash(map.Hash(), bytes);
  ok = ok && flush() && fsync(fd) == 0;
  ok = ok && std::rename(temporary.c_str(), path.c_str()) == 0;
  if (!ok) {
    const std::string what = IoError("write", path).message;
    close(fd);
    unlink(temporary.c_str());
    return Fail(what);
  }
  if (!SyncDirectory(directory_)) {
    const std::string what = IoError("sync", directory_).message;
    close(fd);
    return Fail(what);
  }
  if (fd_ >= 0) close(fd_);
  fd_ = fd;  // goes on at its end
  ++generation_;
  bytes_ = checkpoint_bytes_ = written;
  oldest_unsynced_.reset();
  failure_.clear();
  // This one and the one before stay.
  for (const int64_t generation : Generations(directory_)) {
    if (generation < generation_ - 1) unlink(FilePath(directory_, generation).c_str());
  }
  return Done{};
}

}  // namespace gw::backend
