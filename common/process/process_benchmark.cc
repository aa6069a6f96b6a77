// What messages and logs cost: encoding, decoding, reading and writing at the sizes of a robot.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <filesystem>

#include "common/process/event_log.h"
#include "common/wire/channels.h"
#include "common/wire/testing.h"

namespace gw::process {
namespace {

using wire::Bytes;

// 640x480 grey and depth: 921 kB.
Bytes CameraMessage(Bytes& pixels) {
  pixels.assign(640 * 480 * 2, 100);
  CameraFrame frame;
  frame.left = {pixels.data(), 640, 480, 640, PixelFormat::kGray8};
  frame.depth = {pixels.data(), 640, 480, 1280, PixelFormat::kDepth16};
  return wire::Encode(frame);
}

void EncodeCamera(benchmark::State& state) {
  Bytes pixels;
  (void)CameraMessage(pixels);
  CameraFrame frame;
  frame.left = {pixels.data(), 640, 480, 640, PixelFormat::kGray8};
  frame.depth = {pixels.data(), 640, 480, 1280, PixelFormat::kDepth16};
  for (auto _ : state) benchmark::DoNotOptimize(wire::Encode(frame));
}
BENCHMARK(EncodeCamera);

void DecodeCameraWithCopy(benchmark::State& state) {
  Bytes pixels;
  const Bytes message = CameraMessage(pixels);
  for (auto _ : state) benchmark::DoNotOptimize(wire::Decode<wire::DecodedCamera>(message));
}
BENCHMARK(DecodeCameraWithCopy);

template <typename T>
void RoundTrip(benchmark::State& state) {
  const T message = wire::testing::RandomMessages(1).Make<T>();
  for (auto _ : state) benchmark::DoNotOptimize(wire::Decode<T>(wire::Encode(message)));
}
BENCHMARK(RoundTrip<ImuSample>);
BENCHMARK(RoundTrip<DrState>);
BENCHMARK(RoundTrip<Pose>);

void RoundTripKeyframe(benchmark::State& state) {
  Keyframe keyframe = wire::testing::RandomMessages(1).Make<Keyframe>();
  keyframe.features.resize(800);
  keyframe.descriptors.resize(800);
  keyframe.landmarks.resize(800);
  for (auto _ : state) benchmark::DoNotOptimize(wire::Decode<Keyframe>(wire::Encode(keyframe)));
}
BENCHMARK(RoundTripKeyframe);

// 400 images and 20 IMU samples for each: 370 MB.
constexpr int kImages = 400;
std::string WriteLog() {
  const std::string path = std::filesystem::temp_directory_path() / "gw_process_benchmark.lcm";
  Bytes pixels;
  const Bytes camera = CameraMessage(pixels);
  const Bytes imu = wire::Encode(ImuSample{});
  auto writer = EventLogWriter::Create(path);
  for (int i = 0; writer.ok() && i < kImages; ++i) {
    if (!writer->Append(Utime{i}, wire::kCamera, camera)) break;
    for (int k = 0; k < 20; ++k) {
      if (!writer->Append(Utime{i}, wire::kImu, imu)) break;
    }
  }
  if (!writer.ok() || !writer->Close()) std::abort();
  return path;
}

void WriteEventLog(benchmark::State& state) {
  std::string path;
  for (auto _ : state) path = WriteLog();
  state.SetBytesProcessed(static_cast<int64_t>(std::filesystem::file_size(path)) *
                          static_cast<int64_t>(state.iterations()));
  std::filesystem::remove(path);
}
BENCHMARK(WriteEventLog)->Unit(benchmark::kMillisecond)->Iterations(3)->UseRealTime();

void ReadEventLog(benchmark::State& state) {
  const std::string path = WriteLog();
  for (auto _ : state) {
    auto reader = EventLogReader::Open(path);
    int events = 0;
    while (reader.ok() && reader->Next()) ++events;
    if (events != kImages * 21) state.SkipWithError("events are missing");
  }
  state.SetBytesProcessed(static_cast<int64_t>(std::filesystem::file_size(path)) *
                          static_cast<int64_t>(state.iterations()));
  std::filesystem::remove(path);
}
BENCHMARK(ReadEventLog)->Unit(benchmark::kMillisecond)->Iterations(3)->UseRealTime();

}  // namespace
}  // namespace gw::process

BENCHMARK_MAIN();
