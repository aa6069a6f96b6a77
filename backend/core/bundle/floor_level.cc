#include "backend/core/bundle/floor_level.h"

#include <cmath>
#include <vector>

#include "common/core/median.h"

namespace gw::backend {
namespace {

constexpr size_t kBegin = 5;  // keyframes at which a run begins

bool GoesOn(const Keyframe& before, const Keyframe& after) {
  return before.piece == after.piece && before.height->reset_counter == after.height->reset_counter;
}

}  // namespace

FloorLevels::FloorLevels(const Map& map, const SE3& T_BC) : map_(map) {
  const SE3 T_CB = T_BC.inverse();
  std::map<KeyframeId, std::vector<double>> offsets;
  for (const auto& [id, keyframe] : map.keyframes()) {
    const Keyframe& frame = keyframe.frame;
    if (!frame.height) continue;
    const auto before = run_of_.find(frame.previous);
    const bool goes_on =
        before != run_of_.end() && GoesOn(map.keyframes().at(frame.previous).frame, frame);
    const KeyframeId run = goes_on ? before->second : id;
    run_of_[id] = run;
    if (offsets[run].size() == kBegin) continue;
    offsets[run].push_back((frame.T_WC * T_CB).translation().z() - frame.height->z);
  }
  for (auto& [run, values] : offsets) level_[run] = MedianOf(&values);
}

std::optional<FloorLevels::Height> FloorLevels::Of(KeyframeId id) const {
  const auto run = run_of_.find(id);
  if (run == run_of_.end()) return std::nullopt;
  const DrHeight& height = *map_.FindKeyframe(id)->frame.height;
  return Height{level_.at(run->second) + height.z, std::sqrt(height.variance)};
}

}  // namespace gw::backend
