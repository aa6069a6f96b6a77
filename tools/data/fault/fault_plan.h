// What gw-fault does to a log.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tools/data/fault/camera_optics.h"
#include "tools/data/fault/named_fault.h"
#include "tools/data/log/span.h"

namespace gw::fault {

struct Blur {
  tools::Span span;
  double sigma_px = 0;
};
struct Drop {
  tools::Span span;
  double probability = 1;  // of each frame, independently
};
struct Slip {
  tools::Span span;
  double factor = 1;  // measured way / true way
};

// All spans are times of the input log, also behind a teleport.
struct FaultPlan {
  std::vector<tools::Span> black;   // grey 0, no depth: the lens is covered
  std::vector<tools::Span> freeze;  // the last image before the span, with new times
  std::vector<Blur> blur;           // Gaussian, on the grey images; depth stays
  std::vector<Drop> drop;           // camera messages are lost: their sequence numbers are missing
  std::map<std::string, DurationUs> delay;  // per channel: received later, measured when it was
  // WHEEL: increments and ticks (not the gyro heading) times factor. DR: translation times factor,
  // as a filter would that trusts the wheels for the way and the gyro for the heading.
  std::vector<Slip> slip;
  double gyro_bias_rad_s = 0;  // IMU: added on each axis, over the whole log
  // The robot is carried from where it was at the begin of the span to where it was at the end, in
  // no time and without a sensor that feels it: all messages of the span are left out, the rest of
  // the log moves up in time, DR and wheel counters continue as if nothing had happened.
  std::vector<tools::Span> teleport;
  std::vector<NamedFault> named;  // one after the other, behind the edits above
  CameraOptics optics;            // of named faults of the camera
  uint64_t seed = 1;              // of drop

  // One line for each edit: (key, text) for the notes.
  std::vector<std::pair<std::string, std::string>> Describe() const;
};

// Texts as on the command line.
struct FaultArguments {
  std::vector<std::string> black, freeze, blur, drop, delay, slip, teleport, fault;
  double gyro_bias_rad_s = 0;
  uint64_t seed = 1;
};

// Error kInvalidArgument: names the option; also when no edit is asked for.
Result<FaultPlan> ParseFaultPlan(const FaultArguments& arguments);

}  // namespace gw::fault
