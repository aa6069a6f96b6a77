#include "frontend/core/features/image_filter.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#if defined(__SSSE3__)
#include <immintrin.h>
#endif

#include "common/core/check.h"

namespace gw::frontend {
namespace {

constexpr int kWeightSum = 64;
constexpr int kBlock = 8;

struct Tap {
  int first;
  int second_weight;  // of kWeightSum
};

// Where output pixel i takes its value from.
Tap TapOf(int i, int input, int output) {
  const double position = (i + 0.5) * input / output - 0.5;
  const double clamped = std::clamp(position, 0.0, static_cast<double>(input - 1));
  int first = static_cast<int>(clamped);
  int weight = static_cast<int>(std::lround((clamped - first) * kWeightSum));
  if (first == input - 1 && input > 1) {
    --first;
    weight = kWeightSum;
  }
  // Both taps in range, also in an image of one pixel.
  return {first, input > 1 ? weight : 0};
}

// sums[x] = above[x] + 2 at[x] + below[x].
void SumColumns(const uint8_t* above, const uint8_t* at, const uint8_t* below, size_t width,
                uint16_t* sums) {
  size_t x = 0;
#if defined(__SSSE3__)
  const __m128i zero = _mm_setzero_si128();
  const auto load = [](const uint8_t* p) {
    return _mm_loadu_si128(reinterpret_cast<const __m128i*>(p));
  };
  const auto sum = [](__m128i a, __m128i b, __m128i c) {
    return _mm_add_epi16(_mm_add_epi16(a, c), _mm_add_epi16(b, b));
  };
  for (; x + 16 <= width; x += 16) {
    const __m128i a = load(above + x);
    const __m128i b = load(at + x);
    const __m128i c = load(below + x);
    auto* out = reinterpret_cast<__m128i*>(sums + x);
    _mm_storeu_si128(out, sum(_mm_unpacklo_epi8(a, zero), _mm_unpacklo_epi8(b, zero),
                              _mm_unpacklo_epi8(c, zero)));
    _mm_storeu_si128(out + 1, sum(_mm_unpackhi_epi8(a, zero), _mm_unpackhi_epi8(b, zero),
                                  _mm_unpackhi_epi8(c, zero)));
  }
#endif
  for (; x < width; ++x) sums[x] = static_cast<uint16_t>(above[x] + 2 * at[x] + below[x]);
}

// out[x] = (sums[x - 1] + 2 sums[x] + sums[x + 1]) / 16, rounded.
void SumRows(const uint16_t* sums, size_t width, uint8_t* out) {
  const uint16_t* left = sums - 1;
  size_t x = 0;
#if defined(__SSSE3__)
  const auto eight = [left](size_t at) {
    const auto load = [left, at](size_t shift) {
      return _mm_loadu_si128(reinterpret_cast<const __m128i*>(left + at + shift));
    };
    const __m128i middle = load(1);
    const __m128i sum =
        _mm_add_epi16(_mm_add_epi16(load(0), load(2)), _mm_add_epi16(middle, middle));
    return _mm_srli_epi16(_mm_add_epi16(sum, _mm_set1_epi16(8)), 4);
  };
  for (; x + 16 <= width; x += 16) {
    _mm_storeu_si128(reinterpret_cast<__m128i*>(out + x), _mm_packus_epi16(eight(x), eight(x + 8)));
  }
#endif
  for (; x < width; ++x) {
    out[x] = static_cast<uint8_t>((left[x] + 2 * left[x + 1] + left[x + 2] + 8) >> 4);
  }
}

// out[x] = (upper[x] a + lower[x] b) / 2^12, rounded; n is a multiple of kBlock, inputs are at most
// 255 * kWeightSum and not negative.
void BlendRows(const int16_t* upper, const int16_t* lower, int16_t a, int16_t b, size_t n,
               uint8_t* out) {
  constexpr int kShift = 12;  // both weights together
  constexpr int kHalf = 1 << (kShift - 1);
#if defined(__SSSE3__)
  const __m128i weights = _mm_set_epi16(b, a, b, a, b, a, b, a);
  const __m128i half = _mm_set1_epi32(kHalf);
  for (size_t x = 0; x < n; x += kBlock) {
    const __m128i u = _mm_loadu_si128(reinterpret_cast<const __m128i*>(upper + x));
    const __m128i l = _mm_loadu_si128(reinterpret_cast<const __m128i*>(lower + x));
    const __m128i first = _mm_madd_epi16(_mm_unpacklo_epi16(u, l), weights);
    const __m128i second = _mm_madd_epi16(_mm_unpackhi_epi16(u, l), weights);
    const __m128i words = _mm_packs_epi32(_mm_srli_epi32(_mm_add_epi32(first, half), kShift),
                                          _mm_srli_epi32(_mm_add_epi32(second, half), kShift));
    _mm_storel_epi64(reinterpret_cast<__m128i*>(out + x), _mm_packus_epi16(words, words));
  }
#else
  for (size_t x = 0; x < n; ++x) {
    out[x] = static_cast<uint8_t>((upper[x] * a + lower[x] * b + kHalf) >> kShift);
  }
#endif
}

}  // namespace

void BinomialFilter::Apply(const ImageView& input, ImageBuffer* output) {
  const size_t width = static_cast<size_t>(input.width);
  output->Resize(input.width, input.height, std::max(output->stride, input.width));
  column_sums_.resize(width + 2);
  const auto input_row = [&input](int y) {
    const int inside = std::clamp(y, 0, input.height - 1);
    return input.data + static_cast<ptrdiff_t>(inside) * input.stride;
  };
  uint16_t* sums = column_sums_.data() + 1;
  for (int y = 0; y < input.height; ++y) {
    SumColumns(input_row(y - 1), input_row(y), input_row(y + 1), width, sums);
    sums[-1] = sums[0];
    sums[width] = sums[width - 1];
    SumRows(sums, width, output->row(y));
  }
}

BilinearResizer::BilinearResizer(int input_width, int input_height, int output_width,
                                 int output_height) {
  GW_CHECK(0 < output_width && output_width <= input_width && input_width <= 2 * output_width);
  GW_CHECK(0 < output_height && output_height <= input_height && input_height <= 2 * output_height);
  for (int x = 0; x < output_width; x += kBlock) {
    Block block;
    block.first = TapOf(x, input_width, output_width).first;
    for (int i = 0; i < kBlock; ++i) {
      const Tap tap = TapOf(std::min(x + i, output_width - 1), input_width, output_width);
      const int left = tap.first - block.first;
      const int right = input_width > 1 ? left + 1 : left;
      GW_CHECK(left >= 0 && right < 16);
      block.taps[2 * i] = static_cast<uint8_t>(left);
      block.taps[2 * i + 1] = static_cast<uint8_t>(right);
      block.weights[2 * i] = static_cast<int8_t>(kWeightSum - tap.second_weight);
      block.weights[2 * i + 1] = static_cast<int8_t>(tap.second_weight);
    }
    blocks_.push_back(block);
  }
  for (int y = 0; y < output_height; ++y) {
    const Tap tap = TapOf(y, input_height, output_height);
    rows_.push_back({tap.first, static_cast<int16_t>(kWeightSum - tap.second_weight),
                     static_cast<int16_t>(tap.second_weight)});
  }
  for (std::vector<int16_t>& line : lines_) line.resize(blocks_.size() * kBlock);
}

void BilinearResizer::InterpolateRow(const uint8_t* input, int16_t* output) const {
  for (const Block& block : blocks_) {
#if defined(__SSSE3__)
    const __m128i pixels = _mm_loadu_si128(reinterpret_cast<const __m128i*>(input + block.first));
    const __m128i taps = _mm_loadu_si128(reinterpret_cast<const __m128i*>(block.taps));
    const __m128i weights = _mm_loadu_si128(reinterpret_cast<const __m128i*>(block.weights));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(output),
                     _mm_maddubs_epi16(_mm_shuffle_epi8(pixels, taps), weights));
#else
    for (int i = 0; i < kBlock; ++i) {
      output[i] = static_cast<int16_t>(
          input[block.first + block.taps[2 * i]] * block.weights[2 * i] +
          input[block.first + block.taps[2 * i + 1]] * block.weights[2 * i + 1]);
    }
#endif
    output += kBlock;
  }
}

void BilinearResizer::Apply(const ImageBuffer& input, ImageBuffer* output) {
  GW_CHECK(output->stride - output->width >= kBlock - 1);
  int have[2] = {-1, -1};  // input rows in lines_
  const auto fetch = [&](int row, int slot) {
    if (have[slot] == row) return;
    InterpolateRow(input.row(std::min(row, input.height - 1)), lines_[slot].data());
    have[slot] = row;
  };
  for (int y = 0; y < output->height; ++y) {
    const Row& row = rows_[static_cast<size_t>(y)];
    if (have[1] == row.upper) {
      std::swap(lines_[0], lines_[1]);
      std::swap(have[0], have[1]);
    }
    fetch(row.upper, 0);
    fetch(row.upper + 1, 1);
    BlendRows(lines_[0].data(), lines_[1].data(), row.upper_weight, row.lower_weight,
              lines_[0].size(), output->row(y));
  }
}

}  // namespace gw::frontend
