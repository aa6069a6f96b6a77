// The inner loops over pixels, each in the widest form that the processor runs. All forms compute
// the same integers, so that what comes out does not depend on the processor (ADR 54).
#pragma once

#include <cstddef>
#include <cstdint>

namespace gw::frontend {

// Eight neighbouring pixels of a row that is interpolated (BilinearResizer).
struct ResizeBlock {
  int first;           // input column of the block's left-most tap
  uint8_t taps[16];    // per output pixel: left and right tap, relative to `first`
  int8_t weights[16];  // of the taps; the two sum to 64
};

// Sums of products of the gradients (differences of the two neighbours) of an area.
struct StructureTensor {
  int xx, xy, yy;
};

// Sums over a disc of grey values times the way to its centre, px.
struct Moments {
  int m10, m01;  // times dx, dy
};

struct PixelKernels {
  // Kernels may read and write so many elements beyond what they are asked for, but where they say
  // otherwise. The content there means nothing.
  static constexpr int kSlack = 32;
  static constexpr int kDiscRadius = 15;
  static constexpr int kPatchSide = 11;
  static constexpr int kShifts = 11;

  // FAST-9 scores (FastScore in orb_detector.h) of `count` pixels of a row, zero where not above
  // the threshold. Reads 3 px around them. `scores`: kSlack elements more than `count`.
  void (*fast_scores)(const uint8_t* first, ptrdiff_t stride, int threshold, int count,
                      uint8_t* scores);
  // The same of the 5x5 pixels whose top left one is `first`, row by row with threshold 0, in rows
  // of 8 elements (the last three mean nothing). Reads at most 5 px to the right of them.
  void (*fast_scores_5x5)(const uint8_t* first, ptrdiff_t stride, uint8_t* scores);
  // Local maxima of the middle one of three rows of scores: their columns, in [begin, end), to
  // `columns`, and their number. A maximum is not zero, above its neighbours in the row above and
  // to the left, and not below the others. `columns`: room for end - begin.
  int (*peaks)(const uint8_t* above, const uint8_t* at, const uint8_t* below, int begin, int end,
               int16_t* columns);
  // The tensor of the 7x7 pixels about the centre. Reads 4 px around it, and one more to the right.
  StructureTensor (*structure_tensor)(const uint8_t* center, ptrdiff_t stride);
  // Moments of the disc of radius kDiscRadius about the centre. Reads that many px around it, and
  // one more to the right.
  Moments (*disc_moments)(const uint8_t* center, ptrdiff_t stride);
  // Sums of absolute differences of a patch of kPatchSide x kPatchSide pixels and kShifts patches
  // of another image, each one pixel to the right of the one before; of each pair the mean
  // difference is taken out (the eyes' exposures need not agree). `left`, `right`: top left pixels.
  // Reads 5 px to the right of the patches as well.
  void (*patch_differences)(const uint8_t* left, ptrdiff_t left_stride, const uint8_t* right,
                            ptrdiff_t right_stride, int* differences);
  // above + 2 at + below, for each of `count` columns. Reads no pixel beyond these.
  void (*column_sums)(const uint8_t* above, const uint8_t* at, const uint8_t* below, int count,
                      uint16_t* sums);
  // (sums[x] + 2 sums[x + 1] + sums[x + 2] + 8) / 16.
  void (*smooth_row)(const uint16_t* sums, int count, uint8_t* out);
  // Each output pixel is the sum of its two taps, weighted. `num_blocks` is even.
  void (*interpolate_row)(const uint8_t* input, const ResizeBlock* blocks, int num_blocks,
                          int16_t* out);
  // (upper a + lower b + 2048) / 4096, for each of `count` columns; a + b = 64, and upper and lower
  // are at most 255 * 64.
  void (*blend_rows)(const int16_t* upper, const int16_t* lower, int a, int b, int count,
                     uint8_t* out);
};

// In portable C++.
const PixelKernels& ScalarPixelKernels();
#if defined(__SSE4_1__)
const PixelKernels& SsePixelKernels();
// Only for processors that have it.
const PixelKernels& Avx2PixelKernels();
bool HasAvx2();
#endif
// The fastest ones that this processor runs.
const PixelKernels& BestPixelKernels();

}  // namespace gw::frontend
