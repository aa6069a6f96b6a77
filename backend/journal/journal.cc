#include "backend/journal/journal.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>

#include "backend/journal/record.h"
#include "common/process/file_handle.h"
#include "common/wire/wire.h"

namespace gw::backend {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTemporary = "/checkpoint.tmp";
constexpr size_t kMaxSessions = 1000;  // noted in a checkpoint; older ones are forgotten

Error IoError(const std::string& what, const std::string& path) {
  return {ErrorCode::kIo, "map journal: cannot " + what + " " + path + ": " + std::strerror(errno)};
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

}  // namespace

Journal::~Journal() {
  if (file_.valid() && oldest_unsynced_) fdatasync(file_.get());
}

// Makes the directory when it is missing, and takes its lock.
Result<Done> Journal::Lock() {
  std::error_code error;
  fs::create_directories(directory_, error);
  if (error) {
    return Error{ErrorCode::kIo,
                 "map journal: cannot make directory " + directory_ + ": " + error.message()};
  }
  const std::string path = directory_ + "/lock";
  lock_ = process::FileHandle(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
  if (!lock_.valid()) return IoError("open", path);
  if (flock(lock_.get(), LOCK_EX | LOCK_NB) != 0) {
    return Error{ErrorCode::kIo,
                 "map journal: another process writes to " + directory_ + "; stop it first"};
  }
  return Done{};
}

// Appends to the newest generation; its torn end is cut off.
Result<Done> Journal::Continue(const LoadedMap& loaded) {
  const std::string path = GenerationPath(directory_, generation_);
  file_ = process::FileHandle(open(path.c_str(), O_WRONLY | O_CLOEXEC));
  if (!file_.valid()) return IoError("open for writing", path);
  if (ftruncate(file_.get(), static_cast<off_t>(loaded.good_bytes)) != 0) {
    return IoError("cut the torn end of", path);
  }
  if (lseek(file_.get(), 0, SEEK_END) < 0) return IoError("seek in", path);
  bytes_ = loaded.good_bytes;
  checkpoint_bytes_ = loaded.checkpoint_bytes;
  std::vector<uint8_t> bytes;
  AppendRecord(RecordType::kSession, Encode(sessions_.back()), bytes);
  return AppendBytes(bytes, sessions_.back().begin);
}

// A new generation with what could be read. The damaged files are set aside once it is safe.
Result<Done> Journal::StartAnew(const LoadedMap& loaded, Utime now) {
  auto started = WriteGeneration(loaded.map);
  if (!started) return started;
  for (const Keyframe& keyframe : loaded.pending) {
    auto appended = Append(keyframe, now);
    if (!appended) return appended;
  }
  if (auto synced = Sync(); !synced) return synced;
  for (const std::string& path : loaded.damaged_files) {
    if (std::rename(path.c_str(), (path + ".damaged").c_str()) != 0) {
      return IoError("set aside", path);
    }
  }
  DropOldGenerations();
  return Done{};
}

Result<Journal> Journal::Open(const std::string& directory, const JournalOptions& options,
                              MapSession session, LoadedMap& loaded) {
  Journal out;
  out.directory_ = directory;
  out.options_ = options;
  if (const auto locked = out.Lock(); !locked) return locked.error();
  auto content = LoadMap(directory);
  if (!content) return content.error();
  loaded = std::move(*content);
  const auto checked = CheckSource(directory, loaded, session.source);
  if (!checked) return checked.error();
  unlink((directory + kTemporary).c_str());  // of a process killed while it wrote a checkpoint
  const KeyframeId newest =
      loaded.pending.empty() ? loaded.map.newest_keyframe() : loaded.pending.back().id;
  session.first_keyframe = {newest.value + 1};
  loaded.sessions.push_back(session);
  out.sessions_ = loaded.sessions;
  out.generation_ = loaded.newest_generation;
  const bool whole = loaded.generation > 0 && loaded.damage.empty() && !loaded.older_format;
  const auto begun = whole ? out.Continue(loaded) : out.StartAnew(loaded, session.begin);
  if (!begun) return begun.error();
  return out;
}

size_t CheckpointBytes(const Map& map) {
  size_t bytes = kFileMagic.size() + wire::Encode(map.Snapshot()).size() + sizeof(uint64_t);
  for (const auto& [id, keyframe] : map.keyframes()) bytes += wire::Encode(keyframe.frame).size();
  return bytes + (map.keyframes().size() + 2) * kRecordHeaderBytes;
}

Result<Done> SaveMap(const std::string& directory, const LoadedMap& content) {
  Journal journal;
  journal.directory_ = directory;
  if (auto locked = journal.Lock(); !locked) return locked;
  if (!Generations(directory).empty()) {
    return Error{ErrorCode::kIo, "map: " + directory + " holds a map already; name another folder"};
  }
  journal.sessions_ = content.sessions;
  LoadedMap undamaged = content;
  undamaged.damaged_files.clear();
  return journal.StartAnew(undamaged, {});
}

Result<Done> Journal::Fail(const std::string& what) {
  failure_ = what;
  return Error{ErrorCode::kIo, what};
}

Result<Done> Journal::AppendBytes(const std::vector<uint8_t>& bytes, Utime now) {
  if (failed()) return Error{ErrorCode::kIo, failure_};
  if (!WriteAll(file_.get(), bytes)) {
    const std::string what = IoError("write to", GenerationPath(directory_, generation_)).message;
    // Cut what was written of it. When even that fails, the next reader takes it for a torn end.
    if (ftruncate(file_.get(), static_cast<off_t>(bytes_)) == 0) lseek(file_.get(), 0, SEEK_END);
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
  if (fdatasync(file_.get()) != 0) {
    return Fail(IoError("sync", GenerationPath(directory_, generation_)).message);
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
  return failed() ||
         (grown() > options_.min_bytes_between_checkpoints && grown() > checkpoint_bytes_);
}

Result<Done> Journal::Checkpoint(const Map& map) {
  auto written = WriteGeneration(map);
  if (written) DropOldGenerations();
  return written;
}

// The newest one and the one before stay.
void Journal::DropOldGenerations() const {
  const std::vector<int64_t> generations = Generations(directory_);
  for (size_t i = 2; i < generations.size(); ++i) {
    unlink(GenerationPath(directory_, generations[i]).c_str());
  }
}

Result<Done> Journal::WriteGeneration(const Map& map) {
  const std::string temporary = directory_ + kTemporary;
  const std::string path = GenerationPath(directory_, generation_ + 1);
  process::FileHandle file(open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
  if (!file.valid()) return IoError("open", temporary);

  size_t written = 0;
  std::vector<uint8_t> bytes(kFileMagic.begin(), kFileMagic.end());
  const auto flush = [&] {
    if (!WriteAll(file.get(), bytes)) return false;
    written += bytes.size();
    bytes.clear();
    return true;
  };
  bool ok = true;
  if (sessions_.size() > kMaxSessions) {
    sessions_.erase(sessions_.begin(), sessions_.end() - kMaxSessions);
  }
  for (const MapSession& session : sessions_) {
    AppendRecord(RecordType::kSession, Encode(session), bytes);
  }
  for (const auto& [id, keyframe] : map.keyframes()) {
    AppendRecord(RecordType::kKeyframe, wire::Encode(keyframe.frame), bytes);
    if (bytes.size() > (size_t{1} << 20)) ok = ok && flush();
  }
  AppendRecord(RecordType::kMapUpdate, wire::Encode(map.Snapshot()), bytes);
  AppendHash(map.Hash(), bytes);
  ok = ok && flush() && fsync(file.get()) == 0;
  ok = ok && std::rename(temporary.c_str(), path.c_str()) == 0;
  if (!ok) {
    const Error error = IoError("write", path);
    unlink(temporary.c_str());
    return error;
  }
  // From here on the new generation is the one that a reader takes.
  file_ = std::move(file);  // goes on at its end
  ++generation_;
  bytes_ = checkpoint_bytes_ = written;
  oldest_unsynced_.reset();
  failure_.clear();
  if (!SyncDirectory(directory_)) return Fail(IoError("sync", directory_).message);
  return Done{};
}

}  // namespace gw::backend
