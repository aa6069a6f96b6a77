#include "tools/lab/check/log_facts.h"

#include "common/process/event_log.h"
#include "common/wire/channels.h"
#include "common/wire/wire.h"

namespace gw::check {
namespace {

template <typename Sample>
void Take(const process::LogEvent& event, Stream& stream, std::vector<Sample>& samples) {
  const auto sample = wire::Decode<Sample>(event.data);
  if (!sample) {
    if (++stream.undecodable == 1) stream.why_undecodable = sample.error().message;
    return;
  }
  stream.times.push_back(sample->utime);
  samples.push_back(*sample);
}

}  // namespace

Result<LogFacts> ReadLogFacts(const std::string& log, const CameraGeometry& geometry) {
  auto reader = process::EventLogReader::Open(log);
  if (!reader) return reader.error();
  LogFacts facts;
  ImageScanner scanner(geometry);
  tools::LogClock clock;
  while (const auto event = reader->Next()) {
    clock.Add(event->received);
    if (event->channel == wire::kImu) {
      Take(*event, facts.streams[wire::kImu], facts.imu);
    } else if (event->channel == wire::kWheel) {
      Take(*event, facts.streams[wire::kWheel], facts.wheels);
    } else if (event->channel == wire::kCamera) {
      Stream& stream = facts.streams[wire::kCamera];
      const auto camera = wire::Decode<wire::DecodedCamera>(event->data);
      if (!camera) {
        if (++stream.undecodable == 1) stream.why_undecodable = camera.error().message;
        continue;
      }
      stream.times.push_back(camera->frame.utime);
      scanner.Push(camera->frame);
    }
  }
  if (reader->error()) return *reader->error();
  facts.images = scanner.Finish();
  facts.time_steps = clock.steps();
  facts.truncated = reader->truncated();
  facts.skipped_bytes = reader->skipped_bytes();
  return facts;
}

}  // namespace gw::check
