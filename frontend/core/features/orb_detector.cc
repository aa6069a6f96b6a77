#include "frontend/core/features/orb_detector.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>

#if defined(__SSE4_1__)
#include <immintrin.h>
#endif

#include "common/core/check.h"

namespace gw::frontend {
namespace {

constexpr int kCell = 32;      // px of the level; a cell should be able to hold several patches
constexpr int kMinInCell = 3;  // fewer strong corners than this: weak ones count too
constexpr int kBlock = 16;     // pixels scored at once

struct Point {
  int x, y;
};
// The circle of radius 3, in order.
constexpr std::array<Point, 16> kCircle = {{{0, -3},
                                            {1, -3},
                                            {2, -2},
                                            {3, -1},
                                            {3, 0},
                                            {3, 1},
                                            {2, 2},
                                            {1, 3},
                                            {0, 3},
                                            {-1, 3},
                                            {-2, 2},
                                            {-3, 1},
                                            {-3, 0},
                                            {-3, -1},
                                            {-2, -2},
                                            {-1, -3}}};

using Offsets = std::array<ptrdiff_t, 16>;

Offsets CircleOffsets(int stride) {
  Offsets offsets;
  for (size_t i = 0; i < offsets.size(); ++i) {
    offsets[i] = static_cast<ptrdiff_t>(kCircle[i].y) * stride + kCircle[i].x;
  }
  return offsets;
}

int ScoreOf(const uint8_t* center, const Offsets& offsets) {
  int best = 0;
  for (size_t start = 0; start < 16; ++start) {
    int lowest = 255;
    int highest = 0;
    for (size_t i = start; i < start + 9; ++i) {
      const int p = center[offsets[i % 16]];
      lowest = std::min(lowest, p);
      highest = std::max(highest, p);
    }
    best = std::max({best, lowest - *center, *center - highest});
  }
  return best;
}

#if defined(__SSE4_1__)

__m128i Load(const uint8_t* p) {
  return _mm_loadu_si128(reinterpret_cast<const __m128i*>(p));
}

// In the following, with the arguments min and max swapped, "smallest" reads "largest" and so on.

// quads[i]: the smallest of the pixels i, i + 2, i + 4, i + 6, for all i of one parity.
template <size_t parity, typename MinOp>
void MakeQuads(const __m128i (&p)[16], MinOp min, __m128i (&quads)[16]) {
  __m128i pairs[16];
#pragma GCC unroll 8
  for (size_t i = parity; i < 16; i += 2) pairs[i] = min(p[i], p[(i + 2) % 16]);
#pragma GCC unroll 8
  for (size_t i = parity; i < 16; i += 2) quads[i] = min(pairs[i], pairs[(i + 4) % 16]);
}

// The largest of the quads of even pixels. Every arc of nine contains one of these quads.
template <typename MaxOp>
__m128i BestQuad(const __m128i (&quads)[16], MaxOp max) {
  return max(max(max(quads[0], quads[2]), max(quads[4], quads[6])),
             max(max(quads[8], quads[10]), max(quads[12], quads[14])));
}

// Largest over the 16 arcs of nine of their smallest pixel. Two arcs share their middle eight
// pixels, and max(min(m, a), min(m, b)) = min(m, max(a, b)); so eight such middles cover all arcs.
template <typename MinOp, typename MaxOp>
__m128i BestArc(const __m128i (&p)[16], const __m128i (&quads)[16], MinOp min, MaxOp max) {
  __m128i arcs[16];
#pragma GCC unroll 8
  for (size_t i = 0; i < 16; i += 2) {
    arcs[i] = min(min(quads[i], quads[i + 1]), max(p[(i + 8) % 16], p[(i + 15) % 16]));
  }
  return BestQuad(arcs, max);
}

// Scores of 16 pixels, zero where not above the threshold.
__m128i ScoreBlock(const uint8_t* center, const Offsets& offsets, __m128i threshold) {
  const auto min = [](__m128i a, __m128i b) { return _mm_min_epu8(a, b); };
  const auto max = [](__m128i a, __m128i b) { return _mm_max_epu8(a, b); };
  const __m128i c = Load(center);
  const __m128i upper = _mm_adds_epu8(c, threshold);
  const __m128i lower = _mm_subs_epu8(c, threshold);
  const auto none_beyond = [&](__m128i brightest, __m128i darkest) {
    const __m128i beyond =
        _mm_or_si128(_mm_subs_epu8(brightest, upper), _mm_subs_epu8(lower, darkest));
    return _mm_testz_si128(beyond, beyond) != 0;
  };
  __m128i p[16];
  // Every arc of nine holds one of the pixels 0 and 8, and one of 4 and 12.
  for (const size_t i : {0u, 4u, 8u, 12u}) p[i] = Load(center + offsets[i]);
  if (none_beyond(min(max(p[0], p[8]), max(p[4], p[12])), max(min(p[0], p[8]), min(p[4], p[12])))) {
    return _mm_setzero_si128();
  }
  __m128i low_quads[16];
  __m128i high_quads[16];
  for (const size_t i : {2u, 6u, 10u, 14u}) p[i] = Load(center + offsets[i]);
  MakeQuads<0>(p, min, low_quads);
  MakeQuads<0>(p, max, high_quads);
  if (none_beyond(BestQuad(low_quads, max), BestQuad(high_quads, min))) {
    return _mm_setzero_si128();
  }
#pragma GCC unroll 8
  for (size_t i = 1; i < 16; i += 2) p[i] = Load(center + offsets[i]);
  MakeQuads<1>(p, min, low_quads);
  MakeQuads<1>(p, max, high_quads);
  const __m128i score = max(_mm_subs_epu8(BestArc(p, low_quads, min, max), c),
                            _mm_subs_epu8(c, BestArc(p, high_quads, max, min)));
  const __m128i too_low = _mm_cmpeq_epi8(max(score, threshold), threshold);
  return _mm_andnot_si128(too_low, score);
}

#endif

// Scores of the first `count` <= 16 pixels, zero where not above `threshold`. May write all 16.
void Scores(const uint8_t* first, const Offsets& offsets, int threshold, int count,
            uint8_t* scores) {
#if defined(__SSE4_1__)
  static_cast<void>(count);  // a block costs the same
  const __m128i block = ScoreBlock(first, offsets, _mm_set1_epi8(static_cast<char>(threshold)));
  _mm_storeu_si128(reinterpret_cast<__m128i*>(scores), block);
#else
  for (int i = 0; i < count; ++i) {
    const int score = ScoreOf(first + i, offsets);
    scores[i] = static_cast<uint8_t>(score > threshold ? score : 0);
  }
#endif
}

// Local maxima among 16 scores in a row: bit i is set when score i is not zero, above its
// neighbours in the row above and to the left, and not below the others.
int Peaks(const uint8_t* above, const uint8_t* at, const uint8_t* below) {
#if defined(__SSE4_1__)
  const __m128i score = Load(at);
  if (_mm_testz_si128(score, score)) return 0;
  const __m128i before = _mm_max_epu8(_mm_max_epu8(Load(above - 1), Load(above)),
                                      _mm_max_epu8(Load(above + 1), Load(at - 1)));
  const __m128i after = _mm_max_epu8(_mm_max_epu8(Load(below - 1), Load(below)),
                                     _mm_max_epu8(Load(below + 1), Load(at + 1)));
  // Not above `before` (true for a score of zero), or below `after`.
  const __m128i not_above = _mm_cmpeq_epi8(_mm_max_epu8(score, before), before);
  const __m128i not_below = _mm_cmpeq_epi8(_mm_max_epu8(score, after), score);
  return _mm_movemask_epi8(_mm_andnot_si128(not_above, not_below));
#else
  int peaks = 0;
  for (int i = 0; i < kBlock; ++i) {
    const uint8_t s = at[i];
    const bool peak = s > above[i - 1] && s > above[i] && s > above[i + 1] && s > at[i - 1] &&
                      s >= at[i + 1] && s >= below[i - 1] && s >= below[i] && s >= below[i + 1];
    peaks |= static_cast<int>(peak) << i;
  }
  return peaks;
#endif
}

}  // namespace

int FastScore(const ImageBuffer& image, int x, int y) {
  return ScoreOf(image.row(y) + x, CircleOffsets(image.stride));
}

CornerOffset RefineCorner(const ImageBuffer& image, int x, int y) {
  constexpr int kRadius = 2;
  const Offsets offsets = CircleOffsets(image.stride);
  int64_t sum = 0;
  int64_t sum_x = 0;
  int64_t sum_y = 0;
  for (int dy = -kRadius; dy <= kRadius; ++dy) {
    const uint8_t* first = image.row(y + dy) + x - kRadius;
    std::array<uint8_t, kBlock> scores;
    Scores(first, offsets, 0, 2 * kRadius + 1, scores.data());
    for (int dx = -kRadius; dx <= kRadius; ++dx) {
      const int64_t score = scores[dx + kRadius];
      const int64_t weight = score * score * score;
      sum += weight;
      sum_x += weight * dx;
      sum_y += weight * dy;
    }
  }
  if (sum == 0) return {};
  return {static_cast<float>(sum_x) / static_cast<float>(sum),
          static_cast<float>(sum_y) / static_cast<float>(sum)};
}

double CornerRatio(const ImageBuffer& image, int x, int y) {
  constexpr int kRadius = 3;
  int xx = 0;
  int xy = 0;
  int yy = 0;
  for (int dy = -kRadius; dy <= kRadius; ++dy) {
    const uint8_t* above = image.row(y + dy - 1) + x;
    const uint8_t* at = image.row(y + dy) + x;
    const uint8_t* below = image.row(y + dy + 1) + x;
    for (int dx = -kRadius; dx <= kRadius; ++dx) {
      const int gx = at[dx + 1] - at[dx - 1];
      const int gy = below[dx] - above[dx];
      xx += gx * gx;
      xy += gx * gy;
      yy += gy * gy;
    }
  }
  const double half_sum = 0.5 * (xx + yy);
  if (half_sum == 0) return 0;
  const double root = std::hypot(0.5 * (xx - yy), xy);
  return std::max(0.0, half_sum - root) / (half_sum + root);
}

OrbDetector::OrbDetector(int threshold, int threshold_low, int border)
    : threshold_(threshold), threshold_low_(threshold_low), border_(border) {
  GW_CHECK(border >= 4 && 0 < threshold_low && threshold_low <= threshold && threshold < 255);
}

void OrbDetector::ScoreRow(const ImageBuffer& level, int y, uint8_t* scores) const {
  const Offsets offsets = CircleOffsets(level.stride);
  // One px wider than where corners may lie, for the comparison with neighbours.
  const int begin = border_ - 1;
  const int end = level.width - border_ + 1;
  const uint8_t* row = level.row(y);
  for (int x = begin; x < end; x += kBlock) {
    Scores(row + x, offsets, threshold_low_, std::min(kBlock, end - x), scores + x);
  }
}

void OrbDetector::Detect(const ImageBuffer& level, std::vector<Corner>* corners) {
  corners->clear();
  const int width = level.width - 2 * border_;  // of the part where corners may lie
  const int height = level.height - 2 * border_;
  if (width <= 0 || height <= 0) return;
  const size_t row_size = static_cast<size_t>(level.width) + 2 * kBlock;
  scores_.resize(3 * row_size);
  const auto scores_of = [&](int y) {
    return scores_.data() + static_cast<size_t>(y % 3) * row_size;
  };
  const int begin = border_;
  const int end = level.width - border_;
  ScoreRow(level, border_ - 1, scores_of(border_ - 1));
  ScoreRow(level, border_, scores_of(border_));
  for (int y = border_; y < level.height - border_; ++y) {
    ScoreRow(level, y + 1, scores_of(y + 1));
    const uint8_t* above = scores_of(y - 1);
    const uint8_t* at = scores_of(y);
    const uint8_t* below = scores_of(y + 1);
    for (int x = begin; x < end; x += kBlock) {
      const int valid = end - x >= kBlock ? 0xFFFF : (1 << (end - x)) - 1;
      for (int peaks = Peaks(above + x, at + x, below + x) & valid; peaks != 0;
           peaks &= peaks - 1) {
        const int i = x + std::countr_zero(static_cast<unsigned>(peaks));
        corners->push_back({static_cast<int16_t>(i), static_cast<int16_t>(y), at[i]});
      }
    }
  }

  if (threshold_low_ == threshold_) return;
  const int columns = (width + kCell - 1) / kCell;
  const int rows = (height + kCell - 1) / kCell;
  count_.assign(static_cast<size_t>(columns) * static_cast<size_t>(rows), 0);
  const auto cell_of = [&](const Corner& c) {
    const int cell = (c.y - border_) / kCell * columns + (c.x - border_) / kCell;
    return static_cast<size_t>(cell);
  };
  for (const Corner& c : *corners) count_[cell_of(c)] += c.score > threshold_;
  std::erase_if(*corners, [&](const Corner& c) {
    return c.score <= threshold_ && count_[cell_of(c)] >= kMinInCell;
  });
}

}  // namespace gw::frontend
