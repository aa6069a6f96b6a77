// Time of local bundle adjustment and of keyframe insertion at the size they have on a robot:
// 20 free keyframes, up to 800 features each, some 2000 landmarks, tracked poses off by 1 cm.
#include <benchmark/benchmark.h>

#include "backend/core/mapper.h"
#include "backend/test/world.h"

namespace gw::backend {
namespace {

// A mapper that has taken in 45 keyframes; local BA ran after each but the last.
struct Scene {
  Scene()
      : world({.num_points = 9000, .keyframes_per_lap = 90}),
        mapper(Mapper::Create({.redundant_share = 1.0}, {}, TestCamera()).value()) {
    for (int k = 0; k < 45; ++k) {
      if (k > 1) mapper.Apply(SolveLocalBa(*mapper.BuildJob()));
      mapper.Insert(world.Make(k, mapper.map()));
    }
  }
  World world;
  Mapper mapper;
};

void BM_SolveLocalBa(benchmark::State& state) {
  Scene scene;
  const LocalBaJob job = *scene.mapper.BuildJob();
  LocalBaResult result;
  for (auto _ : state) result = SolveLocalBa(job);
  state.counters["keyframes"] = static_cast<double>(job.keyframes.size());
  state.counters["free"] = static_cast<double>(result.keyframes.size());
  state.counters["landmarks"] = static_cast<double>(job.landmarks.size());
  state.counters["observations"] = static_cast<double>(job.observations.size());
  state.counters["iterations"] = result.iterations;
}
BENCHMARK(BM_SolveLocalBa)->Unit(benchmark::kMillisecond);

void BM_BuildJob(benchmark::State& state) {
  Scene scene;
  for (auto _ : state) benchmark::DoNotOptimize(scene.mapper.BuildJob());
}
BENCHMARK(BM_BuildJob)->Unit(benchmark::kMillisecond);

void BM_ApplyLocalBa(benchmark::State& state) {
  Scene scene;
  const LocalBaResult result = SolveLocalBa(*scene.mapper.BuildJob());
  for (auto _ : state) {
    state.PauseTiming();
    Mapper copy = scene.mapper;
    state.ResumeTiming();
    benchmark::DoNotOptimize(copy.Apply(result));
  }
}
BENCHMARK(BM_ApplyLocalBa)->Unit(benchmark::kMillisecond);

void BM_Insert(benchmark::State& state) {
  Scene scene;
  const Keyframe keyframe = scene.world.Make(45, scene.mapper.map());
  for (auto _ : state) {
    state.PauseTiming();
    Mapper copy = scene.mapper;
    state.ResumeTiming();
    benchmark::DoNotOptimize(copy.Insert(keyframe));
  }
}
BENCHMARK(BM_Insert)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gw::backend

BENCHMARK_MAIN();
