// The kernels of pixel_kernels.h for processors with vectors, written once for all widths.
//
// Only for files that are compiled for one processor: everything here has internal linkage, and
// nothing is used that the linker could take from, or give to, a file compiled for another one.
#pragma once

#include <cstddef>
#include <cstdint>

#include "frontend/core/features/fast_circle.h"
#include "frontend/core/features/pixel_kernels.h"

namespace gw::frontend {
namespace {  // NOLINT(google-build-namespaces): see above

// Circle pixel i lies offsets[i] behind the centre.
[[maybe_unused]] void CircleOffsets(ptrdiff_t stride, ptrdiff_t (&offsets)[16]) {
  for (int i = 0; i < 16; ++i) offsets[i] = kFastCircle[i].y * stride + kFastCircle[i].x;
}

// Weights of the pixels x - 15 .. x + 16 of the rows of a disc, by |dy|.
struct DiscRow {
  int8_t dx[32];      // dx inside the disc, 0 outside
  int8_t inside[32];  // 1 inside the disc, 0 outside
};
struct Disc {
  DiscRow rows[PixelKernels::kDiscRadius + 1];
  int half_width[PixelKernels::kDiscRadius + 1];

  constexpr Disc() : rows{}, half_width{} {
    constexpr int kRadius = PixelKernels::kDiscRadius;
    for (int y = 0; y <= kRadius; ++y) {
      int width = kRadius;
      // (r + 1/2)^2: a round disc.
      while (width * width + y * y > kRadius * kRadius + kRadius) --width;
      half_width[y] = width;
      for (int dx = -width; dx <= width; ++dx) {
        rows[y].dx[dx + kRadius] = static_cast<int8_t>(dx);
        rows[y].inside[dx + kRadius] = 1;
      }
    }
  }
};
constexpr Disc kDisc;

// The mean difference of the pixels of two patches, from the difference of their sums.
[[maybe_unused]] int MeanDifference(int sum) {
  constexpr int kPixels = PixelKernels::kPatchSide * PixelKernels::kPatchSide;
  return static_cast<int>(__builtin_lroundf(static_cast<float>(sum) / kPixels));
}

// V is a kind of vector of bytes: V::T, V::kBytes, and the operations used below.
template <typename V>
struct VectorKernels {
  using T = typename V::T;

  struct Min {
    static T Of(T a, T b) { return V::Min8(a, b); }
  };
  struct Max {
    static T Of(T a, T b) { return V::Max8(a, b); }
  };

  // In the following, with Min and Max swapped, "smallest" reads "largest" and so on.

  // quads[i]: the smallest of the pixels i, i + 2, i + 4, i + 6, for all i of one parity.
  template <int parity, typename Smaller>
  static void MakeQuads(const T (&p)[16], T (&quads)[16]) {
    T pairs[16];
#pragma GCC unroll 8
    for (int i = parity; i < 16; i += 2) pairs[i] = Smaller::Of(p[i], p[(i + 2) % 16]);
#pragma GCC unroll 8
    for (int i = parity; i < 16; i += 2) quads[i] = Smaller::Of(pairs[i], pairs[(i + 4) % 16]);
  }

  // The largest of the quads of even pixels. Every arc of nine contains one of these quads.
  template <typename Larger>
  static T BestQuad(const T (&q)[16]) {
    return Larger::Of(Larger::Of(Larger::Of(q[0], q[2]), Larger::Of(q[4], q[6])),
                      Larger::Of(Larger::Of(q[8], q[10]), Larger::Of(q[12], q[14])));
  }

  // Largest over the 16 arcs of nine of their smallest pixel. Two arcs share their middle eight
  // pixels, and max(min(m, a), min(m, b)) = min(m, max(a, b)); so eight such middles cover all
  // arcs.
  template <typename Smaller, typename Larger>
  static T BestArc(const T (&p)[16], const T (&quads)[16]) {
    T arcs[16];
#pragma GCC unroll 8
    for (int i = 0; i < 16; i += 2) {
      arcs[i] = Smaller::Of(Smaller::Of(quads[i], quads[i + 1]),
                            Larger::Of(p[(i + 8) % 16], p[(i + 15) % 16]));
    }
    return BestQuad<Larger>(arcs);
  }

  // Scores, zero where not above the threshold. circle(i): the i-th pixels on the circles about
  // the centres.
  template <typename Circle>
  [[gnu::always_inline]] static T Scores(const Circle& circle, T center, T threshold) {
    const T upper = V::AddSaturated8(center, threshold);
    const T lower = V::SubtractSaturated8(center, threshold);
    const auto none_beyond = [&](T brightest, T darkest) {
      return V::IsZero(
          V::Or(V::SubtractSaturated8(brightest, upper), V::SubtractSaturated8(lower, darkest)));
    };
    T p[16];
    // Every arc of nine holds one of the pixels 0 and 8, and one of 4 and 12.
#pragma GCC unroll 4
    for (int i = 0; i < 16; i += 4) p[i] = circle(i);
    if (none_beyond(Min::Of(Max::Of(p[0], p[8]), Max::Of(p[4], p[12])),
                    Max::Of(Min::Of(p[0], p[8]), Min::Of(p[4], p[12])))) {
      return V::Zero();
    }
    // Narrow blocks are often done with the even pixels; wide ones, of which nearly all that come
    // so far hold a corner, are not worth the question.
    T low_quads[16];
    T high_quads[16];
#pragma GCC unroll 4
    for (int i = 2; i < 16; i += 4) p[i] = circle(i);
    MakeQuads<0, Min>(p, low_quads);
    MakeQuads<0, Max>(p, high_quads);
    if constexpr (V::kBytes <= 16) {
      if (none_beyond(BestQuad<Max>(low_quads), BestQuad<Min>(high_quads))) return V::Zero();
    }
#pragma GCC unroll 8
    for (int i = 1; i < 16; i += 2) p[i] = circle(i);
    MakeQuads<1, Min>(p, low_quads);
    MakeQuads<1, Max>(p, high_quads);
    const T score = Max::Of(V::SubtractSaturated8(BestArc<Min, Max>(p, low_quads), center),
                            V::SubtractSaturated8(center, BestArc<Max, Min>(p, high_quads)));
    return V::AndNot(V::Equal8(Max::Of(score, threshold), threshold), score);
  }

  static void FastScores(const uint8_t* first, ptrdiff_t stride, int threshold, int count,
                         uint8_t* scores) {
    const uint8_t* const rows[7] = {
        first - 3 * stride, first - 2 * stride, first - stride,    first,
        first + stride,     first + 2 * stride, first + 3 * stride};
    const T t = V::All8(threshold);
    for (int x = 0; x < count; x += V::kBytes) {
      const auto circle = [&](int i) __attribute__((always_inline)) {
        return V::Load(rows[kFastCircle[i].y + 3] + x + kFastCircle[i].x);
      };
      V::Store(scores + x, Scores(circle, V::Load(first + x), t));
    }
  }

  static void FastScores5x5(const uint8_t* first, ptrdiff_t stride, uint8_t* scores) {
    ptrdiff_t offsets[16];
    CircleOffsets(stride, offsets);
    constexpr int kRows = V::kBytes / 8;  // in a vector
    for (int begin = 0; begin < 5; begin += kRows) {
      ptrdiff_t rows[kRows];
      for (int i = 0; i < kRows; ++i) rows[i] = (begin + i < 5 ? begin + i : 4) * stride;
      const auto circle = [&](int i) { return V::LoadEights(first + offsets[i], rows); };
      V::Store(scores + begin * 8, Scores(circle, V::LoadEights(first, rows), V::Zero()));
    }
  }

  static int Peaks(const uint8_t* above, const uint8_t* at, const uint8_t* below, int begin,
                   int end, int16_t* columns) {
    int found = 0;
    for (int x = begin; x < end; x += V::kBytes) {
      const T score = V::Load(at + x);
      if (V::IsZero(score)) continue;
      const T before = Max::Of(Max::Of(V::Load(above + x - 1), V::Load(above + x)),
                               Max::Of(V::Load(above + x + 1), V::Load(at + x - 1)));
      const T after = Max::Of(Max::Of(V::Load(below + x - 1), V::Load(below + x)),
                              Max::Of(V::Load(below + x + 1), V::Load(at + x + 1)));
      // Not above `before` (true for a score of zero), or below `after`.
      const T not_above = V::Equal8(Max::Of(score, before), before);
      const T not_below = V::Equal8(Max::Of(score, after), score);
      for (uint32_t peaks = V::Signs(V::AndNot(not_above, not_below)); peaks != 0;
           peaks &= peaks - 1) {
        const int column = x + __builtin_ctz(peaks);
        if (column < end) columns[found++] = static_cast<int16_t>(column);
      }
    }
    return found;
  }

  static StructureTensor TensorOf(const uint8_t* center, ptrdiff_t stride) {
    constexpr int kRows = V::kBytes / 16;  // in a vector of 16-bit numbers
    T xx = V::Zero();
    T xy = V::Zero();
    T yy = V::Zero();
    for (int dy = -3; dy <= 3; dy += kRows) {
      // The eight pixels from dx = -3 on, of which the last does not count; nor do rows beyond the
      // area.
      const auto pixels = [&](int x, int y) {
        return V::WidenRows(center + (dy + y) * stride - 3 + x, dy + 1 <= 3 ? stride : 0);
      };
      const T inside = V::InArea(dy + 1 <= 3);
      const T gx = V::And(V::Subtract16(pixels(1, 0), pixels(-1, 0)), inside);
      const T gy = V::And(V::Subtract16(pixels(0, 1), pixels(0, -1)), inside);
      xx = V::Add32(xx, V::MultiplyPairs16(gx, gx));
      xy = V::Add32(xy, V::MultiplyPairs16(gx, gy));
      yy = V::Add32(yy, V::MultiplyPairs16(gy, gy));
    }
    return {V::Sum32(xx), V::Sum32(xy), V::Sum32(yy)};
  }

  static Moments DiscMoments(const uint8_t* center, ptrdiff_t stride) {
    constexpr int kRadius = PixelKernels::kDiscRadius;
    const T one = V::All16(1);
    T m10 = V::Zero();
    T m01 = V::Zero();
    for (int dy = -kRadius; dy <= kRadius; ++dy) {
      const DiscRow& weights = kDisc.rows[dy < 0 ? -dy : dy];
      const uint8_t* row = center + dy * stride - kRadius;
      // No sum of pairs leaves 16 bits: at most 255 * (15 + 14) * 2.
      T by_dx = V::Zero();
      T sums = V::Zero();
      for (int x = 0; x < 32; x += V::kBytes) {
        const T pixels = V::Load(row + x);
        by_dx = V::Add16(by_dx, V::MultiplyPairs8(pixels, V::Load(weights.dx + x)));
        sums = V::Add16(sums, V::MultiplyPairs8(pixels, V::Load(weights.inside + x)));
      }
      m10 = V::Add32(m10, V::MultiplyPairs16(by_dx, one));
      m01 = V::Add32(m01, V::MultiplyPairs16(sums, V::All16(dy)));
    }
    return {V::Sum32(m10), V::Sum32(m01)};
  }

  static void PatchDifferences(const uint8_t* left, ptrdiff_t left_stride, const uint8_t* right,
                               ptrdiff_t right_stride, int* differences) {
    constexpr int kSide = PixelKernels::kPatchSide;
    constexpr int kLanes = V::kBytes / 2;
    constexpr int kParts = 16 / kLanes;  // vectors of a row
    static constexpr int16_t kInside[16] = {-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1};
    T patch[kSide][kParts];
    int left_sum = 0;
    int right_sum = 0;
    for (int y = 0; y < kSide; ++y) {
      for (int k = 0; k < kParts; ++k) {
        patch[y][k] = V::LoadWiden(left + y * left_stride + k * kLanes);
      }
      for (int x = 0; x < kSide; ++x) {
        left_sum += left[y * left_stride + x];
        right_sum += right[y * right_stride + x];
      }
    }
    for (int shift = 0; shift < PixelKernels::kShifts; ++shift) {
      const T mean = V::All16(MeanDifference(left_sum - right_sum));
      T total = V::Zero();  // no lane exceeds 2 * 11 * 510
      for (int k = 0; k < kParts; ++k) {
        const T inside = V::Load(kInside + k * kLanes);
        for (int y = 0; y < kSide; ++y) {
          const T other = V::LoadWiden(right + y * right_stride + shift + k * kLanes);
          const T difference = V::Subtract16(V::Subtract16(patch[y][k], other), mean);
          total = V::Add16(total, V::And(V::Absolute16(difference), inside));
        }
      }
      differences[shift] = V::Sum32(V::MultiplyPairs16(total, V::All16(1)));
      for (int y = 0; y < kSide; ++y) {
        const uint8_t* row = right + y * right_stride + shift;
        right_sum += row[kSide] - row[0];
      }
    }
  }

  static void ColumnSums(const uint8_t* above, const uint8_t* at, const uint8_t* below, int count,
                         uint16_t* sums) {
    constexpr int kStep = V::kBytes / 2;
    const auto step = [&](int x) {
      const T middle = V::LoadWiden(at + x);
      V::Store(sums + x, V::Add16(V::Add16(V::LoadWiden(above + x), V::LoadWiden(below + x)),
                                  V::Add16(middle, middle)));
    };
    int x = 0;
    for (; x + kStep <= count; x += kStep) step(x);
    if (x < count && count >= kStep) {
      step(count - kStep);
    } else {
      for (; x < count; ++x) sums[x] = static_cast<uint16_t>(above[x] + 2 * at[x] + below[x]);
    }
  }

  static void SmoothRow(const uint16_t* sums, int count, uint8_t* out) {
    const T half = V::All16(8);
    const auto smooth = [&](int x) {
      const T middle = V::Load(sums + x + 1);
      const T sum = V::Add16(V::Add16(V::Load(sums + x), V::Load(sums + x + 2)),
                             V::Add16(V::Add16(middle, middle), half));
      return V::template ShiftRight16<4>(sum);
    };
    for (int x = 0; x < count; x += V::kBytes) {
      V::Store(out + x, V::Narrow(smooth(x), smooth(x + V::kBytes / 2)));
    }
  }

  static void InterpolateRow(const uint8_t* input, const ResizeBlock* blocks, int num_blocks,
                             int16_t* out) {
    constexpr int kAtOnce = V::kBytes / 16;
    for (int i = 0; i < num_blocks; i += kAtOnce) {
      const void* pixels[kAtOnce];
      const void* taps[kAtOnce];
      const void* weights[kAtOnce];
      for (int k = 0; k < kAtOnce; ++k) {
        pixels[k] = input + blocks[i + k].first;
        taps[k] = blocks[i + k].taps;
        weights[k] = blocks[i + k].weights;
      }
      V::Store(out + 8 * i,
               V::MultiplyPairs8(V::Shuffle8(V::LoadSixteens(pixels), V::LoadSixteens(taps)),
                                 V::LoadSixteens(weights)));
    }
  }

  static void BlendRows(const int16_t* upper, const int16_t* lower, int a, int b, int count,
                        uint8_t* out) {
    const T weights = V::Pairs16(a, b);
    const T half = V::All32(2048);
    const auto blend = [&](int x) {
      const T u = V::Load(upper + x);
      const T l = V::Load(lower + x);
      const auto weigh = [&](T pairs) {
        return V::template ShiftRight32<12>(V::Add32(V::MultiplyPairs16(pairs, weights), half));
      };
      return V::NarrowInHalves(weigh(V::InterleaveLow16(u, l)), weigh(V::InterleaveHigh16(u, l)));
    };
    for (int x = 0; x < count; x += V::kBytes) {
      V::Store(out + x, V::Narrow(blend(x), blend(x + V::kBytes / 2)));
    }
  }

  static constexpr PixelKernels kKernels = {FastScores,     FastScores5x5,    Peaks,      TensorOf,
                                            DiscMoments,    PatchDifferences, ColumnSums, SmoothRow,
                                            InterpolateRow, BlendRows};
};

}  // namespace
}  // namespace gw::frontend
