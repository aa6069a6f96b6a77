#include "frontend/core/features/image_filter.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

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

}  // namespace

void BinomialFilter::Apply(const ImageView& input, ImageBuffer* output) {
  const size_t width = static_cast<size_t>(input.width);
  output->Resize(input.width, input.height, std::max(output->stride, input.width));
  column_sums_.resize(width + 2 + 2 * PixelKernels::kSlack);
  const PixelKernels& kernels = BestPixelKernels();
  const auto input_row = [&input](int y) {
    const int inside = std::clamp(y, 0, input.height - 1);
    return input.data + static_cast<ptrdiff_t>(inside) * input.stride;
  };
  uint16_t* sums = column_sums_.data() + 1;
  for (int y = 0; y < input.height; ++y) {
    kernels.column_sums(input_row(y - 1), input_row(y), input_row(y + 1), input.width, sums);
    sums[-1] = sums[0];
    sums[width] = sums[width - 1];
    // What is written beyond the row is mended by the next one.
    kernels.smooth_row(sums - 1, input.width, output->row(y));
  }
}

BilinearResizer::BilinearResizer(int input_width, int input_height, int output_width,
                                 int output_height) {
  GW_CHECK(0 < output_width && output_width <= input_width && input_width <= 2 * output_width);
  GW_CHECK(0 < output_height && output_height <= input_height && input_height <= 2 * output_height);
  for (int x = 0; x < output_width; x += kBlock) {
    ResizeBlock block;
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
  if (blocks_.size() % 2 != 0) blocks_.push_back(blocks_.back());
  for (int y = 0; y < output_height; ++y) {
    const Tap tap = TapOf(y, input_height, output_height);
    rows_.push_back({tap.first, static_cast<int16_t>(kWeightSum - tap.second_weight),
                     static_cast<int16_t>(tap.second_weight)});
  }
  for (std::vector<int16_t>& line : lines_) {
    line.resize(blocks_.size() * kBlock + PixelKernels::kSlack);
  }
}

void BilinearResizer::Apply(const ImageBuffer& input, ImageBuffer* output) {
  const PixelKernels& kernels = BestPixelKernels();
  int have[2] = {-1, -1};  // input rows in lines_
  const auto fetch = [&](int row, int slot) {
    if (have[slot] == row) return;
    kernels.interpolate_row(input.row(std::min(row, input.height - 1)), blocks_.data(),
                            static_cast<int>(blocks_.size()), lines_[slot].data());
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
    // What is written beyond the row is mended by the next one.
    kernels.blend_rows(lines_[0].data(), lines_[1].data(), row.upper_weight, row.lower_weight,
                       output->width, output->row(y));
  }
}

}  // namespace gw::frontend
