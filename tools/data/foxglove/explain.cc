#include "tools/data/foxglove/explain.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/data/files/format.h"
#include "tools/data/files/json.h"

namespace gw::foxglove {
namespace {

using tools::Format;

constexpr double kDegrees = 180 / std::numbers::pi;

std::string ReasonText(TrackingReason reason, bool in_piece) {
  switch (reason) {
    case TrackingReason::kNone:
      return "";
    case TrackingReason::kTooFewFeatures:
      return "the image shows too little: dark, blank or covered";
    case TrackingReason::kTooFewMatches:
      return "the image does not show what the map holds here";
    case TrackingReason::kTooFewInliers:
      return "no pose explains what was matched";
    case TrackingReason::kPoseJump:
      return "vision contradicts dead reckoning and the map, and is not believed yet";
    case TrackingReason::kBadImage:
      return "the image has a wrong size or format";
    case TrackingReason::kNoMap:
      return "there is no map yet";
    case TrackingReason::kTimeReversed:
      return "the image is older than the one before";
    case TrackingReason::kPlaceUnknown:
      return in_piece ? "the place in the map is not known; the robot maps on in a piece of its own"
                      : "the place is not found in the map yet";
    case TrackingReason::kDrContradictsVision:
      return "dead reckoning contradicts healthy vision and is not used";
    case TrackingReason::kFixedInImage:
      return "most of what is seen is fixed to the camera, and left out";
    case TrackingReason::kEyesApart:
      return "the two images of the pair are not of one instant: no depth";
    case TrackingReason::kOneEyeTwice:
      return "left and right image are the same";
    case TrackingReason::kEyesExchanged:
      return "left and right image are exchanged";
  }
  return "";
}

std::string BoundText(AlphaBound bound) {
  switch (bound) {
    case AlphaBound::kUnused:
    case AlphaBound::kNone:
    case AlphaBound::kDistrusted:
      return "";
    case AlphaBound::kAlphaMin:
      return "alpha at its minimum, vision is healthy";
    case AlphaBound::kAlphaMax:
      return "alpha at its maximum, vision is blind";
    case AlphaBound::kCovariance:
      return "weight bounded by the covariance that dead reckoning states";
  }
  return "";
}

int Percent(double share) {
  return static_cast<int>(std::lround(100 * share));
}

std::string ShareText(const FramePose& pose, const std::optional<FrameDetail>& detail) {
  if (!detail || detail->bound == AlphaBound::kUnused) {
    return pose.dr_share > 0 ? Format("dead reckoning %d %%", Percent(pose.dr_share))
                             : "vision alone";
  }
  // A robot on wheels goes forward and turns about the vertical; the other axes move little.
  return Format("turn from dead reckoning %d %%, way %d %%", Percent(detail->dr_share[5]),
                Percent(detail->dr_share[0]));
}

}  // namespace

std::string BoundName(AlphaBound bound) {
  static constexpr const char* kNames[] = {"unused",    "none",       "alpha_min",
                                           "alpha_max", "covariance", "distrusted"};
  return kNames[std::clamp(static_cast<int>(bound), 0, 5)];
}

std::string Explain(const FramePose& pose, const std::optional<FrameDetail>& detail,
                    bool in_piece) {
  std::string text =
      Format("%d of %d features show landmarks; ", pose.num_inliers, pose.num_detected);
  text += ShareText(pose, detail);
  const std::string reason = ReasonText(pose.reason, in_piece);
  const std::string bound = detail ? BoundText(detail->bound) : "";
  if (!bound.empty()) text += " (" + bound + ")";
  if (!reason.empty()) text += ": " + reason;
  return text;
}

Json WeightsMessage(const FramePose& pose, const std::optional<FrameDetail>& detail,
                    bool in_piece) {
  const auto variance = pose.cov_T_WB.diagonal();
  Json json = {{"timestamp", JsonTime(pose.utime)},
               {"utime", pose.utime.us},
               {"status", StatusName(pose.status)},
               {"status_code", static_cast<int>(pose.status)},
               {"reason", ReasonName(pose.reason)},
               {"reason_text", ReasonText(pose.reason, in_piece)},
               {"explanation", Explain(pose, detail, in_piece)},
               {"q", pose.q},
               {"alpha", pose.alpha},
               {"dr_share", pose.dr_share},
               {"num_detected", pose.num_detected},
               {"num_tracked", pose.num_tracked},
               {"num_inliers", pose.num_inliers},
               {"latency_ms", static_cast<double>(pose.latency_us) * 1e-3},
               {"sigma_position_m", std::sqrt(std::max(variance.head<3>().maxCoeff(), 0.0))},
               {"sigma_heading_deg", std::sqrt(std::max(variance[5], 0.0)) * kDegrees},
               {"map_revision", pose.map_revision}};
  if (!detail) return json;
  json["alpha_translation"] = detail->alpha_translation;
  json["alpha_bound"] = BoundName(detail->bound);
  const auto& share = detail->dr_share;
  json["dr_share_axes"] = {{"forward", share[0]}, {"left", share[1]},  {"up", share[2]},
                           {"roll", share[3]},    {"pitch", share[4]}, {"yaw", share[5]}};
  return json;
}

}  // namespace gw::foxglove
