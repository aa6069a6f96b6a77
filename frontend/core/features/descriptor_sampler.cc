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
  offsets_.reserve(static_cast<size_t>(kNumAngles) * pattern.size());
  for (int k = 0; k < kNumAngles; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / kNumAngles;
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    const auto offset = [&](int px, int py) {
      const int dx = static_cast<int>(std::lround(c * px - s * py));
      const int dy = static_cast<int>(std::lround(s * px + c * py));
      GW_CHECK(std::abs(dx) <= kRadius && std::abs(dy) <= kRadius);
      const int from_corner = (dy + kRadius) * stride + dx + kRadius;
      return static_cast<uint64_t>(from_corner);
    };
    // Words of 64 tests, the last test of each first: then a bit is added by doubling the word.
    for (size_t word = 0; word < pattern.size(); word += 64) {
      for (size_t i = 64; i-- > 0;) {
        const OrbTest& test = pattern[word + i];
        offsets_.push_back(offset(test.bx, test.by) << 32 | offset(test.ax, test.ay));
      }
    }
  }
}

Descriptor DescriptorSampler::Sample(const ImageBuffer& smooth, int x, int y, float angle) const {
  GW_CHECK(smooth.stride == stride_);
  constexpr float kAnglesPerRad = kNumAngles / (2.0f * std::numbers::pi_v<float>);
  const int k = static_cast<int>(std::lround(angle * kAnglesPerRad)) & (kNumAngles - 1);
  const uint8_t* first = smooth.row(y - kRadius) + x - kRadius;
  const uint64_t* offset = offsets_.data() + static_cast<ptrdiff_t>(k) * 256;
  Descriptor out;
  for (uint64_t& word : out) {
    uint64_t bits = 0;
#pragma GCC unroll 8
    for (int i = 0; i < 64; ++i, ++offset) {
      const uint8_t a = first[static_cast<uint32_t>(*offset)];
      const uint8_t b = first[*offset >> 32];
      bits = 2 * bits + static_cast<uint64_t>(a < b);
    }
    word = bits;
  }
  return out;
}

}  // namespace gw::frontend
