// Named faults in a stream of messages.
#pragma once

#include <string_view>
#include <vector>

#include "tools/data/fault/sample_faults.h"
#include "tools/data/fault/vision_faults.h"

namespace gw::fault {

class NamedFaults {
 public:
  NamedFaults(const std::vector<NamedFault>& faults, const CameraOptics& optics);

  // True when messages of the channel have to go through Apply.
  bool Concerns(std::string_view channel) const;

  struct Message {
    wire::Bytes bytes;
    DurationUs delay;  // received later than the message it was made from
  };
  // What becomes of a message: messages of the same channel, possibly none. Every message of the
  // channels concerned, in the order of the log. Error: as of wire::Decode.
  Result<std::vector<Message>> Apply(std::string_view channel, DurationUs since_begin,
                                     wire::Bytes message);

 private:
  template <typename Sample>
  struct Stage {
    SampleFault<Sample> fault;
    tools::Span span;
  };
  template <typename Sample>
  static Result<std::vector<Message>> Run(std::vector<Stage<Sample>>& stages,
                                          DurationUs since_begin, wire::Bytes message);

  std::vector<Stage<WheelSample>> wheels_;
  std::vector<Stage<ImuSample>> imu_;
  std::vector<Stage<DrState>> dr_;
  VisionFaults vision_;
};

}  // namespace gw::fault
