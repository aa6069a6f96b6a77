// Compiled for processors with AVX2, called on no other.
#include <immintrin.h>

#include "frontend/core/features/pixel_kernels_impl.h"

namespace gw::frontend {
namespace {

struct Avx2 {
  using T = __m256i;
  static constexpr int kBytes = 32;

  static T Load(const void* p) { return _mm256_loadu_si256(static_cast<const T*>(p)); }
  static void Store(void* p, T v) { _mm256_storeu_si256(static_cast<T*>(p), v); }
  // Eight pixels at each of these places.
  static T LoadEights(const uint8_t* p, const ptrdiff_t (&at)[4]) {
    return _mm256_set_m128i(TwoEights(p + at[2], p + at[3]), TwoEights(p + at[0], p + at[1]));
  }
  static T LoadSixteens(const void* const (&p)[2]) {
    return _mm256_set_m128i(_mm_loadu_si128(static_cast<const __m128i*>(p[1])),
                            _mm_loadu_si128(static_cast<const __m128i*>(p[0])));
  }
  // Eight pixels of this row and of the one `next` bytes behind it, 16 bits each.
  static T WidenRows(const uint8_t* p, ptrdiff_t next) {
    return _mm256_cvtepu8_epi16(TwoEights(p, p + next));
  }
  // The first seven of these, and of the second row where it counts.
  static T InArea(bool second) {
    const int64_t three = 0x0000FFFFFFFFFFFF;
    return _mm256_set_epi64x(second ? three : 0, second ? -1 : 0, three, -1);
  }
  static T LoadWiden(const uint8_t* p) {
    return _mm256_cvtepu8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p)));
  }
  static T Zero() { return _mm256_setzero_si256(); }
  static T All8(int v) { return _mm256_set1_epi8(static_cast<char>(v)); }
  static T All16(int v) { return _mm256_set1_epi16(static_cast<int16_t>(v)); }
  static T All32(int v) { return _mm256_set1_epi32(v); }
  static T Pairs16(int a, int b) { return _mm256_set1_epi32(b * 65536 + a); }
  static T Min8(T a, T b) { return _mm256_min_epu8(a, b); }
  static T Max8(T a, T b) { return _mm256_max_epu8(a, b); }
  static T AddSaturated8(T a, T b) { return _mm256_adds_epu8(a, b); }
  static T SubtractSaturated8(T a, T b) { return _mm256_subs_epu8(a, b); }
  static T And(T a, T b) { return _mm256_and_si256(a, b); }
  static T Or(T a, T b) { return _mm256_or_si256(a, b); }
  static T AndNot(T a, T b) { return _mm256_andnot_si256(a, b); }
  static T Equal8(T a, T b) { return _mm256_cmpeq_epi8(a, b); }
  static bool IsZero(T a) { return _mm256_testz_si256(a, a) != 0; }
  static uint32_t Signs(T a) { return static_cast<uint32_t>(_mm256_movemask_epi8(a)); }
  static T Add16(T a, T b) { return _mm256_add_epi16(a, b); }
  static T Absolute16(T a) { return _mm256_abs_epi16(a); }
  static T Subtract16(T a, T b) { return _mm256_sub_epi16(a, b); }
  static int Sum32(T a) {
    __m128i half = _mm_add_epi32(_mm256_castsi256_si128(a), _mm256_extracti128_si256(a, 1));
    half = _mm_add_epi32(half, _mm_shuffle_epi32(half, 0x4E));
    return _mm_cvtsi128_si32(_mm_add_epi32(half, _mm_shuffle_epi32(half, 0xB1)));
  }
  static T Add32(T a, T b) { return _mm256_add_epi32(a, b); }
  template <int kBits>
  static T ShiftRight16(T a) {
    return _mm256_srli_epi16(a, kBits);
  }
  template <int kBits>
  static T ShiftRight32(T a) {
    return _mm256_srai_epi32(a, kBits);
  }
  static T Shuffle8(T a, T from) { return _mm256_shuffle_epi8(a, from); }
  static T MultiplyPairs8(T a, T b) { return _mm256_maddubs_epi16(a, b); }
  static T MultiplyPairs16(T a, T b) { return _mm256_madd_epi16(a, b); }
  // Within each half of the vector.
  static T InterleaveLow16(T a, T b) { return _mm256_unpacklo_epi16(a, b); }
  static T InterleaveHigh16(T a, T b) { return _mm256_unpackhi_epi16(a, b); }
  static T NarrowInHalves(T a, T b) { return _mm256_packs_epi32(a, b); }
  // Bytes of the values of a, then of b.
  static T Narrow(T a, T b) {
    return _mm256_permute4x64_epi64(_mm256_packus_epi16(a, b), 0b11011000);
  }

 private:
  static __m128i TwoEights(const uint8_t* a, const uint8_t* b) {
    return _mm_unpacklo_epi64(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(a)),
                              _mm_loadl_epi64(reinterpret_cast<const __m128i*>(b)));
  }
};

}  // namespace

const PixelKernels& Avx2PixelKernels() {
  return VectorKernels<Avx2>::kKernels;
}

}  // namespace gw::frontend
