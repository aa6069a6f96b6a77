#include "frontend/core/features/pixel_kernels.h"

#include "frontend/core/features/pixel_kernels_impl.h"

#if defined(__SSE4_1__)
#include <immintrin.h>
#endif

namespace gw::frontend {
namespace {

#if defined(__SSE4_1__)

struct Sse {
  using T = __m128i;
  static constexpr int kBytes = 16;

  static T Load(const void* p) { return _mm_loadu_si128(static_cast<const T*>(p)); }
  static void Store(void* p, T v) { _mm_storeu_si128(static_cast<T*>(p), v); }
  // Eight pixels at each of these places.
  static T LoadEights(const uint8_t* p, const ptrdiff_t (&at)[2]) {
    return _mm_unpacklo_epi64(_mm_loadl_epi64(reinterpret_cast<const T*>(p + at[0])),
                              _mm_loadl_epi64(reinterpret_cast<const T*>(p + at[1])));
  }
  static T LoadSixteens(const void* const (&p)[1]) { return Load(p[0]); }
  // Eight pixels, 16 bits each.
  static T WidenRows(const uint8_t* p, ptrdiff_t) { return LoadWiden(p); }
  static T InArea(bool) { return _mm_set_epi16(0, -1, -1, -1, -1, -1, -1, -1); }
  static T LoadWiden(const uint8_t* p) {
    return _mm_cvtepu8_epi16(_mm_loadl_epi64(reinterpret_cast<const T*>(p)));
  }
  static T Zero() { return _mm_setzero_si128(); }
  static T All8(int v) { return _mm_set1_epi8(static_cast<char>(v)); }
  static T All16(int v) { return _mm_set1_epi16(static_cast<int16_t>(v)); }
  static T All32(int v) { return _mm_set1_epi32(v); }
  static T Pairs16(int a, int b) { return _mm_set1_epi32(b * 65536 + a); }
  static T Min8(T a, T b) { return _mm_min_epu8(a, b); }
  static T Max8(T a, T b) { return _mm_max_epu8(a, b); }
  static T AddSaturated8(T a, T b) { return _mm_adds_epu8(a, b); }
  static T SubtractSaturated8(T a, T b) { return _mm_subs_epu8(a, b); }
  static T And(T a, T b) { return _mm_and_si128(a, b); }
  static T Or(T a, T b) { return _mm_or_si128(a, b); }
  static T AndNot(T a, T b) { return _mm_andnot_si128(a, b); }
  static T Equal8(T a, T b) { return _mm_cmpeq_epi8(a, b); }
  static bool IsZero(T a) { return _mm_testz_si128(a, a) != 0; }
  static uint32_t Signs(T a) { return static_cast<uint32_t>(_mm_movemask_epi8(a)); }
  static T Add16(T a, T b) { return _mm_add_epi16(a, b); }
  static T Absolute16(T a) { return _mm_abs_epi16(a); }
  static T Subtract16(T a, T b) { return _mm_sub_epi16(a, b); }
  static int Sum32(T a) {
    a = _mm_add_epi32(a, _mm_shuffle_epi32(a, 0x4E));
    return _mm_cvtsi128_si32(_mm_add_epi32(a, _mm_shuffle_epi32(a, 0xB1)));
  }
  static T Add32(T a, T b) { return _mm_add_epi32(a, b); }
  template <int kBits>
  static T ShiftRight16(T a) {
    return _mm_srli_epi16(a, kBits);
  }
  template <int kBits>
  static T ShiftRight32(T a) {
    return _mm_srai_epi32(a, kBits);
  }
  static T Shuffle8(T a, T from) { return _mm_shuffle_epi8(a, from); }
  static T MultiplyPairs8(T a, T b) { return _mm_maddubs_epi16(a, b); }
  static T MultiplyPairs16(T a, T b) { return _mm_madd_epi16(a, b); }
  static T InterleaveLow16(T a, T b) { return _mm_unpacklo_epi16(a, b); }
  static T InterleaveHigh16(T a, T b) { return _mm_unpackhi_epi16(a, b); }
  static T NarrowInHalves(T a, T b) { return _mm_packs_epi32(a, b); }
  // Bytes of the values of a, then of b.
  static T Narrow(T a, T b) { return _mm_packus_epi16(a, b); }
};

#endif

// The same one pixel at a time: what the others must agree with.
struct Scalar {
  static int Score(const uint8_t* center, const ptrdiff_t (&offsets)[16]) {
    int best = 0;
    for (int start = 0; start < 16; ++start) {
      int lowest = 255;
      int highest = 0;
      for (int i = start; i < start + 9; ++i) {
        const int p = center[offsets[i % 16]];
        lowest = p < lowest ? p : lowest;
        highest = p > highest ? p : highest;
      }
      const int brighter = lowest - *center;
      const int darker = *center - highest;
      const int more = brighter > darker ? brighter : darker;
      best = more > best ? more : best;
    }
    return best;
  }
  static void FastScores(const uint8_t* first, ptrdiff_t stride, int threshold, int count,
                         uint8_t* scores) {
    ptrdiff_t offsets[16];
    CircleOffsets(stride, offsets);
    for (int x = 0; x < count; ++x) {
      const int score = Score(first + x, offsets);
      scores[x] = static_cast<uint8_t>(score > threshold ? score : 0);
    }
  }
  static void FastScores5x5(const uint8_t* first, ptrdiff_t stride, uint8_t* scores) {
    for (int y = 0; y < 5; ++y) FastScores(first + y * stride, stride, 0, 5, scores + 8 * y);
  }
  static int Peaks(const uint8_t* above, const uint8_t* at, const uint8_t* below, int begin,
                   int end, int16_t* columns) {
    int found = 0;
    for (int x = begin; x < end; ++x) {
      const uint8_t s = at[x];
      const bool peak = s > above[x - 1] && s > above[x] && s > above[x + 1] && s > at[x - 1] &&
                        s >= at[x + 1] && s >= below[x - 1] && s >= below[x] && s >= below[x + 1];
      if (peak) columns[found++] = static_cast<int16_t>(x);
    }
    return found;
  }
  static StructureTensor TensorOf(const uint8_t* center, ptrdiff_t stride) {
    StructureTensor out{0, 0, 0};
    for (int dy = -3; dy <= 3; ++dy) {
      const uint8_t* at = center + dy * stride;
      for (int dx = -3; dx <= 3; ++dx) {
        const int gx = at[dx + 1] - at[dx - 1];
        const int gy = at[dx + stride] - at[dx - stride];
        out.xx += gx * gx;
        out.xy += gx * gy;
        out.yy += gy * gy;
      }
    }
    return out;
  }
  static Moments DiscMoments(const uint8_t* center, ptrdiff_t stride) {
    constexpr int kRadius = PixelKernels::kDiscRadius;
    Moments out{0, 0};
    for (int dy = -kRadius; dy <= kRadius; ++dy) {
      const uint8_t* row = center + dy * stride;
      const int half_width = kDisc.half_width[dy < 0 ? -dy : dy];
      int sum = 0;
      for (int dx = -half_width; dx <= half_width; ++dx) {
        sum += row[dx];
        out.m10 += dx * row[dx];
      }
      out.m01 += dy * sum;
    }
    return out;
  }
  static void PatchDifferences(const uint8_t* left, ptrdiff_t left_stride, const uint8_t* right,
                               ptrdiff_t right_stride, int* differences) {
    constexpr int kSide = PixelKernels::kPatchSide;
    for (int shift = 0; shift < PixelKernels::kShifts; ++shift) {
      const auto difference = [&](int x, int y) {
        return left[y * left_stride + x] - right[y * right_stride + x + shift];
      };
      int sum = 0;
      for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) sum += difference(x, y);
      }
      const int mean = MeanDifference(sum);
      differences[shift] = 0;
      for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
          const int d = difference(x, y) - mean;
          differences[shift] += d < 0 ? -d : d;
        }
      }
    }
  }
  static void ColumnSums(const uint8_t* above, const uint8_t* at, const uint8_t* below, int count,
                         uint16_t* sums) {
    for (int x = 0; x < count; ++x) {
      sums[x] = static_cast<uint16_t>(above[x] + 2 * at[x] + below[x]);
    }
  }
  static void SmoothRow(const uint16_t* sums, int count, uint8_t* out) {
    for (int x = 0; x < count; ++x) {
      out[x] = static_cast<uint8_t>((sums[x] + 2 * sums[x + 1] + sums[x + 2] + 8) >> 4);
    }
  }
  static void InterpolateRow(const uint8_t* input, const ResizeBlock* blocks, int num_blocks,
                             int16_t* out) {
    for (int i = 0; i < num_blocks; ++i) {
      const ResizeBlock& b = blocks[i];
      for (int k = 0; k < 8; ++k) {
        out[8 * i + k] =
            static_cast<int16_t>(input[b.first + b.taps[2 * k]] * b.weights[2 * k] +
                                 input[b.first + b.taps[2 * k + 1]] * b.weights[2 * k + 1]);
      }
    }
  }
  static void BlendRows(const int16_t* upper, const int16_t* lower, int a, int b, int count,
                        uint8_t* out) {
    for (int x = 0; x < count; ++x) {
      out[x] = static_cast<uint8_t>((upper[x] * a + lower[x] * b + 2048) >> 12);
    }
  }
  static constexpr PixelKernels kKernels = {FastScores,     FastScores5x5,    Peaks,      TensorOf,
                                            DiscMoments,    PatchDifferences, ColumnSums, SmoothRow,
                                            InterpolateRow, BlendRows};
};

}  // namespace

const PixelKernels& ScalarPixelKernels() {
  return Scalar::kKernels;
}

#if defined(__SSE4_1__)
const PixelKernels& SsePixelKernels() {
  return VectorKernels<Sse>::kKernels;
}

bool HasAvx2() {
  return __builtin_cpu_supports("avx2") != 0;
}
#endif

const PixelKernels& BestPixelKernels() {
#if defined(__SSE4_1__)
  return HasAvx2() ? Avx2PixelKernels() : SsePixelKernels();
#else
  return ScalarPixelKernels();
#endif
}

}  // namespace gw::frontend
