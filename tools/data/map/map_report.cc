#include "tools/data/map/map_report.h"

#include <algorithm>
#include <cinttypes>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "backend/journal/journal.h"
#include "tools/data/files/format.h"
#include "tools/data/files/json.h"

namespace gw::tools {
namespace {

namespace fs = std::filesystem;

int64_t SizeOf(const fs::path& path) {
  std::error_code error;
  const auto size = fs::file_size(path, error);
  return error ? 0 : static_cast<int64_t>(size);
}

// Each generation on its own, the one that is loaded too.
void CheckFiles(const std::string& directory, std::vector<std::string>* problems) {
  for (const int64_t generation : backend::Generations(directory)) {
    const std::string path = backend::GenerationPath(directory, generation);
    std::ifstream file(path, std::ios::binary);
    const std::vector<uint8_t> bytes{std::istreambuf_iterator<char>(file), {}};
    backend::LoadedMap loaded;
    if (!backend::ReplayGeneration(bytes, path, &loaded)) {
      problems->push_back(path + ": the checkpoint is not whole" +
                          (loaded.damage.empty() ? "" : ": " + loaded.damage));
    } else if (!loaded.damage.empty()) {
      problems->push_back(loaded.damage);
    }
  }
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(directory, error)) {
    if (entry.path().extension() == ".damaged") {
      problems->push_back(entry.path().string() +
                          ": was damaged and set aside; remove it when it is of no more use");
    }
  }
}

}  // namespace

MapReport Describe(const std::string& directory, const backend::LoadedMap& loaded) {
  MapReport out;
  out.directory = directory;
  out.generation = loaded.generation;
  out.file_bytes = SizeOf(backend::GenerationPath(directory, loaded.generation));
  out.checkpoint_bytes = static_cast<int64_t>(loaded.checkpoint_bytes);
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(directory, error)) {
    out.directory_bytes += SizeOf(entry.path());
  }
  const backend::Map& map = loaded.map;
  out.revision = map.revision();
  out.keyframes = static_cast<int64_t>(map.keyframes().size());
  out.pending_keyframes = static_cast<int64_t>(loaded.pending.size());
  out.landmarks = static_cast<int64_t>(map.num_landmarks());
  for (const auto& [id, keyframe] : map.keyframes()) {
    out.observations += keyframe.num_observations;
    out.features += static_cast<int64_t>(keyframe.frame.features.size());
  }
  if (out.keyframes > 0) {
    out.bytes_per_keyframe =
        static_cast<double>(backend::CheckpointBytes(map)) / static_cast<double>(out.keyframes);
  }
  for (size_t i = 0; i < loaded.sessions.size(); ++i) {
    const backend::MapSession& session = loaded.sessions[i];
    SessionReport report{session.begin, session.version, session.first_keyframe, 0, {}, {}};
    const KeyframeId end = i + 1 < loaded.sessions.size()
                               ? loaded.sessions[i + 1].first_keyframe
                               : KeyframeId{map.newest_keyframe().value + 1};
    for (auto it = map.keyframes().lower_bound(session.first_keyframe);
         it != map.keyframes().end() && it->first < end; ++it) {
      const Utime utime = it->second.frame.utime;
      if (report.keyframes++ == 0) report.first_utime = report.last_utime = utime;
      report.first_utime = std::min(report.first_utime, utime);
      report.last_utime = std::max(report.last_utime, utime);
    }
    out.sessions.push_back(report);
  }
  out.torn_bytes = loaded.torn ? static_cast<int64_t>(loaded.cut_bytes) : 0;
  if (!loaded.damage.empty()) out.problems.push_back(loaded.damage);
  return out;
}

Result<MapReport> CheckDirectory(const std::string& directory) {
  const auto loaded = backend::LoadMap(directory);
  if (!loaded) return loaded.error();
  if (loaded->generation == 0) {
    return Error{ErrorCode::kNotFound, directory + ": holds no map"};
  }
  MapReport report = Describe(directory, *loaded);
  report.problems.clear();  // CheckFiles says it, file by file
  CheckFiles(directory, &report.problems);
  const backend::MapFaults faults = backend::CheckMap(loaded->map);
  for (const std::string& text : faults.texts) report.problems.push_back(text);
  if (faults.count > static_cast<int64_t>(faults.texts.size())) {
    report.problems.push_back("... " + std::to_string(faults.count) + " such faults in all");
  }
  return report;
}

std::string ReportText(const MapReport& r) {
  std::string out = Format("%s: generation %" PRId64 ", revision %" PRId64 "\n",
                           r.directory.c_str(), r.generation, r.revision);
  out += Format("  keyframes     %" PRId64 " (%" PRId64 " more to be taken in)\n", r.keyframes,
                r.pending_keyframes);
  out += Format("  landmarks     %" PRId64 ", observations %" PRId64 ", features %" PRId64 "\n",
                r.landmarks, r.observations, r.features);
  out += Format("  file          %.2f MB, of it checkpoint %.2f MB; whole folder %.2f MB\n",
                static_cast<double>(r.file_bytes) * 1e-6,
                static_cast<double>(r.checkpoint_bytes) * 1e-6,
                static_cast<double>(r.directory_bytes) * 1e-6);
  out += Format("  per keyframe  %.1f kB in a checkpoint, landmarks included\n",
                r.bytes_per_keyframe * 1e-3);
  if (r.torn_bytes > 0) {
    out += Format("  torn end      %" PRId64 " bytes, cut off at the next start\n", r.torn_bytes);
  }
  int session = 0;
  for (const SessionReport& s : r.sessions) {
    out += Format("  session %-5d begun %.6f, version %s: %" PRId64 " keyframes", ++session,
                  s.begin.seconds(), s.version.c_str(), s.keyframes);
    if (s.keyframes > 0) {
      out += Format(", %.3f to %.3f s", s.first_utime.seconds(), s.last_utime.seconds());
    }
    out += "\n";
  }
  for (const std::string& problem : r.problems) out += "  problem       " + problem + "\n";
  return out;
}

std::string ReportJson(const MapReport& r) {
  Json sessions = Json::array();
  for (const SessionReport& s : r.sessions) {
    sessions.push_back({{"begin_us", s.begin.us},
                        {"version", s.version},
                        {"first_keyframe", s.first_keyframe.value},
                        {"keyframes", s.keyframes},
                        {"first_us", s.first_utime.us},
                        {"last_us", s.last_utime.us}});
  }
  return JsonLine({{"directory", r.directory},
                   {"generation", r.generation},
                   {"revision", r.revision},
                   {"keyframes", r.keyframes},
                   {"pending_keyframes", r.pending_keyframes},
                   {"landmarks", r.landmarks},
                   {"observations", r.observations},
                   {"features", r.features},
                   {"file_bytes", r.file_bytes},
                   {"checkpoint_bytes", r.checkpoint_bytes},
                   {"directory_bytes", r.directory_bytes},
                   {"bytes_per_keyframe", r.bytes_per_keyframe},
                   {"torn_bytes", r.torn_bytes},
                   {"sessions", sessions},
                   {"problems", r.problems}});
}

}  // namespace gw::tools
