// The map on disk: survives a kill at any byte, a full disk, and says so when the disk lies.
//
// A directory holds files map-GENERATION.gwj. Each begins with a checkpoint (the whole map) and
// goes on with what came after: keyframes as inserted, updates as published. When a file has grown
// much larger than its checkpoint, a new generation is written beside it, synced, and takes over by
// rename; the one before is kept until the next.
//
// Loading takes the newest generation whose checkpoint is whole and replays what follows, up to the
// first record that is torn (cut off, normal after a kill) or damaged (reported). What it returns
// is always the map after some published update.
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

#include "backend/core/map.h"
#include "common/core/result.h"
#include "common/core/time.h"

namespace gw::backend {

struct LoadedMap {
  Map map;
  // Keyframes at the end that no update followed: they were taken in when the process died. Insert
  // them again.
  std::vector<Keyframe> pending;
  int64_t generation = 0;  // 0: the directory holds no map
  int64_t num_records = 0;
  size_t good_bytes = 0;  // of the file, up to the last good record
  size_t cut_bytes = 0;   // behind that: torn or damaged
  bool torn = false;      // the end was cut off in the middle of a record
  // Empty, or what is wrong and in which file: a checksum, a gap in the revisions, a whole
  // generation that cannot be read.
  std::string damage;
};

// Reads; changes nothing on disk. A directory that does not exist, or is empty, gives an empty map.
// Errors: kIo when a file cannot be read; kBadData when there are journals but none can be used.
Result<LoadedMap> LoadMap(const std::string& directory);

struct JournalOptions {
  DurationUs sync_interval = Milliseconds(200);  // longest time that a record stays unsynced
  // A checkpoint is due when this much, and four times the last checkpoint, was appended since.
  size_t min_bytes_between_checkpoints = size_t{64} << 20;
};

class Journal {
 public:
  // Loads the directory (made when missing) and continues its newest generation: a torn end is cut
  // off; after damage a new generation is started from what could be read, the damaged file stays
  // beside it. Holds a lock: kIo when another process has it, or when nothing can be written.
  static Result<Journal> Open(const std::string& directory, const JournalOptions& options,
                              LoadedMap& loaded);
  Journal(Journal&& other) noexcept;
  Journal& operator=(Journal&& other) noexcept;
  ~Journal();  // syncs

  // Appends a record. Error kIo: it is not in the journal, which is Failed from now on.
  Result<Done> Append(const Keyframe& keyframe, Utime now);
  Result<Done> Append(const MapUpdate& update, Utime now);
  // Syncs to disk when the oldest unsynced record is older than sync_interval.
  Result<Done> SyncIfDue(Utime now);

  // Whether the file has grown enough to be worth a checkpoint (or the journal has failed).
  bool CheckpointDue() const;
  // Starts a new generation with the whole map. Precondition: the map has no uncommitted changes,
  // and is what the records so far lead to (or the journal has failed).
  Result<Done> Checkpoint(const Map& map);

  bool failed() const { return !failure_.empty(); }
  const std::string& failure() const { return failure_; }
  int64_t generation() const { return generation_; }
  size_t bytes() const { return bytes_; }  // of the current file

 private:
  Journal() = default;
  Result<Done> AppendBytes(const std::vector<uint8_t>& bytes, Utime now);
  Result<Done> Sync();
  Result<Done> Fail(const std::string& what);
  void Close();

  std::string directory_;
  JournalOptions options_;
  int lock_fd_ = -1;
  int fd_ = -1;
  int64_t generation_ = 0;
  size_t bytes_ = 0;
  size_t checkpoint_bytes_ = 0;
  std::optional<Utime> oldest_unsynced_;
  std::string failure_;
};

}  // namespace gw::backend
