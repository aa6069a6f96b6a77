#include "backend/core/bundle/floor_level.h"

#include <cmath>

#include "common/core/chi_square.h"
#include "common/core/median.h"

namespace gw::backend {
namespace {

constexpr size_t kBegin = 5;  // keyframes at which a run begins

bool SameFloor(const Keyframe& before, const Keyframe& after) {
  return before.piece == after.piece && before.height->reset_counter == after.height->reset_counter;
}

}  // namespace

FloorLevels::FloorLevels(const Map& map, const SE3& T_BC) : map_(map) {
  const Eigen::Vector3d p_CB = T_BC.inverse().translation();
  for (const auto& [id, keyframe] : map.keyframes()) {
    const Keyframe& frame = keyframe.frame;
    if (!frame.height) continue;
    const double level = (frame.T_WC * p_CB).z() - frame.height->z;
    const auto before = run_of_.find(frame.previous);
    KeyframeId run = id;
    if (before != run_of_.end() && SameFloor(map.keyframes().at(frame.previous).frame, frame)) {
      const Run& so_far = runs_.at(before->second);
      const double apart = level - so_far.level;
      const bool contradicts = apart * apart > kChi2One999 * frame.height->variance;
      if (so_far.begin.size() < kBegin || !contradicts) run = before->second;
    }
    run_of_[id] = run;
    Run& grows = runs_[run];
    if (grows.begin.size() == kBegin) continue;
    grows.begin.push_back(level);
    grows.level = MedianOf(&grows.begin);
  }
}

std::optional<FloorLevels::Height> FloorLevels::Of(KeyframeId id) const {
  const auto run = run_of_.find(id);
  if (run == run_of_.end()) return std::nullopt;
  const DrHeight& height = *map_.FindKeyframe(id)->frame.height;
  return Height{runs_.at(run->second).level + height.z, std::sqrt(height.variance)};
}

}  // namespace gw::backend
