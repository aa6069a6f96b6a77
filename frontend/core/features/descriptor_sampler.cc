#include "frontend/core/features/descriptor_sampler.h"

#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>

#if defined(__SSSE3__)
#include <immintrin.h>
#endif

#include "common/core/check.h"

namespace gw::frontend {
namespace {

constexpr int kRadius = kOrbPatchRadius;

// Half width of row |y| of the disc.
constexpr std::array<int, kRadius + 1> kHalfWidth = [] {
  std::array<int, kRadius + 1> half_width{};
  for (int y = 0; y <= kRadius; ++y) {
    int x = kRadius;
    while (x * x + y * y > kRadius * kRadius + kRadius) --x;  // (r + 1/2)^2: a round disc
    half_width[static_cast<size_t>(y)] = x;
  }
  return half_width;
}();

struct Moments {
  int m10, m01;
};

#if defined(__SSSE3__)

// Weights of the 32 pixels x - 15 .. x + 16 of a row of the disc.
struct RowWeights {
  int8_t dx[32];      // dx inside the disc, 0 outside
  int8_t inside[32];  // 1 inside the disc, 0 outside
};

constexpr std::array<RowWeights, kRadius + 1> kRowWeights = [] {
  std::array<RowWeights, kRadius + 1> weights{};
  for (size_t y = 0; y < weights.size(); ++y) {
    for (int dx = -kHalfWidth[y]; dx <= kHalfWidth[y]; ++dx) {
      weights[y].dx[dx + kRadius] = static_cast<int8_t>(dx);
      weights[y].inside[dx + kRadius] = 1;
    }
  }
  return weights;
}();

__m128i Load(const void* p) {
  return _mm_loadu_si128(static_cast<const __m128i*>(p));
}

int Sum(__m128i v) {
  v = _mm_add_epi32(v, _mm_shuffle_epi32(v, 0x4E));
  return _mm_cvtsi128_si32(_mm_add_epi32(v, _mm_shuffle_epi32(v, 0xB1)));
}

Moments DiscMoments(const ImageBuffer& image, int x, int y) {
  const __m128i one = _mm_set1_epi16(1);
  __m128i m10 = _mm_setzero_si128();
  __m128i m01 = _mm_setzero_si128();
  for (int dy = -kRadius; dy <= kRadius; ++dy) {
    const RowWeights& weights = kRowWeights[static_cast<size_t>(std::abs(dy))];
    const uint8_t* row = image.row(y + dy) + x - kRadius;
    const __m128i left = Load(row);
    const __m128i right = Load(row + 16);
    // No sum of pairs leaves 16 bits: at most 255 * (15 + 14) * 2.
    const __m128i by_dx = _mm_add_epi16(_mm_maddubs_epi16(left, Load(weights.dx)),
                                        _mm_maddubs_epi16(right, Load(weights.dx + 16)));
    const __m128i sums = _mm_add_epi16(_mm_maddubs_epi16(left, Load(weights.inside)),
                                       _mm_maddubs_epi16(right, Load(weights.inside + 16)));
    m10 = _mm_add_epi32(m10, _mm_madd_epi16(by_dx, one));
    m01 = _mm_add_epi32(m01, _mm_madd_epi16(sums, _mm_set1_epi16(static_cast<int16_t>(dy))));
  }
  return {Sum(m10), Sum(m01)};
}

#else

Moments DiscMoments(const ImageBuffer& image, int x, int y) {
  Moments m{0, 0};
  for (int dy = -kRadius; dy <= kRadius; ++dy) {
    const uint8_t* row = image.row(y + dy) + x;
    const int half_width = kHalfWidth[static_cast<size_t>(std::abs(dy))];
    int sum = 0;
    for (int dx = -half_width; dx <= half_width; ++dx) {
      sum += row[dx];
      m.m10 += dx * row[dx];
    }
    m.m01 += dy * sum;
  }
  return m;
}

#endif

}  // namespace

float IntensityCentroidAngle(const ImageBuffer& image, int x, int y) {
  const Moments m = DiscMoments(image, x, y);
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
