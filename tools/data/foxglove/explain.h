// One sentence about an image: what vision saw, and how much dead reckoning carries. For people.
#pragma once

#include <optional>
#include <string>

#include "common/contract/frame_detail.h"
#include "common/contract/tracking.h"
#include "common/contract/tracking_names.h"
#include "tools/data/foxglove/json_parts.h"

namespace gw::foxglove {

// "none", "alpha_min", ...
std::string BoundName(AlphaBound bound);

// "3 of 120 landmarks; turn from dead reckoning 94 %, way 99 %: too few matches". detail: of the
// same image, where the front-end sends it. in_piece: the pose is in a piece of the map whose place
// is not known (docs/adr/0047-pieces-of-a-map.md).
std::string Explain(const FramePose& pose, const std::optional<FrameDetail>& detail,
                    bool in_piece = false);

// gw.Weights.
Json WeightsMessage(const FramePose& pose, const std::optional<FrameDetail>& detail,
                    bool in_piece = false);

}  // namespace gw::foxglove
