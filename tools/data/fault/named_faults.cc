#include "tools/data/fault/named_faults.h"

#include <algorithm>
#include <utility>

#include "common/wire/channels.h"

namespace gw::fault {

NamedFaults::NamedFaults(const std::vector<NamedFault>& faults, const CameraOptics& optics)
    : vision_(faults, optics) {
  for (const NamedFault& fault : faults) {
    if (auto made = MakeWheelFault(fault.id)) wheels_.push_back({std::move(made), fault.span});
    if (auto made = MakeImuFault(fault.id)) imu_.push_back({std::move(made), fault.span});
    if (auto made = MakeDrFault(fault.id)) dr_.push_back({std::move(made), fault.span});
  }
}

bool NamedFaults::Concerns(std::string_view channel) const {
  return (channel == wire::kWheel && !wheels_.empty()) ||
         (channel == wire::kImu && !imu_.empty()) || (channel == wire::kDr && !dr_.empty()) ||
         (channel == wire::kCamera && !vision_.empty());
}

template <typename Sample>
Result<std::vector<NamedFaults::Message>> NamedFaults::Run(std::vector<Stage<Sample>>& stages,
                                                           DurationUs since_begin,
                                                           wire::Bytes message) {
  auto sample = wire::Decode<Sample>(message);
  if (!sample) return sample.error();
  std::vector<Edited<Sample>> samples = {{*std::move(sample), {}}};
  for (Stage<Sample>& stage : stages) stage.fault(stage.span.Contains(since_begin), samples);
  std::vector<Message> out;
  for (const auto& [edited, delay] : samples) out.push_back({wire::Encode(edited), delay});
  return out;
}

Result<std::vector<NamedFaults::Message>> NamedFaults::Apply(std::string_view channel,
                                                             DurationUs since_begin,
                                                             wire::Bytes message) {
  if (channel == wire::kWheel) return Run(wheels_, since_begin, std::move(message));
  if (channel == wire::kImu) return Run(imu_, since_begin, std::move(message));
  if (channel == wire::kDr) return Run(dr_, since_begin, std::move(message));
  auto camera = wire::DecodeCamera(message);
  if (!camera) return camera.error();
  auto edited = vision_.Apply(since_begin, camera->frame);
  std::vector<Message> out;
  out.push_back({edited ? *std::move(edited) : std::move(message), {}});
  return out;
}

}  // namespace gw::fault
