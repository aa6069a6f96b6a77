// One life of a program that wrote to a map: when it began, with which camera and features.
#pragma once

#include <cstdint>
#include <string>

#include "common/camera/camera_model.h"
#include "common/config/frontend_config.h"
#include "common/core/ids.h"
#include "common/core/result.h"
#include "common/wire/wire.h"

namespace gw::backend {

// What the stored features depend on: pixels of this camera, this pyramid.
struct FeatureSource {
  int32_t width = 0, height = 0;          // px, of the rectified image
  double fx = 0, fy = 0, cx = 0, cy = 0;  // px
  double baseline_m = 0;
  int32_t num_levels = 0;
  double scale_factor = 0;
};

// Empty when features of both can live in one map; else what differs, with both values. Intrinsics
// may differ by 1e-6 of their value (a configuration written and read again).
std::string Difference(const FeatureSource& map, const FeatureSource& now);

struct MapSession {
  Utime begin;                // clock of the process; of a log: time of its first event
  KeyframeId first_keyframe;  // ids from here on are this session's (up to the next session's)
  FeatureSource source;
  SE3 T_BC;             // rectified left camera in the body, as calibrated then
  std::string version;  // of the program
};

// A session of this program that begins now; Journal::Open and SaveMap set its first_keyframe.
MapSession MakeSession(Utime begin, const RectifiedCamera& camera, const OrbConfig& orb);

wire::Bytes Encode(const MapSession& session);
// Error kBadData: the field and the rule.
Result<MapSession> DecodeMapSession(wire::ByteSpan bytes);

}  // namespace gw::backend
