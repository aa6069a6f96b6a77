#include "common/wire/frame_detail.h"

#include <gw_lcm/frame_detail_t.hpp>

#include "common/wire/archive.h"

namespace gw::wire {
namespace {

using DetailType = gw_lcm::frame_detail_t;
constexpr double kMaxReal = std::numeric_limits<double>::max();
constexpr auto kLastBound = static_cast<int32_t>(AlphaBound::kDistrusted);
constexpr size_t kFeatureBytes = 9;
static_assert(DetailType::BOUND_COVARIANCE == static_cast<int>(AlphaBound::kCovariance));
static_assert(DetailType::BOUND_DISTRUSTED == kLastBound);

void Fate(Writer& a, FeatureFate fate) {
  a.Byte("features.fate", static_cast<uint8_t>(fate), 0);
}
void Fate(Reader& a, FeatureFate& fate) {
  uint8_t number = 0;
  a.Byte("features.fate", number, static_cast<int>(FeatureFate::kNew));
  fate = static_cast<FeatureFate>(number);
}

}  // namespace

template <typename A>
static void Fields(A& a, typename A::template Of<FrameDetail>& m) {
  a.Time("utime", m.utime);
  Seq(a, "seq", m.seq);
  a.Real("quality", m.q, 0, 1);
  a.Real("quality_close", m.q_close, 0, 1);
  a.Real("alpha_translation", m.alpha_translation, 0, kMaxReal);
  a.Real("alpha_rotation", m.alpha_rotation, 0, kMaxReal);
  a.Real("bounded_translation", m.bounded_translation, 0, kMaxReal);
  a.Real("bounded_rotation", m.bounded_rotation, 0, kMaxReal);
  Enum(a, "alpha_bound", m.bound, kLastBound);
  for (int i = 0; i < 6; ++i) a.Real("dr_share_B", m.dr_share[i], 0, 1);
  a.List("features", m.features, LandmarkId::kMaxFeatures, kFeatureBytes,
         [](A& each, auto& feature) {
           each.Real32("features.u_px", feature.u);
           each.Real32("features.v_px", feature.v);
           Fate(each, feature.fate);
         });
}

Bytes Encode(const FrameDetail& detail) {
  return EncodeFields(DetailType::getHash(), detail);
}
template <>
Result<FrameDetail> Decode(ByteSpan message) {
  return DecodeFields<FrameDetail>("frame_detail_t", DetailType::getHash(), message);
}

}  // namespace gw::wire
