// What a map on disk holds, and whether it is whole.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "backend/core/map/map_check.h"
#include "backend/journal/load.h"
#include "common/core/result.h"

namespace gw::tools {

struct SessionReport {
  Utime begin;
  std::string version;
  KeyframeId first_keyframe;
  int64_t keyframes = 0;  // of it that are still in the map
  // Times of the first and last of these keyframes; equal to each other without any.
  Utime first_utime, last_utime;
};

struct MapReport {
  std::string directory;
  int64_t generation = 0;  // 0: no map
  int64_t file_bytes = 0;  // of that generation
  int64_t checkpoint_bytes = 0;
  int64_t directory_bytes = 0;  // of all files
  int64_t revision = 0;
  int64_t keyframes = 0;
  int64_t pending_keyframes = 0;  // recorded, taken in at the next start
  int64_t landmarks = 0;
  int64_t observations = 0;
  int64_t features = 0;
  double bytes_per_keyframe = 0;  // of the map written as a checkpoint; 0 without keyframes
  std::vector<SessionReport> sessions;
  int64_t torn_bytes = 0;  // at the end, of a record that was cut off: normal after a kill
  std::vector<std::string> problems;
};

MapReport Describe(const std::string& directory, const backend::LoadedMap& loaded);

// Everything that can be checked: each checksum of each generation, that each leads to a map, the
// invariants of the newest one, files that were set aside as damaged.
// Error: those of LoadMap, and kNotFound when there is no map.
Result<MapReport> CheckDirectory(const std::string& directory);

std::string ReportText(const MapReport& report);
std::string ReportJson(const MapReport& report);

}  // namespace gw::tools
