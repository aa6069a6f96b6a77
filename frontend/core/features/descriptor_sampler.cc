#include "frontend/core/features/descriptor_sampler.h"

#include <cmath>
#include <cstdlib>
#include <numbers>

#include "common/core/check.h"
#include "frontend/core/features/pixel_kernels.h"

namespace gw::frontend {
namespace {

constexpr int kRadius = kOrbPatchRadius;
static_assert(PixelKernels::kDiscRadius == kOrbPatchRadius);

}  // namespace

float IntensityCentroidAngle(const ImageBuffer& image, int x, int y) {
  const Moments m = BestPixelKernels().disc_moments(image.row(y) + x, image.stride);
  return std::atan2(static_cast<float>(m.m01), static_cast<float>(m.m10));
}

DescriptorSampler::DescriptorSampler(const OrbPattern& pattern, int stride) : stride_(stride) {
  offsets_.reserve(static_cast<size_t>(kNumAngles) * pattern.size() * 2);
  for (int k = 0; k < kNumAngles; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / kNumAngles;
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    const auto offset = [&](int px, int py) {
      const int dx = static_cast<int>(std::lround(c * px - s * py));
      const int dy = static_cast<int>(std::lround(s * px + c * py));
      GW_CHECK(std::abs(dx) <= kRadius && std::abs(dy) <= kRadius);
      return dy * stride + dx;
    };
    for (const OrbTest& test : pattern) {
      offsets_.push_back(offset(test.ax, test.ay));
      offsets_.push_back(offset(test.bx, test.by));
    }
  }
}

Descriptor DescriptorSampler::Sample(const ImageBuffer& smooth, int x, int y, float angle) const {
  GW_CHECK(smooth.stride == stride_);
  constexpr float kAnglesPerRad = kNumAngles / (2.0f * std::numbers::pi_v<float>);
  const int k = static_cast<int>(std::lround(angle * kAnglesPerRad)) & (kNumAngles - 1);
  const uint8_t* center = smooth.row(y) + x;
  const int32_t* offset = offsets_.data() + static_cast<ptrdiff_t>(k) * 512;
  Descriptor out;
  for (uint64_t& word : out) {
    uint64_t bits = 0;
    for (int i = 0; i < 64; ++i, offset += 2) {
      bits |= static_cast<uint64_t>(center[offset[0]] < center[offset[1]]) << i;
    }
    word = bits;
  }
  return out;
}

}  // namespace gw::frontend
