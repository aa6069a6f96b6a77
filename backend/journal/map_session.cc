#include "backend/journal/map_session.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/core/format.h"
#include "common/core/version.h"
#include "common/wire/archive.h"

namespace gw::wire {

template <typename A>
static void Fields(A& a, typename A::template Of<backend::MapSession>& m) {
  constexpr int32_t kMaxPixels = 1 << 16;
  a.Time("begin", m.begin);
  Id(a, "first_keyframe", m.first_keyframe);
  a.Int32("width", m.source.width, 1, kMaxPixels);
  a.Int32("height", m.source.height, 1, kMaxPixels);
  for (auto* value :
       {&m.source.fx, &m.source.fy, &m.source.cx, &m.source.cy, &m.source.baseline_m}) {
    a.Real("camera", *value);
  }
  a.Int32("num_levels", m.source.num_levels, 1, 32);
  a.Real("scale_factor", m.source.scale_factor);
  Transform(a, "T_BC", m.T_BC);
  a.Text("version", m.version);
}

}  // namespace gw::wire

namespace gw::backend {

std::string Difference(const FeatureSource& map, const FeatureSource& now) {
  constexpr double kTolerance = 1e-6;
  std::string out;
  const auto compare = [&](const char* name, double a, double b) {
    if (std::abs(a - b) <= kTolerance * std::max(std::abs(a), std::abs(b))) return;
    out += (out.empty() ? "" : ", ") + std::string(name) + " " + FormatDouble(a) + " (now " +
           FormatDouble(b) + ")";
  };
  compare("width", map.width, now.width);
  compare("height", map.height, now.height);
  compare("fx", map.fx, now.fx);
  compare("fy", map.fy, now.fy);
  compare("cx", map.cx, now.cx);
  compare("cy", map.cy, now.cy);
  compare("baseline_m", map.baseline_m, now.baseline_m);
  compare("orb.num_levels", map.num_levels, now.num_levels);
  compare("orb.scale_factor", map.scale_factor, now.scale_factor);
  return out;
}

MapSession MakeSession(Utime begin, const RectifiedCamera& camera, const OrbConfig& orb) {
  return {.begin = begin,
          .first_keyframe = {1},
          .source = {.width = camera.width,
                     .height = camera.height,
                     .fx = camera.fx,
                     .fy = camera.fy,
                     .cx = camera.cx,
                     .cy = camera.cy,
                     .baseline_m = camera.baseline_m,
                     .num_levels = orb.num_levels,
                     .scale_factor = orb.scale_factor},
          .T_BC = camera.T_BC,
          .version = Version()};
}

wire::Bytes Encode(const MapSession& session) {
  wire::Writer writer;
  wire::Fields(writer, session);
  return std::move(writer).Take();
}

Result<MapSession> DecodeMapSession(wire::ByteSpan bytes) {
  wire::Reader reader(bytes);
  MapSession session;
  wire::Fields(reader, session);
  reader.End();
  if (!reader.ok()) return Error{ErrorCode::kBadData, "session record:" + reader.error().message};
  return session;
}

}  // namespace gw::backend
