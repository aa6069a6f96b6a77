// Reads the map on disk. The files are described in journal.h.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "backend/core/map/map.h"
#include "backend/journal/map_session.h"
#include "common/core/result.h"

namespace gw::backend {

struct LoadedMap {
  Map map;
  // Keyframes at the end that no update followed: they were taken in when the process died. Insert
  // them again.
  std::vector<Keyframe> pending;
  std::vector<MapSession> sessions;  // oldest first
  int64_t generation = 0;            // of the file it comes from; 0: the directory holds no map
  int64_t newest_generation = 0;     // also of those that cannot be used
  int64_t num_records = 0;
  size_t checkpoint_bytes = 0;  // of the file, up to the end of its checkpoint
  size_t good_bytes = 0;        // of the file, up to the last good record
  size_t cut_bytes = 0;         // behind that: torn or damaged
  bool torn = false;            // the end was cut off in the middle of a record
  bool older_format = false;    // the file is of the format version before
  // Empty, or what is wrong, in which file and where: a checksum, a gap in the revisions, an
  // update that contradicts the map, a whole generation that cannot be read.
  std::string damage;
  std::vector<std::string> damaged_files;  // whose records could not all be used; paths
};

// The newest consistent map in the directory. Changes nothing on disk; a directory that does not
// exist, or is empty, gives an empty map. When the checkpoint of the newest generation is damaged,
// the generation before it is read, and where that leads exactly to the checkpoint that is lost,
// what was recorded behind it follows.
// Errors: kIo when a file cannot be read; kBadData when there are journals but none can be used, or
// the newest is of another format version.
Result<LoadedMap> LoadMap(const std::string& directory);

// The same, for use with features of `source`. Further errors: kBadConfig when the map was made
// with another camera or pyramid, kNotFound when there is none.
Result<LoadedMap> LoadMapFor(const std::string& directory, const FeatureSource& source);
// Done, or the error kBadConfig of LoadMapFor. An empty map takes any source.
Result<Done> CheckSource(const std::string& directory, const LoadedMap& loaded,
                         const FeatureSource& source);

// Generations in the directory, newest first.
std::vector<int64_t> Generations(const std::string& directory);
std::string GenerationPath(const std::string& directory, int64_t generation);

// Decodes and replays the bytes of one file into `out`; `name` is for texts. False when its
// checkpoint is not whole (out.damage says why): nothing in `out` can be used then.
bool ReplayGeneration(const std::vector<uint8_t>& bytes, const std::string& name, LoadedMap* out);

}  // namespace gw::backend
