// Which type a message claims to be.
#include <gw_lcm/ack_t.hpp>
#include <gw_lcm/base_command_t.hpp>
#include <gw_lcm/camera_t.hpp>
#include <gw_lcm/dr_t.hpp>
#include <gw_lcm/frame_detail_t.hpp>
#include <gw_lcm/frame_pose_t.hpp>
#include <gw_lcm/grid_t.hpp>
#include <gw_lcm/ground_truth_t.hpp>
#include <gw_lcm/health_t.hpp>
#include <gw_lcm/imu_t.hpp>
#include <gw_lcm/keyframe_t.hpp>
#include <gw_lcm/map_request_t.hpp>
#include <gw_lcm/map_update_t.hpp>
#include <gw_lcm/note_t.hpp>
#include <gw_lcm/obstacles_t.hpp>
#include <gw_lcm/place_match_t.hpp>
#include <gw_lcm/place_query_t.hpp>
#include <gw_lcm/pose_t.hpp>
#include <gw_lcm/wheel_t.hpp>

#include "common/wire/archive.h"

namespace gw::wire {
namespace {

template <typename... Types>
int64_t FindFingerprint(std::string_view type) {
  int64_t fingerprint = 0;
  ((type == Types::getTypeName() ? void(fingerprint = Types::getHash()) : void()), ...);
  return fingerprint;
}

}  // namespace

int64_t FingerprintOf(std::string_view type) {
  const int64_t fingerprint =
      FindFingerprint<gw_lcm::camera_t, gw_lcm::imu_t, gw_lcm::wheel_t, gw_lcm::dr_t,
                      gw_lcm::frame_detail_t, gw_lcm::frame_pose_t, gw_lcm::pose_t,
                      gw_lcm::keyframe_t, gw_lcm::ack_t, gw_lcm::map_update_t,
                      gw_lcm::map_request_t, gw_lcm::grid_t, gw_lcm::obstacles_t,
                      gw_lcm::place_query_t, gw_lcm::place_match_t, gw_lcm::health_t,
                      gw_lcm::base_command_t, gw_lcm::ground_truth_t, gw_lcm::note_t>(type);
  GW_CHECK(fingerprint != 0);
  return fingerprint;
}

std::optional<Header> ReadHeader(ByteSpan message) {
  Reader reader(message);
  Header header;
  reader.Int64("fingerprint", header.fingerprint, std::numeric_limits<int64_t>::min(),
               std::numeric_limits<int64_t>::max());
  reader.Time("utime", header.utime);
  Seq(reader, "seq", header.seq);
  if (!reader.ok()) return std::nullopt;
  return header;
}

}  // namespace gw::wire
