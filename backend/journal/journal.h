// The map on disk: survives a kill at any byte, a full disk, and says so when the disk lies.
//
// A directory holds files map-GENERATION.gwj. Each begins with a checkpoint (the sessions and the
// whole map) and goes on with what came after: keyframes as inserted, updates as published. When a
// file has grown to twice its checkpoint, a new generation is written beside it, synced, and takes
// over by rename; the one before is kept until the next. So the directory holds at most four times
// what the map itself needs (plus twice min_bytes_between_checkpoints), and a start reads at most
// twice that.
//
// load.h reads it: the newest generation whose checkpoint is whole, replayed up to the first record
// that is torn (cut off, normal after a kill) or damaged (reported). What it gives is always the
// map after some published update.
//
// When writing fails (full disk, directory gone) the journal cuts the unfinished record off, stays
// Failed, and refuses further records: the map on disk is the last one that was complete. A
// Checkpoint() that succeeds, later, makes it whole again.
//
// No clock: the caller passes the time. One thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "backend/core/map/map.h"
#include "backend/journal/load.h"
#include "backend/journal/map_session.h"
#include "common/core/result.h"
#include "common/core/time.h"
#include "common/process/file_handle.h"

namespace gw::backend {

// Size of a checkpoint of the map, but for its sessions.
size_t CheckpointBytes(const Map& map);

struct JournalOptions {
  DurationUs sync_interval = Milliseconds(200);  // longest time that a record stays unsynced
  // A checkpoint is due when this much, and as much as the last checkpoint, was appended since.
  size_t min_bytes_between_checkpoints = size_t{16} << 20;
};

// Writes what was loaded, or made, into a directory of its own, as a map with one generation.
// Errors: kIo when it cannot be written, or the directory holds a map already.
Result<Done> SaveMap(const std::string& directory, const LoadedMap& content);

class Journal {
 public:
  // Loads the directory (made when missing) and continues its newest generation: a torn end is cut
  // off; after damage a new generation is started from what could be read, and the damaged files
  // stay beside it as *.damaged, for good. Notes the session (its first_keyframe is set here).
  // Errors: kBadConfig when the map was made with another camera or pyramid; kIo when another
  // process has the lock, or nothing can be written; those of LoadMap. After an error the directory
  // is as it was.
  static Result<Journal> Open(const std::string& directory, const JournalOptions& options,
                              MapSession session, LoadedMap& loaded);
  Journal(Journal&&) noexcept = default;
  Journal& operator=(Journal&&) noexcept = default;
  ~Journal();  // syncs

  // Appends a record. Error kIo: it is not in the journal, which is Failed from now on.
  Result<Done> Append(const Keyframe& keyframe, Utime now);
  Result<Done> Append(const MapUpdate& update, Utime now);
  // Syncs to disk when the oldest unsynced record is older than sync_interval.
  Result<Done> SyncIfDue(Utime now);

  // True when the file has grown enough to be worth a checkpoint, or the journal has failed.
  bool CheckpointDue() const;
  // Bytes appended since the last checkpoint.
  size_t grown() const { return bytes_ - checkpoint_bytes_; }
  // Starts a new generation with the whole map. Precondition: the map has no uncommitted changes,
  // and is what the records so far lead to (or the journal has failed). When it fails, the journal
  // goes on in the old generation if that is good.
  Result<Done> Checkpoint(const Map& map);

  bool failed() const { return !failure_.empty(); }
  const std::string& failure() const { return failure_; }
  int64_t generation() const { return generation_; }
  size_t bytes() const { return bytes_; }  // of the current file
  const std::vector<MapSession>& sessions() const { return sessions_; }

 private:
  Journal() = default;
  friend Result<Done> SaveMap(const std::string& directory, const LoadedMap& content);

  Result<Done> Lock();
  Result<Done> Continue(const LoadedMap& loaded);
  Result<Done> StartAnew(const LoadedMap& loaded, Utime now);
  Result<Done> AppendBytes(const std::vector<uint8_t>& bytes, Utime now);
  Result<Done> Sync();
  Result<Done> WriteGeneration(const Map& map);
  void DropOldGenerations() const;
  Result<Done> Fail(const std::string& what);

  std::string directory_;
  JournalOptions options_;
  std::vector<MapSession> sessions_;  // the last is ours
  process::FileHandle lock_;
  process::FileHandle file_;
  int64_t generation_ = 0;
  size_t bytes_ = 0;
  size_t checkpoint_bytes_ = 0;
  std::optional<Utime> oldest_unsynced_;
  std::string failure_;
};

}  // namespace gw::backend
