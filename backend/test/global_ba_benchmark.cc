// Time and memory of global bundle adjustment against the number of keyframes: one lap on a circle
// that grows with it, through rooms as full as an office; tracked poses off by 1 cm.
#include <benchmark/benchmark.h>

#include <fstream>
#include <numbers>
#include <string>

#include "backend/core/mapper.h"
#include "backend/test/world.h"

namespace gw::backend {
namespace {

constexpr double kStep = 0.3;  // m between keyframes

// A line of /proc/self/status, in MB.
double StatusMb(const std::string& name) {
  std::ifstream file("/proc/self/status");
  std::string word;
  while (file >> word && word != name + ":") {
  }
  double kb = 0;
  file >> kb;
  return kb / 1024;
}

WorldOptions Building(int keyframes) {
  WorldOptions options;
  options.num_points = 70 * keyframes;
  options.keyframes_per_lap = keyframes;
  options.radius = kStep * keyframes / (2 * std::numbers::pi);
  options.half_x = options.half_y = options.radius + 2;
  options.memory_keyframes = 10;
  return options;
}

void BM_SolveGlobalBa(benchmark::State& state) {
  const int keyframes = static_cast<int>(state.range(0));
  World world(Building(keyframes));
  Mapper mapper = Mapper::Create({.redundant_share = 1.0}, {}, TestCamera()).value();
  for (int k = 0; k < keyframes; ++k) {
    if (k > 1) mapper.Apply(SolveLocalBa(*mapper.BuildJob()));
    mapper.Insert(world.Make(k, mapper.map()));
  }
  LocalBaJob job = *mapper.BuildGlobalJob();
  job.iterations = 50;  // until it converges
  LocalBaResult result;
  const double before_mb = StatusMb("VmRSS");
  std::ofstream("/proc/self/clear_refs") << 5;  // the peak counts from here
  for (auto _ : state) result = SolveLocalBa(job);
  state.counters["peak_MB"] = StatusMb("VmHWM") - before_mb;
  state.counters["landmarks"] = static_cast<double>(job.landmarks.size());
  state.counters["observations"] = static_cast<double>(job.observations.size());
  state.counters["iterations"] = result.iterations;
}
BENCHMARK(BM_SolveGlobalBa)
    ->Arg(50)
    ->Arg(100)
    ->Arg(200)
    ->Arg(400)
    ->Arg(800)
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gw::backend

BENCHMARK_MAIN();
