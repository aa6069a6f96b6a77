#include "backend/journal/journal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>

#include "backend/core/mapper.h"
#include "backend/journal/record.h"
#include "backend/test/world.h"
#include "common/core/random.h"

namespace gw::backend {
namespace {

namespace fs = std::filesystem;

MapSession TestSession() {
  MapSession session = MakeSession({1'000'000}, TestCamera(), OrbConfig());
  session.version = "test";
  return session;
}

class JournalTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    directory_ = fs::path(testing::TempDir()) /
                 ("gw_journal_" + std::string(test->name()) + "_" + std::to_string(getpid()));
    fs::remove_all(directory_);
  }
  void TearDown() override { fs::remove_all(directory_); }

  std::string directory() const { return directory_.string(); }
  fs::path File(int generation) const {
    char name[32];
    std::snprintf(name, sizeof(name), "map-%08d.gwj", generation);
    return directory_ / name;
  }
  static std::vector<uint8_t> ReadPath(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  std::vector<uint8_t> Read(int generation) const { return ReadPath(File(generation)); }
  void Write(int generation, const std::vector<uint8_t>& bytes) const {
    fs::create_directories(directory_);
    std::ofstream out(File(generation), std::ios::binary | std::ios::trunc);
    out.write(reinterpret_cast<const char*>(bytes.data()),
              static_cast<std::streamsize>(bytes.size()));
  }
  Journal Open(const JournalOptions& options = {}) {
    auto journal = Journal::Open(directory(), options, TestSession(), loaded_);
    EXPECT_TRUE(journal.ok()) << (journal.ok() ? "" : journal.error().message);
    return std::move(*journal);
  }

  fs::path directory_;
  LoadedMap loaded_;
};

// A mapper that journals what it does, with few and small keyframes.
struct Recorder {
  Recorder() : mapper(Mapper::Create({}, {}, TestCamera()).value()) {}

  // Records one keyframe and its updates; remembers the map after each record.
  void Step(Journal& journal) {
    const Keyframe keyframe = world.Make(k, mapper.map());
    const uint64_t before = mapper.map().Hash();
    const InsertResult inserted = mapper.Insert(keyframe);
    ASSERT_TRUE(inserted.update) << inserted.reason;
    ++k;
    ASSERT_TRUE(journal.Append(keyframe, keyframe.utime).ok());
    Mark(journal, before);  // a keyframe alone changes nothing
    ASSERT_TRUE(journal.Append(*inserted.update, keyframe.utime).ok());
    Mark(journal, mapper.map().Hash());
    if (const auto job = mapper.BuildJob()) {
      const auto update = mapper.Apply(SolveLocalBa(*job));
      ASSERT_TRUE(update);
      ASSERT_TRUE(journal.Append(*update, keyframe.utime).ok());
      Mark(journal, mapper.map().Hash());
    }
  }
  void Mark(const Journal& journal, uint64_t hash) { states.push_back({journal.bytes(), hash}); }
  // The map that a file cut at `bytes` must give.
  uint64_t ExpectedHash(size_t bytes) const {
    uint64_t hash = Map().Hash();
    for (const auto& [end, state] : states) {
      if (end <= bytes) hash = state;
    }
    return hash;
  }

  // Within a header's length of the end of a record, where the interesting cuts are.
  bool NearABoundary(size_t byte) const {
    return byte < 80 || std::any_of(states.begin(), states.end(), [&](const auto& state) {
             return byte + 24 > state.first && byte < state.first + 24;
           });
  }

  World world{{.num_points = 60, .keyframes_per_lap = 160}};
  Mapper mapper;
  int k = 0;
  std::vector<std::pair<size_t, uint64_t>> states;
};

TEST_F(JournalTest, GivesBackTheMapThatWasRecorded) {
  Recorder recorder;
  {
    Journal journal = Open();
    for (int i = 0; i < 8; ++i) ASSERT_NO_FATAL_FAILURE(recorder.Step(journal));
  }
  const auto loaded = LoadMap(directory());
  ASSERT_TRUE(loaded.ok());
  EXPECT_EQ(loaded->map.Hash(), recorder.mapper.map().Hash());
  EXPECT_FALSE(loaded->torn);
  EXPECT_EQ(loaded->damage, "");
  EXPECT_TRUE(loaded->pending.empty());
}

TEST_F(JournalTest, GoesOnWhereItStopped) {
  Recorder recorder;
  for (int i = 0; i < 6; ++i) {
    Journal journal = Open();
    EXPECT_EQ(loaded_.map.Hash(), recorder.mapper.map().Hash());
    ASSERT_NO_FATAL_FAILURE(recorder.Step(journal));
  }
  EXPECT_EQ(LoadMap(directory())->map.Hash(), recorder.mapper.map().Hash());
  EXPECT_EQ(LoadMap(directory())->generation, 1);
}

TEST_F(JournalTest, AMissingDirectoryIsAnEmptyMap) {
  const auto loaded = LoadMap(directory());
  ASSERT_TRUE(loaded.ok());
  EXPECT_EQ(loaded->generation, 0);
  EXPECT_TRUE(loaded->map.keyframes().empty());
}

// Killed at any byte: what loads is the map after the last record that was complete.
TEST_F(JournalTest, CutAnywhereItLoadsAConsistentPrefix) {
  Recorder recorder;
  {
    Journal journal = Open();
    for (int i = 0; i < 4; ++i) ASSERT_NO_FATAL_FAILURE(recorder.Step(journal));
  }
  const std::vector<uint8_t> whole = Read(1);
  const size_t checkpoint = recorder.states[0].first;
  for (size_t cut = 0; cut < whole.size(); ++cut) {
    if (!recorder.NearABoundary(cut) && cut % 41 != 0) continue;
    Write(1, {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(cut)});
    const auto loaded = LoadMap(directory());
    if (!loaded.ok()) {
      // Only while not even the first checkpoint (of the empty map) is whole.
      ASSERT_LT(cut, checkpoint);
      ASSERT_EQ(loaded.error().code, ErrorCode::kBadData);
      continue;
    }
    ASSERT_EQ(loaded->map.Hash(), recorder.ExpectedHash(cut)) << cut;
    ASSERT_EQ(loaded->damage, "") << cut;
    ASSERT_EQ(loaded->torn, loaded->cut_bytes > 0) << cut;
    ASSERT_EQ(loaded->good_bytes + loaded->cut_bytes, cut);
  }
}

TEST_F(JournalTest, AfterAKillItContinuesBehindTheLastWholeRecord) {
  Recorder recorder;
  {
    Journal journal = Open();
    for (int i = 0; i < 3; ++i) ASSERT_NO_FATAL_FAILURE(recorder.Step(journal));
  }
  const uint64_t before = recorder.mapper.map().Hash();
  std::vector<uint8_t> bytes = Read(1);
  bytes.insert(bytes.end(), bytes.end() - 100, bytes.end() - 40);  // any rubbish of a torn write
  std::copy_n(bytes.begin() + 8, 16, bytes.end() - 60);            // that begins like a record
  Write(1, bytes);
  {
    Journal journal = Open();
    ASSERT_EQ(loaded_.map.Hash(), before);
    ASSERT_NO_FATAL_FAILURE(recorder.Step(journal));
  }
  EXPECT_EQ(LoadMap(directory())->map.Hash(), recorder.mapper.map().Hash());
}

TEST_F(JournalTest, AProcessKilledInTheMiddleLosesNothingItHadRecorded) {
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    LoadedMap loaded;
    auto journal = Journal::Open(directory(), {}, TestSession(), loaded);
    Recorder recorder;
    for (int i = 0; i < 5; ++i) recorder.Step(*journal);
    raise(SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  Recorder same;
  {
    Journal journal = Open();  // the dead process's lock is gone
    EXPECT_EQ(loaded_.map.newest_keyframe(), KeyframeId{5});
  }
  const uint64_t recorded = loaded_.map.Hash();
  fs::remove_all(directory());
  Journal journal = Open();
  for (int i = 0; i < 5; ++i) ASSERT_NO_FATAL_FAILURE(same.Step(journal));
  EXPECT_EQ(recorded, same.mapper.map().Hash());
}

// One flipped bit anywhere: never a crash, never taken for good.
TEST_F(JournalTest, AFlippedBitIsNeverSilentlyAccepted) {
  Recorder recorder;
  {
    Journal journal = Open();
    for (int i = 0; i < 3; ++i) ASSERT_NO_FATAL_FAILURE(recorder.Step(journal));
  }
  const std::vector<uint8_t> whole = Read(1);
  for (size_t i = 0; i < whole.size(); ++i) {
    if (!recorder.NearABoundary(i) && i % 23 != 0) continue;
    std::vector<uint8_t> flipped = whole;
    flipped[i] ^= static_cast<uint8_t>(1u << (i % 8));
    Write(1, flipped);
    const auto loaded = LoadMap(directory());
    if (!loaded.ok()) continue;
    ASSERT_NE(loaded->damage, "") << i;
    ASSERT_EQ(loaded->map.Hash(), recorder.ExpectedHash(i)) << i;
  }
}

TEST_F(JournalTest, AfterDamageItGoesOnInANewFileAndKeepsTheDamagedOne) {
  Recorder recorder;
  {
    Journal journal = Open();
    for (int i = 0; i < 4; ++i) ASSERT_NO_FATAL_FAILURE(recorder.Step(journal));
  }
  std::vector<uint8_t> bytes = Read(1);
  bytes[bytes.size() - 10] ^= 1;
  Write(1, bytes);
  const size_t before_last = recorder.states[recorder.states.size() - 2].first;
  {
    Journal journal = Open();
    EXPECT_THAT(loaded_.damage, testing::HasSubstr("wrong checksum"));
    EXPECT_EQ(loaded_.map.Hash(), recorder.ExpectedHash(before_last));
    EXPECT_EQ(journal.generation(), 2);
  }
  EXPECT_FALSE(fs::exists(File(1)));
  EXPECT_EQ(ReadPath(File(1).string() + ".damaged"), bytes);
  const auto again = LoadMap(directory());
  EXPECT_EQ(again->damage, "");
  EXPECT_EQ(again->map.Hash(), loaded_.map.Hash());
}

TEST_F(JournalTest, CheckpointsKeepTheMapAndDropTheHistory) {
  Recorder recorder;
  Journal journal = Open({.min_bytes_between_checkpoints = 1000});
  int checkpoints = 0;
  for (int i = 0; i < 40; ++i) {
    ASSERT_NO_FATAL_FAILURE(recorder.Step(journal));
    if (!journal.CheckpointDue()) continue;
    ASSERT_TRUE(journal.Checkpoint(recorder.mapper.map()).ok());
    ++checkpoints;
    ASSERT_EQ(LoadMap(directory())->map.Hash(), recorder.mapper.map().Hash());
  }
  EXPECT_GT(checkpoints, 2);
  EXPECT_EQ(journal.generation(), 1 + checkpoints);
  EXPECT_FALSE(fs::exists(File(checkpoints - 1)));
  EXPECT_TRUE(fs::exists(File(checkpoints)));
  ASSERT_NO_FATAL_FAILURE(recorder.Step(journal));
  EXPECT_EQ(LoadMap(directory())->map.Hash(), recorder.mapper.map().Hash());
}

TEST_F(JournalTest, AnUnreadableNewestGenerationFallsBackToTheOneBefore) {
  Recorder recorder;
  {
    Journal journal = Open();
    for (int i = 0; i < 3; ++i) ASSERT_NO_FATAL_FAILURE(recorder.Step(journal));
    ASSERT_TRUE(journal.Checkpoint(recorder.mapper.map()).ok());
  }
  const uint64_t at_checkpoint = recorder.mapper.map().Hash();
  std::vector<uint8_t> bytes = Read(2);
  bytes[bytes.size() / 2] ^= 4;
  Write(2, bytes);
  const auto loaded = LoadMap(directory());
  ASSERT_TRUE(loaded.ok());
  EXPECT_EQ(loaded->generation, 1);
  EXPECT_THAT(loaded->damage, testing::HasSubstr("map-00000002"));
  EXPECT_EQ(loaded->map.Hash(), at_checkpoint);
}

// The checkpoint is lost, but the generation before leads to it and its own records go on from it.
TEST_F(JournalTest, BehindADamagedCheckpointItGoesOnFromTheGenerationBefore) {
  Recorder recorder;
  {
    Journal journal = Open();
    for (int i = 0; i < 3; ++i) ASSERT_NO_FATAL_FAILURE(recorder.Step(journal));
    ASSERT_TRUE(journal.Checkpoint(recorder.mapper.map()).ok());
    for (int i = 0; i < 3; ++i) ASSERT_NO_FATAL_FAILURE(recorder.Step(journal));
  }
  std::vector<uint8_t> bytes = Read(2);
  bytes[400] ^= 4;
  Write(2, bytes);
  const auto loaded = LoadMap(directory());
  ASSERT_TRUE(loaded.ok());
  EXPECT_EQ(loaded->map.Hash(), recorder.mapper.map().Hash());
  EXPECT_THAT(loaded->damage, testing::HasSubstr("map-00000002"));
  {
    Journal journal = Open();
    ASSERT_NO_FATAL_FAILURE(recorder.Step(journal));
  }
  EXPECT_EQ(LoadMap(directory())->map.Hash(), recorder.mapper.map().Hash());
  EXPECT_EQ(LoadMap(directory())->damage, "");
  EXPECT_TRUE(fs::exists(File(1))) << "the whole generation before stays";
}

TEST_F(JournalTest, AnUpdateThatContradictsTheMapIsDamage) {
  using Edit = std::function<void(const Map&, MapUpdate&)>;
  const auto first = [](const Map& map) {
    return *map.FindLandmark(map.SortedLandmarkIds().front());
  };
  const std::pair<const char*, Edit> kEdits[] = {
      {"a feature that is not there",
       [&](const Map& map, MapUpdate& update) {
         update.landmarks = {first(map)};
         update.landmarks[0].observations = {{{1}, LandmarkId::kMaxFeatures - 1}};
       }},
      {"a feature of another landmark",
       [&](const Map& map, MapUpdate& update) {
         update.landmarks = {first(map)};
         update.landmarks[0].id = LandmarkId::From({3}, 9000);
       }},
      {"a landmark that nobody sees",
       [&](const Map& map, MapUpdate& update) {
         update.landmarks = {first(map)};
         update.landmarks[0].observations.clear();
       }},
      {"a landmark far out",
       [&](const Map& map, MapUpdate& update) {
         update.landmarks = {first(map)};
         update.landmarks[0].p_W.x() = 1e9;
       }},
      {"a keyframe at another time",
       [&](const Map& map, MapUpdate& update) {
         const Keyframe& keyframe = map.FindKeyframe({2})->frame;
         update.keyframes = {{{2}, keyframe.utime + Milliseconds(1), keyframe.T_WC}};
       }},
  };
  for (const auto& [what, edit] : kEdits) {
    fs::remove_all(directory_);
    Recorder recorder;
    const Map& map = recorder.mapper.map();
    {
      Journal journal = Open();
      for (int i = 0; i < 3; ++i) ASSERT_NO_FATAL_FAILURE(recorder.Step(journal));
      MapUpdate wrong;
      wrong.base_revision = map.revision();
      wrong.revision = wrong.base_revision + 1;
      wrong.newest_keyframe = {3};
      edit(map, wrong);
      ASSERT_TRUE(journal.Append(wrong, {}).ok());
    }
    const auto loaded = LoadMap(directory());
    ASSERT_TRUE(loaded.ok()) << what;
    EXPECT_THAT(loaded->damage, testing::HasSubstr("contradicts")) << what;
    EXPECT_EQ(loaded->map.Hash(), map.Hash()) << what;
  }
}

TEST_F(JournalTest, NotesTheSessions) {
  Recorder recorder;
  for (int i = 0; i < 3; ++i) {
    Journal journal = Open();
    ASSERT_NO_FATAL_FAILURE(recorder.Step(journal));
    ASSERT_NO_FATAL_FAILURE(recorder.Step(journal));
    if (i == 1) {
      ASSERT_TRUE(journal.Checkpoint(recorder.mapper.map()).ok());
    }
  }
  const auto loaded = LoadMap(directory());
  ASSERT_EQ(loaded->sessions.size(), 3u);
  EXPECT_EQ(loaded->sessions[0].first_keyframe, KeyframeId{1});
  EXPECT_EQ(loaded->sessions[1].first_keyframe, KeyframeId{3});
  EXPECT_EQ(loaded->sessions[2].first_keyframe, KeyframeId{5});
  EXPECT_EQ(loaded->sessions[2].version, "test");
}

TEST_F(JournalTest, AMapOfAnotherCameraIsRefusedAndLeftAlone) {
  Recorder recorder;
  {
    Journal journal = Open();
    ASSERT_NO_FATAL_FAILURE(recorder.Step(journal));
  }
  const std::vector<uint8_t> bytes = Read(1);
  MapSession other = TestSession();
  other.source.fx = 123.5;
  other.source.num_levels = 6;
  const auto journal = Journal::Open(directory(), {}, other, loaded_);
  ASSERT_FALSE(journal.ok());
  EXPECT_EQ(journal.error().code, ErrorCode::kBadConfig);
  EXPECT_THAT(journal.error().message, testing::HasSubstr("(now 123.5)"));
  EXPECT_THAT(journal.error().message, testing::HasSubstr("orb.num_levels 8 (now 6)"));
  EXPECT_EQ(Read(1), bytes);
}

TEST_F(JournalTest, AnotherFormatVersionIsRefusedEvenIfAnOlderGenerationCouldBeRead) {
  Recorder recorder;
  {
    Journal journal = Open();
    ASSERT_NO_FATAL_FAILURE(recorder.Step(journal));
    ASSERT_TRUE(journal.Checkpoint(recorder.mapper.map()).ok());
  }
  std::vector<uint8_t> bytes = Read(2);
  bytes[6] = '9';
  Write(2, bytes);
  const auto journal = Journal::Open(directory(), {}, TestSession(), loaded_);
  ASSERT_FALSE(journal.ok());
  EXPECT_THAT(journal.error().message, testing::HasSubstr("format version"));
  EXPECT_EQ(Read(2), bytes);
  EXPECT_FALSE(fs::exists(File(3)));
}

TEST_F(JournalTest, TheFormatVersionBeforeIsReadAndGoesOnInANewGeneration) {
  Recorder recorder;
  {
    Journal journal = Open();
    ASSERT_NO_FATAL_FAILURE(recorder.Step(journal));
  }
  std::vector<uint8_t> bytes = Read(1);
  std::copy(kFileMagicBefore.begin(), kFileMagicBefore.end(), bytes.begin());
  Write(1, bytes);
  {
    Journal journal = Open();
    EXPECT_EQ(loaded_.map.Hash(), recorder.mapper.map().Hash());
    EXPECT_EQ(journal.generation(), 2);
    ASSERT_NO_FATAL_FAILURE(recorder.Step(journal));
  }
  EXPECT_EQ(Read(1), bytes);
  EXPECT_TRUE(BeginsWith(Read(2), kFileMagic));
  Open();
  EXPECT_EQ(loaded_.map.Hash(), recorder.mapper.map().Hash());
}

TEST_F(JournalTest, SyncsWhenTheOldestRecordIsOldEnough) {
  Recorder recorder;
  Journal journal = Open({.sync_interval = Milliseconds(200)});
  ASSERT_NO_FATAL_FAILURE(recorder.Step(journal));
  const Utime now = recorder.mapper.map().newest_utime();
  EXPECT_TRUE(journal.SyncIfDue(now + Milliseconds(100)).ok());
  EXPECT_TRUE(journal.SyncIfDue(now + Milliseconds(300)).ok());
}

TEST_F(JournalTest, ASecondWriterIsRefused) {
  Journal journal = Open();
  LoadedMap loaded;
  const auto second = Journal::Open(directory(), {}, TestSession(), loaded);
  ASSERT_FALSE(second.ok());
  EXPECT_THAT(second.error().message, testing::HasSubstr("another process"));
}

TEST_F(JournalTest, ADirectoryThatCannotBeMadeIsAClearError) {
  fs::create_directories(directory_);
  std::ofstream(directory_ / "file") << "x";
  LoadedMap loaded;
  const auto journal =
      Journal::Open((directory_ / "file" / "map").string(), {}, TestSession(), loaded);
  ASSERT_FALSE(journal.ok());
  EXPECT_EQ(journal.error().code, ErrorCode::kIo);
  EXPECT_THAT(journal.error().message, testing::HasSubstr("file/map"));
}

// A limit on the file size stands in for a full disk.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(size_t bytes) {
    old_handler_ = std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &old_);
    rlimit limit = old_;
    limit.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &old_);
    std::signal(SIGXFSZ, old_handler_);
  }

 private:
  rlimit old_{};
  void (*old_handler_)(int) = nullptr;
};

TEST_F(JournalTest, AFullDiskFailsTheJournalLosesNothingAndHealsWithACheckpoint) {
  Recorder recorder;
  Journal journal = Open();
  for (int i = 0; i < 4; ++i) ASSERT_NO_FATAL_FAILURE(recorder.Step(journal));
  const uint64_t recorded = recorder.mapper.map().Hash();
  const Keyframe keyframe = recorder.world.Make(4, recorder.mapper.map());
  const InsertResult inserted = recorder.mapper.Insert(keyframe);
  {
    const FileSizeLimit full(journal.bytes() + 500);
    const auto appended = journal.Append(keyframe, keyframe.utime);
    ASSERT_FALSE(appended.ok());
    EXPECT_EQ(appended.error().code, ErrorCode::kIo);
    EXPECT_TRUE(journal.failed());
  }
  {
    const FileSizeLimit full(1000);
    EXPECT_FALSE(journal.Checkpoint(recorder.mapper.map()).ok());
  }
  // The disk has room again, but there would be a gap.
  EXPECT_FALSE(journal.Append(*inserted.update, keyframe.utime).ok());
  EXPECT_TRUE(journal.CheckpointDue());
  const auto loaded = LoadMap(directory());
  ASSERT_TRUE(loaded.ok());
  EXPECT_EQ(loaded->map.Hash(), recorded);
  EXPECT_EQ(loaded->damage, "");

  ASSERT_TRUE(journal.Checkpoint(recorder.mapper.map()).ok());
  EXPECT_FALSE(journal.failed());
  recorder.k = 5;
  ASSERT_NO_FATAL_FAILURE(recorder.Step(journal));
  EXPECT_EQ(LoadMap(directory())->map.Hash(), recorder.mapper.map().Hash());
}

TEST_F(JournalTest, ACheckpointThatDoesNotFitLeavesTheJournalGoingOn) {
  Recorder recorder;
  Journal journal = Open();
  for (int i = 0; i < 3; ++i) ASSERT_NO_FATAL_FAILURE(recorder.Step(journal));
  {
    const FileSizeLimit full(1000);
    EXPECT_FALSE(journal.Checkpoint(recorder.mapper.map()).ok());
  }
  EXPECT_FALSE(journal.failed());
  ASSERT_NO_FATAL_FAILURE(recorder.Step(journal));
  EXPECT_EQ(LoadMap(directory())->map.Hash(), recorder.mapper.map().Hash());
  EXPECT_EQ(journal.generation(), 1);
}

}  // namespace
}  // namespace gw::backend
