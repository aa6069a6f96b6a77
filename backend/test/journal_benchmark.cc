// Start-up and size of the map on disk: what a restarted gw-backend waits for, over the number of
// keyframes. Keyframes as on a robot: some 700 features each, landmarks seen by several.
#include <benchmark/benchmark.h>
#include <unistd.h>

#include <filesystem>

#include "backend/core/mapper.h"
#include "backend/journal/journal.h"
#include "backend/test/world.h"

namespace gw::backend {
namespace {

Map Driven(int keyframes) {
  World world({.num_points = 9000, .keyframes_per_lap = 200});
  Mapper mapper = Mapper::Create({}, {}, TestCamera()).value();
  for (int k = 0; k < keyframes; ++k) mapper.Insert(world.Make(k, mapper.map()));
  return mapper.map();
}

std::string Scratch() {
  return (std::filesystem::temp_directory_path() / ("gw_map_" + std::to_string(getpid()))).string();
}

void BM_LoadMap(benchmark::State& state) {
  const std::string directory = Scratch();
  const Map map = Driven(static_cast<int>(state.range(0)));
  LoadedMap content;
  content.map = map;
  if (!SaveMap(directory, content)) return state.SkipWithError("cannot write");
  for (auto _ : state) benchmark::DoNotOptimize(LoadMap(directory));
  state.counters["landmarks"] = static_cast<double>(map.num_landmarks());
  state.counters["bytes_per_keyframe"] =
      static_cast<double>(CheckpointBytes(map)) / static_cast<double>(state.range(0));
  std::filesystem::remove_all(directory);
}
BENCHMARK(BM_LoadMap)->Arg(100)->Arg(400)->Unit(benchmark::kMillisecond);

// The second half of a start: a mapper around the map that was loaded.
void BM_StartMapper(benchmark::State& state) {
  const Map map = Driven(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    benchmark::DoNotOptimize(Mapper::Create({}, {}, TestCamera(), map));
  }
}
BENCHMARK(BM_StartMapper)->Arg(100)->Arg(400)->Unit(benchmark::kMillisecond);

void BM_Checkpoint(benchmark::State& state) {
  const std::string directory = Scratch();
  const Map map = Driven(static_cast<int>(state.range(0)));
  LoadedMap loaded;
  auto journal = Journal::Open(directory, {}, MakeSession({}, TestCamera(), OrbConfig()), loaded);
  if (!journal) return state.SkipWithError("cannot write");
  for (auto _ : state) benchmark::DoNotOptimize(journal->Checkpoint(map));
  std::filesystem::remove_all(directory);
}
BENCHMARK(BM_Checkpoint)->Arg(100)->Arg(400)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gw::backend

BENCHMARK_MAIN();
