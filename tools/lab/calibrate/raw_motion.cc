#include "tools/lab/calibrate/raw_motion.h"

#include "common/process/event_log.h"
#include "common/wire/channels.h"
#include "common/wire/wire.h"

namespace gw::calibrate {

Result<RawMotion> ReadMotion(const std::string& log) {
  auto reader = process::EventLogReader::Open(log);
  if (!reader) return reader.error();
  RawMotion motion;
  while (const auto event = reader->Next()) {
    if (event->channel == wire::kWheel) {
      if (auto sample = wire::Decode<WheelSample>(event->data)) motion.wheels.push_back(*sample);
    } else if (event->channel == wire::kImu) {
      if (auto sample = wire::Decode<ImuSample>(event->data)) motion.imu.push_back(*sample);
    } else if (event->channel == wire::kCamera) {
      ++motion.images;
    }
  }
  if (reader->error()) return *reader->error();
  return motion;
}

}  // namespace gw::calibrate
