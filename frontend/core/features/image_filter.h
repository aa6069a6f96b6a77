// The two filters that make an image pyramid. Integer arithmetic: the same bytes on every machine.
#pragma once

#include <cstdint>
#include <vector>

#include "frontend/core/features/image_buffer.h"
#include "frontend/core/features/pixel_kernels.h"

namespace gw::frontend {

// Convolution with the 3x3 binomial kernel ([1 2 1] / 4 on both axes, variance 1/2 px^2), the
// border repeated. `output` gets the size of `input` and keeps its own stride if it has one.
class BinomialFilter {
 public:
  // Precondition: `input` is kGray8, not empty, not stored in `output`.
  void Apply(const ImageView& input, ImageBuffer* output);

 private:
  std::vector<uint16_t> column_sums_;
};

// Bilinear interpolation at (x + 0.5) * input / output - 0.5, positions rounded to 1/64 px.
class BilinearResizer {
 public:
  // Precondition: output <= input <= 2 * output on both axes, all > 0.
  BilinearResizer(int input_width, int input_height, int output_width, int output_height);

  // Precondition: the sizes given to the constructor.
  void Apply(const ImageBuffer& input, ImageBuffer* output);

 private:
  struct Row {
    int upper;
    int16_t upper_weight, lower_weight;  // sum to 64
  };

  std::vector<ResizeBlock> blocks_;
  std::vector<Row> rows_;
  std::vector<int16_t> lines_[2];  // rows of the input, interpolated horizontally, times 64
};

}  // namespace gw::frontend
