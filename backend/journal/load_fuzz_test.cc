// Mutated map files: whatever is on the disk, loading ends with a map that holds together, and
// damage is never taken for good. A few hundred files by default, GW_FUZZ_FILES=N for more.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <set>

#include "backend/core/map/map_check.h"
#include "backend/core/mapper.h"
#include "backend/journal/load.h"
#include "backend/journal/map_session.h"
#include "backend/journal/record.h"
#include "backend/test/world.h"
#include "common/core/random.h"

namespace gw::backend {
namespace {

using Bytes = std::vector<uint8_t>;

int NumFiles() {
  const char* text = std::getenv("GW_FUZZ_FILES");
  return text == nullptr ? 300 : std::atoi(text);
}

struct Record {
  RecordType type;
  Bytes payload;
};

// A whole generation: a checkpoint in the middle of a drive, and what came after it.
struct Original {
  std::vector<Record> records;
  std::set<uint64_t> states;  // Map::Hash() behind each record of the tail

  Original() {
    World world({.num_points = 40, .outlier_share = 0.05, .keyframes_per_lap = 160});
    Mapper mapper = *Mapper::Create({}, {}, TestCamera());
    const auto add = [&](RecordType type, Bytes payload) {
      records.push_back({type, std::move(payload)});
      states.insert(mapper.map().Hash());
    };
    for (int k = 0; k < 9; ++k) {
      const Keyframe keyframe = world.Make(k, mapper.map());
      const InsertResult inserted = mapper.Insert(keyframe);
      const bool tail = k >= 4;
      if (tail) {
        records.push_back({RecordType::kKeyframe, wire::Encode(keyframe)});
        add(RecordType::kMapUpdate, wire::Encode(*inserted.update));
      }
      if (const auto job = mapper.BuildJob()) {
        const auto update = mapper.Apply(SolveLocalBa(*job));
        if (tail && update) add(RecordType::kMapUpdate, wire::Encode(*update));
      }
      if (k == 3) WriteCheckpoint(mapper.map());
    }
  }

  void WriteCheckpoint(const Map& map) {
    records.push_back({RecordType::kSession, Encode(MakeSession({1}, TestCamera(), OrbConfig()))});
    for (const auto& [id, keyframe] : map.keyframes()) {
      records.push_back({RecordType::kKeyframe, wire::Encode(keyframe.frame)});
    }
    records.push_back({RecordType::kMapUpdate, wire::Encode(map.Snapshot())});
    Bytes hash;
    for (int i = 0; i < 8; ++i) hash.push_back(static_cast<uint8_t>(map.Hash() >> (8 * i)));
    records.push_back({RecordType::kCheckpoint, hash});
    states.insert(map.Hash());
  }
};

Bytes FileOf(const std::vector<Record>& records) {
  Bytes out(kFileMagic.begin(), kFileMagic.end());
  for (const Record& record : records) AppendRecord(record.type, record.payload, out);
  return out;
}

// What a disk, a bug or a stranger does to bytes.
void Mutate(CounterRng& rng, Bytes* bytes) {
  const auto place = [&] { return rng.Below(static_cast<uint32_t>(bytes->size())); };
  if (bytes->empty()) return;
  const auto at = static_cast<std::ptrdiff_t>(place());
  const auto end =
      std::min<std::ptrdiff_t>(at + 1 + rng.Below(200), static_cast<std::ptrdiff_t>(bytes->size()));
  switch (rng.Below(7)) {
    case 0:
      (*bytes)[place()] ^= static_cast<uint8_t>(1u << rng.Below(8));
      return;
    case 1:
      (*bytes)[place()] = static_cast<uint8_t>(rng.Below(256));
      return;
    case 2:
      std::fill(bytes->begin() + at, bytes->begin() + end, rng.Below(2) == 0 ? 0 : 0xFF);
      return;
    case 3:
      bytes->erase(bytes->begin() + at, bytes->begin() + end);
      return;
    case 4: {
      const Bytes copy(bytes->begin() + at, bytes->begin() + end);
      bytes->insert(bytes->begin() + static_cast<std::ptrdiff_t>(place()), copy.begin(),
                    copy.end());
      return;
    }
    case 5:  // an interesting big-endian word: counts and lengths
      for (size_t i = 0, from = place(); i < 4 && from + i < bytes->size(); ++i) {
        constexpr uint32_t kWords[] = {0, 1, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 0x10000};
        (*bytes)[from + i] = static_cast<uint8_t>(kWords[rng.Below(6)] >> (8 * (3 - i)));
      }
      return;
    default:
      bytes->resize(place());
  }
}

// Bytes of the file change: every change but in a part nothing reads must be found.
TEST(LoadFuzz, ABrokenChecksumIsNeverAcceptedSilently) {
  const Original original;
  const Bytes whole = FileOf(original.records);
  int found = 0;
  for (int n = 0; n < NumFiles(); ++n) {
    CounterRng rng(1, 1, static_cast<uint64_t>(n));
    Bytes bytes = whole;
    for (uint32_t i = 0; i <= rng.Below(3); ++i) Mutate(rng, &bytes);
    LoadedMap loaded;
    const bool usable = ReplayGeneration(bytes, "file", &loaded);
    if (!usable) {
      ++found;
      continue;
    }
    ASSERT_TRUE(original.states.contains(loaded.map.Hash())) << "file " << n;
    if (bytes == whole) continue;
    const bool prefix =
        bytes.size() < whole.size() && std::equal(bytes.begin(), bytes.end(), whole.begin());
    ASSERT_TRUE(prefix || loaded.cut_bytes > 0) << "file " << n;
    ASSERT_TRUE(prefix || loaded.torn || !loaded.damage.empty()) << "file " << n;
    ++found;
  }
  EXPECT_GT(found, NumFiles() / 2);
}

// The checksums are right and the contents wrong: no crash, and what is accepted holds together and
// can be driven on.
TEST(LoadFuzz, WrongContentsGiveAMapThatHoldsTogetherOrNone) {
  const Original original;
  int accepted = 0;
  for (int n = 0; n < NumFiles(); ++n) {
    CounterRng rng(1, 2, static_cast<uint64_t>(n));
    std::vector<Record> records = original.records;
    for (uint32_t i = 0; i <= rng.Below(3); ++i) {
      const uint32_t which = rng.Below(static_cast<uint32_t>(records.size()));
      const auto position = records.begin() + which;
      switch (rng.Below(8)) {
        case 0:
          records.erase(position);
          break;
        case 1:
          records.insert(position, records[rng.Below(static_cast<uint32_t>(records.size()))]);
          break;
        case 2:
          position->type = static_cast<RecordType>(rng.Below(6));
          break;
        default:
          Mutate(rng, &position->payload);
      }
      if (records.empty()) break;
    }
    LoadedMap loaded;
    if (!ReplayGeneration(FileOf(records), "file", &loaded)) continue;
    ++accepted;
    const MapFaults faults = CheckMap(loaded.map);
    ASSERT_EQ(faults.count, 0) << "file " << n << ": " << faults.texts.front();
    World world({.num_points = 40, .keyframes_per_lap = 160});
    Mapper mapper = *Mapper::Create({}, {}, TestCamera(), loaded.map);
    for (const Keyframe& keyframe : loaded.pending) mapper.Insert(keyframe);
    if (const auto job = mapper.BuildJob()) mapper.Apply(SolveLocalBa(*job));
  }
  EXPECT_GT(accepted, NumFiles() / 20) << "the mutations never reach behind the checkpoint";
}

}  // namespace
}  // namespace gw::backend
