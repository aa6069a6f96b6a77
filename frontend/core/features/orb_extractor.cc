#include "frontend/core/features/orb_extractor.h"

#include <algorithm>
#include <cmath>

namespace gw::frontend {
namespace {

// Corners below this ratio are edges. In a bare corridor the seams of wall and floor give two
// hundred of them per image, which slide along (docs/adr/0007-what-counts-as-tracked.md). They are
// not replaced by weaker corners: measured on four scenarios, that costs 10 % of accuracy.
constexpr double kMinCornerRatio = 0.1;

// Splits `total` over levels in proportion to `weights`; what a level cannot fill goes to the
// others. `available`: corners per level.
std::vector<int> ShareOut(int total, const std::vector<double>& weights,
                          const std::vector<int>& available) {
  const size_t n = weights.size();
  std::vector<int> share(n, 0);
  int left = total;
  while (left > 0) {
    double open_weight = 0;
    for (size_t l = 0; l < n; ++l) {
      if (share[l] < available[l]) open_weight += weights[l];
    }
    if (open_weight <= 0) break;
    const int to_give = left;
    for (size_t l = 0; l < n && left > 0; ++l) {
      if (share[l] >= available[l]) continue;
      // At least one, so that the loop ends.
      const int fair = std::max(1, static_cast<int>(to_give * weights[l] / open_weight));
      const int given = std::min({fair, available[l] - share[l], left});
      share[l] += given;
      left -= given;
    }
  }
  return share;
}

}  // namespace

Result<OrbExtractor> OrbExtractor::Create(const OrbConfig& config, int width, int height) {
  if (config.fast_threshold_low < 1 || config.fast_threshold_low > config.fast_threshold ||
      config.fast_threshold > 254) {
    return Error{ErrorCode::kBadConfig,
                 "frontend.orb: 1 <= fast_threshold_low <= fast_threshold <= 254 does not hold"};
  }
  if (config.num_features < 1 || config.num_features >= LandmarkId::kMaxFeatures ||
      config.num_levels < 1 || config.num_levels > 32 || !(config.scale_factor > 1.0) ||
      config.scale_factor > 2.0) {
    return Error{ErrorCode::kBadConfig,
                 "frontend.orb: num_features, num_levels or scale_factor is out of range"};
  }
  if (std::min(width, height) < 2 * kBorder + 1 || std::max(width, height) > 16384) {
    return Error{ErrorCode::kBadConfig, "calibration.camera: width or height is out of range"};
  }
  return OrbExtractor(config, width, height);
}

OrbExtractor::OrbExtractor(const OrbConfig& config, int width, int height)
    : config_(config),
      pyramid_(width, height, config.num_levels, config.scale_factor, 2 * kBorder + 1),
      detector_(config.fast_threshold, config.fast_threshold_low, kBorder),
      sampler_(kOrbPattern, pyramid_.stride()),
      corners_(static_cast<size_t>(pyramid_.num_levels())) {}

void OrbExtractor::Extract(const ImageView& image, const ImageBuffer* valid,
                           std::vector<OrbKeypoint>* keypoints,
                           std::vector<Descriptor>* descriptors) {
  keypoints->clear();
  descriptors->clear();
  pyramid_.Build(image);
  const size_t num_levels = corners_.size();
  std::vector<double> weights(num_levels);
  std::vector<int> available(num_levels);
  for (size_t l = 0; l < num_levels; ++l) {
    const int level = static_cast<int>(l);
    const float scale_x = pyramid_.scale_x(level);
    const float scale_y = pyramid_.scale_y(level);
    detector_.Detect(pyramid_.level(level), &corners_[l]);
    if (valid != nullptr) {
      const float reach = kBorder * std::max(scale_x, scale_y);
      std::erase_if(corners_[l], [&](const Corner& c) {
        const int x = static_cast<int>((c.x + 0.5f) * scale_x);
        const int y = static_cast<int>((c.y + 0.5f) * scale_y);
        return valid->row(y)[x] < reach;
      });
    }
    available[l] = static_cast<int>(corners_[l].size());
    // In proportion to the level's width, not its area: finer levels hold more corners, but weaker
    // and more often noise.
    weights[l] = 1.0 / scale_x;
  }
  const std::vector<int> share = ShareOut(config_.num_features, weights, available);
  for (size_t l = 0; l < num_levels; ++l) {
    const int level = static_cast<int>(l);
    const ImageBuffer& pixels = pyramid_.level(level);
    spread_.Select(pixels.width, pixels.height, share[l], &corners_[l], &selected_);
    for (const Corner& c : selected_) {
      if (config_.corners_only && CornerRatio(pixels, c.x, c.y) < kMinCornerRatio) continue;
      OrbKeypoint k;
      k.level = static_cast<uint8_t>(l);
      k.score = c.score;
      const CornerOffset offset = RefineCorner(pixels, c.x, c.y);
      k.x = static_cast<float>(c.x) + offset.dx;
      k.y = static_cast<float>(c.y) + offset.dy;
      k.u = (k.x + 0.5f) * pyramid_.scale_x(level) - 0.5f;
      k.v = (k.y + 0.5f) * pyramid_.scale_y(level) - 0.5f;
      k.angle = IntensityCentroidAngle(pixels, c.x, c.y);
      keypoints->push_back(k);
      descriptors->push_back(sampler_.Sample(pixels, c.x, c.y, k.angle));
    }
  }
}

}  // namespace gw::frontend
