#include "backend/journal/load.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <limits>
#include <optional>
#include <utility>

#include "backend/journal/record.h"
#include "common/process/file_handle.h"
#include "common/wire/wire.h"

namespace gw::backend {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPrefix = "map-";
constexpr std::string_view kSuffix = ".gwj";

Result<std::vector<uint8_t>> ReadFile(const std::string& path) {
  const auto error = [&] {
    return Error{ErrorCode::kIo, "map: cannot read " + path + ": " + std::strerror(errno)};
  };
  const process::FileHandle file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat status {};
  if (!file.valid() || fstat(file.get(), &status) != 0) return error();
  std::vector<uint8_t> out(static_cast<size_t>(status.st_size));
  size_t done = 0;
  while (done < out.size()) {
    const ssize_t n = read(file.get(), out.data() + done, out.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return error();
    if (n == 0) break;
    done += static_cast<size_t>(n);
  }
  out.resize(done);
  return out;
}

uint64_t ReadHash(std::span<const uint8_t> payload) {
  uint64_t hash = 0;
  for (size_t i = 0; i < 8; ++i) hash |= uint64_t{payload[i]} << (8 * i);
  return hash;
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
        return Apply(*update);
      }
      case RecordType::kCheckpoint: {
        if (record.payload.size() != 8) return Fault("checkpoint record of wrong size");
        if (ReadHash(record.payload) != out_.map.Hash()) {
          return Fault("the checkpoint is not the map that was written");
        }
        out_.checkpoint_bytes = record.end;
        return true;
      }
      case RecordType::kSession: {
        auto session = DecodeMapSession(record.payload);
        if (!session) return Fault(session.error().message);
        out_.sessions.push_back(std::move(*session));
        return true;
      }
    }
    return Fault("record of unknown type");
  }
  const std::string& fault() const { return fault_; }
  // The record at fault has changed the map already.
  bool spoiled() const { return spoiled_; }

 private:
  bool Fault(std::string text) {
    fault_ = std::move(text);
    return false;
  }

  bool Apply(const MapUpdate& update) {
    Map& map = out_.map;
    if (!update.snapshot && update.base_revision != map.revision()) {
      return Fault("an update does not follow the one before");
    }
    spoiled_ = true;
    for (const Keyframe& keyframe : out_.pending) {
      if (!map.AddKeyframe(keyframe)) return Fault("a keyframe repeats an id or is not plausible");
    }
    out_.pending.clear();
    const int64_t ignored = map.num_ignored();
    map.Apply(update);
    const bool observed = std::none_of(update.landmarks.begin(), update.landmarks.end(),
                                       [](const auto& l) { return l.observations.empty(); });
    if (map.num_ignored() != ignored || !observed) return Fault("an update contradicts the map");
    spoiled_ = false;
    return true;
  }

  LoadedMap& out_;
  std::string fault_;
  bool spoiled_ = false;
};

// Takes records until the end, a fault, or `max_records`. False: the last one has spoiled the map.
bool TakeRecords(RecordReader& reader, const std::string& name, int64_t max_records,
                 LoadedMap* out) {
  Replay replay(*out);
  RecordView record{};
  RecordReader::State state = RecordReader::State::kOk;
  out->good_bytes = reader.good_end();
  while (out->num_records < max_records) {
    state = reader.Next(record);
    if (state != RecordReader::State::kOk || !replay.Take(record)) break;
    out->good_bytes = record.end;
    ++out->num_records;
  }
  out->torn = state == RecordReader::State::kTorn;
  const std::string where = " in " + name + " at byte " + std::to_string(out->good_bytes) +
                            "; the map is the one recorded before it";
  if (!replay.fault().empty()) {
    out->damage = replay.fault() + where;
  } else if (state == RecordReader::State::kDamaged) {
    out->damage = "wrong checksum" + where;
  }
  return !replay.spoiled();
}

// The hash that the file's checkpoint claims, and a reader that stands behind it. Records before it
// may be damaged; its own checksum holds.
std::optional<std::pair<uint64_t, RecordReader>> FindCheckpoint(const std::vector<uint8_t>& bytes) {
  RecordReader reader(bytes);
  RecordView record{};
  while (true) {
    const RecordReader::State state = reader.Next(record);
    if (state != RecordReader::State::kOk) {
      if (!reader.Resync()) return std::nullopt;
      continue;
    }
    if (record.type == RecordType::kCheckpoint && record.payload.size() == 8) {
      return std::make_pair(ReadHash(record.payload), reader);
    }
  }
}

// Goes on with what a generation with a damaged checkpoint recorded behind it, if the map that we
// have is the one it began with.
void RollForward(const std::string& path, const std::vector<uint8_t>& bytes, LoadedMap* loaded) {
  const auto checkpoint = FindCheckpoint(bytes);
  if (!checkpoint || checkpoint->first != loaded->map.Hash() || !loaded->pending.empty()) return;
  constexpr int64_t kAll = std::numeric_limits<int64_t>::max();
  LoadedMap trial = *loaded;
  RecordReader reader = checkpoint->second;
  if (!TakeRecords(reader, path, kAll, &trial)) {
    const int64_t good = trial.num_records;
    trial = *loaded;
    reader = checkpoint->second;
    TakeRecords(reader, path, good, &trial);
  }
  trial.cut_bytes = bytes.size() - trial.good_bytes;
  trial.damage =
      loaded->damage + "what " + path + " recorded behind its checkpoint is there; " + trial.damage;
  *loaded = std::move(trial);
}

}  // namespace

std::string GenerationPath(const std::string& directory, int64_t generation) {
  return fmt::format("{}/map-{:08}.gwj", directory, generation);
}

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

bool ReplayGeneration(const std::vector<uint8_t>& bytes, const std::string& name, LoadedMap* out) {
  *out = LoadedMap();
  RecordReader reader(bytes);
  if (!TakeRecords(reader, name, std::numeric_limits<int64_t>::max(), out)) {
    const int64_t good = out->num_records;
    const std::string damage = out->damage;
    *out = LoadedMap();
    RecordReader again(bytes);
    TakeRecords(again, name, good, out);
    out->damage = damage;
  }
  out->cut_bytes = bytes.size() - out->good_bytes;
  return out->checkpoint_bytes > 0;
}

Result<LoadedMap> LoadMap(const std::string& directory) {
  LoadedMap out;
  const std::vector<int64_t> generations = Generations(directory);
  if (generations.empty()) return out;
  std::vector<std::pair<std::string, std::vector<uint8_t>>> unusable;  // newest first
  std::string report;
  for (const int64_t generation : generations) {
    const std::string path = GenerationPath(directory, generation);
    auto bytes = ReadFile(path);
    if (!bytes) return bytes.error();
    if (IsOtherVersion(*bytes)) {
      return Error{ErrorCode::kBadData,
                   "map: " + path + " is of another format version (this program reads version " +
                       kFileMagic[kFileMagic.size() - 2] +
                       "); use the program that wrote it, or move the directory away"};
    }
    if (!ReplayGeneration(*bytes, path, &out)) {
      report += "the checkpoint of " + path +
                " cannot be used: " + (out.damage.empty() ? "the file is cut off" : out.damage) +
                "; ";
      unusable.emplace_back(path, std::move(*bytes));
      continue;
    }
    out.generation = generation;
    out.older_format = BeginsWith(*bytes, kFileMagicBefore);
    out.newest_generation = generations.front();
    const bool whole = out.damage.empty();
    if (!whole) out.damaged_files.push_back(path);
    for (const auto& [file, content] : unusable) out.damaged_files.push_back(file);
    out.damage = report + out.damage;
    for (auto it = unusable.rbegin(); whole && it != unusable.rend(); ++it) {
      RollForward(it->first, it->second, &out);
    }
    return out;
  }
  return Error{ErrorCode::kBadData, "map: " + report +
                                        "no older one is left. Move the directory away to start "
                                        "a new map"};
}

Result<Done> CheckSource(const std::string& directory, const LoadedMap& loaded,
                         const FeatureSource& source) {
  if (loaded.sessions.empty()) return Done{};
  const std::string differs = Difference(loaded.sessions.back().source, source);
  if (differs.empty()) return Done{};
  return Error{ErrorCode::kBadConfig, "map: " + directory +
                                          " was made with another camera: " + differs +
                                          ". Use the robot YAML of the map, or another folder"};
}

Result<LoadedMap> LoadMapFor(const std::string& directory, const FeatureSource& source) {
  auto loaded = LoadMap(directory);
  if (!loaded) return loaded;
  if (loaded->generation == 0) {
    return Error{ErrorCode::kNotFound, "map: " + directory + " holds no map"};
  }
  const auto checked = CheckSource(directory, *loaded, source);
  if (!checked) return checked.error();
  return loaded;
}

}  // namespace gw::backend
