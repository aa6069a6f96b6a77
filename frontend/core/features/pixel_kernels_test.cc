#include "frontend/core/features/pixel_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <vector>

#include "common/core/random.h"

namespace gw::frontend {
namespace {

constexpr int kSlack = PixelKernels::kSlack;

struct Named {
  std::string name;
  const PixelKernels* kernels;
};

// All that this processor runs.
std::vector<Named> Kernels() {
  std::vector<Named> out;
#if defined(__SSE4_1__)
  out.push_back({"Sse", &SsePixelKernels()});
  if (HasAvx2()) out.push_back({"Avx2", &Avx2PixelKernels()});
#endif
  return out;
}

// Against the portable kernels, which define what is right.
class PixelKernelsTest : public testing::TestWithParam<Named> {
 protected:
  const PixelKernels& kernels_ = *GetParam().kernels;
  const PixelKernels& expected_ = ScalarPixelKernels();
  CounterRng rng_{11, 0, 0};

  // Grey values from noise about 120 to the whole range, so that scores of all sizes occur.
  std::vector<uint8_t> Pixels(size_t size) {
    const auto contrast = static_cast<int>(1 + rng_.Below(127));
    std::vector<uint8_t> out(size);
    for (uint8_t& p : out) {
      p = static_cast<uint8_t>(128 - contrast + static_cast<int>(rng_.Below(2 * contrast)));
    }
    return out;
  }
  // Every count up to two of the widest vectors and a bit, and then those of images.
  int CountOf(int trial) { return trial < 70 ? 1 + trial : 1 + static_cast<int>(rng_.Below(700)); }
};

TEST_P(PixelKernelsTest, ScoreCorners) {
  int64_t found = 0;
  for (int trial = 0; trial < 140; ++trial) {
    const int count = CountOf(trial);
    const int stride = count + 6 + kSlack;
    const std::vector<uint8_t> image = Pixels(7 * static_cast<size_t>(stride));
    const uint8_t* first = image.data() + 3 * stride + 3;
    const int threshold = static_cast<int>(rng_.Below(40));
    std::vector<uint8_t> a(static_cast<size_t>(count + kSlack));
    std::vector<uint8_t> b = a;
    kernels_.fast_scores(first, stride, threshold, count, a.data());
    expected_.fast_scores(first, stride, threshold, count, b.data());
    for (int i = 0; i < count; ++i) {
      ASSERT_EQ(a[i], b[i]) << trial;
      found += b[i] > 0 ? 1 : 0;
    }
  }
  EXPECT_GT(found, 100);
}

TEST_P(PixelKernelsTest, ScoreTheSurroundingsOfACorner) {
  constexpr int kStride = 64;
  int64_t found = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const std::vector<uint8_t> image = Pixels(11 * kStride);
    uint8_t a[64] = {};
    uint8_t b[64] = {};
    const uint8_t* first = image.data() + 3 * kStride + 3;
    kernels_.fast_scores_5x5(first, kStride, a);
    expected_.fast_scores_5x5(first, kStride, b);
    for (int i = 0; i < 40; ++i) {
      if (i % 8 >= 5) continue;
      ASSERT_EQ(a[i], b[i]) << trial;
      found += b[i] > 0 ? 1 : 0;
    }
  }
  EXPECT_GT(found, 100);
}

TEST_P(PixelKernelsTest, SumGradientsAndMoments) {
  constexpr int kStride = 64;
  constexpr int kRadius = PixelKernels::kDiscRadius;
  for (int trial = 0; trial < 200; ++trial) {
    const std::vector<uint8_t> image = Pixels((2 * kRadius + 1) * kStride);
    const uint8_t* center = image.data() + kRadius * kStride + kRadius;
    const StructureTensor a = kernels_.structure_tensor(center, kStride);
    const StructureTensor b = expected_.structure_tensor(center, kStride);
    ASSERT_EQ(a.xx, b.xx);
    ASSERT_EQ(a.xy, b.xy);
    ASSERT_EQ(a.yy, b.yy);
    EXPECT_GT(a.xx, 0);
    const Moments m = kernels_.disc_moments(center, kStride);
    const Moments n = expected_.disc_moments(center, kStride);
    ASSERT_EQ(m.m10, n.m10);
    ASSERT_EQ(m.m01, n.m01);
    EXPECT_NE(m.m10, 0);
  }
}

TEST_P(PixelKernelsTest, CompareShiftedPatches) {
  constexpr int kSide = PixelKernels::kPatchSide;
  constexpr int kShifts = PixelKernels::kShifts;
  constexpr int kLeft = kSide + 5;
  constexpr int kRight = kSide + kShifts + 5;
  for (int trial = 0; trial < 200; ++trial) {
    const std::vector<uint8_t> left = Pixels(kSide * kLeft);
    const std::vector<uint8_t> right = Pixels(kSide * kRight);
    std::array<int, kShifts> a;
    std::array<int, kShifts> b;
    kernels_.patch_differences(left.data(), kLeft, right.data(), kRight, a.data());
    expected_.patch_differences(left.data(), kLeft, right.data(), kRight, b.data());
    ASSERT_EQ(a, b);
    EXPECT_GT(b[0], 0);
  }
}

TEST_P(PixelKernelsTest, FindPeaks) {
  int64_t found = 0;
  for (int trial = 0; trial < 140; ++trial) {
    const int count = CountOf(trial);
    const int begin = 1 + static_cast<int>(rng_.Below(20));
    std::vector<std::vector<uint8_t>> rows;
    for (int row = 0; row < 3; ++row) {
      // Few values, so that neighbours are often equal, and none where rows have no corner.
      std::vector<uint8_t> scores(static_cast<size_t>(begin + count + 2 * kSlack));
      for (uint8_t& s : scores)
        s = static_cast<uint8_t>(std::max(0.0, rng_.Uniform(-9.0, 4.0) * 60));
      rows.push_back(scores);
    }
    std::vector<int16_t> a(static_cast<size_t>(count));
    std::vector<int16_t> b = a;
    const auto run = [&](const PixelKernels& kernels, std::vector<int16_t>& columns) {
      columns.resize(static_cast<size_t>(kernels.peaks(
          rows[0].data(), rows[1].data(), rows[2].data(), begin, begin + count, columns.data())));
    };
    run(kernels_, a);
    run(expected_, b);
    ASSERT_EQ(a, b) << trial;
    found += std::ssize(b);
  }
  EXPECT_GT(found, 100);
}

TEST_P(PixelKernelsTest, SmoothRows) {
  for (int trial = 0; trial < 140; ++trial) {
    const int count = CountOf(trial);
    // No pixel beyond: the address sanitizer sees it.
    const std::vector<uint8_t> above = Pixels(count), at = Pixels(count), below = Pixels(count);
    std::vector<uint16_t> a(static_cast<size_t>(count + 2 + 2 * kSlack));
    std::vector<uint16_t> b = a;
    kernels_.column_sums(above.data(), at.data(), below.data(), count, a.data());
    expected_.column_sums(above.data(), at.data(), below.data(), count, b.data());
    for (int i = 0; i < count; ++i) ASSERT_EQ(a[i], b[i]) << trial;
    std::vector<uint8_t> smooth_a(static_cast<size_t>(count + kSlack));
    std::vector<uint8_t> smooth_b = smooth_a;
    kernels_.smooth_row(b.data(), count, smooth_a.data());
    expected_.smooth_row(b.data(), count, smooth_b.data());
    for (int i = 0; i < count; ++i) ASSERT_EQ(smooth_a[i], smooth_b[i]) << trial;
  }
}

TEST_P(PixelKernelsTest, InterpolateAndBlendRows) {
  for (int trial = 0; trial < 140; ++trial) {
    const int num_blocks = 2 * (1 + static_cast<int>(rng_.Below(20)));
    const int count = 8 * num_blocks;
    const std::vector<uint8_t> input = Pixels(2 * static_cast<size_t>(count) + kSlack);
    std::vector<ResizeBlock> blocks;
    for (int i = 0; i < num_blocks; ++i) {
      ResizeBlock block{16 * i, {}, {}};
      for (int k = 0; k < 8; ++k) {
        block.taps[2 * k] = static_cast<uint8_t>(rng_.Below(15));
        block.taps[2 * k + 1] = static_cast<uint8_t>(block.taps[2 * k] + 1);
        block.weights[2 * k] = static_cast<int8_t>(rng_.Below(65));
        block.weights[2 * k + 1] = static_cast<int8_t>(64 - block.weights[2 * k]);
      }
      blocks.push_back(block);
    }
    std::vector<int16_t> rows[2];
    for (std::vector<int16_t>& row : rows) {
      row.resize(static_cast<size_t>(count) + kSlack);
      std::vector<int16_t> b = row;
      kernels_.interpolate_row(input.data(), blocks.data(), num_blocks, row.data());
      expected_.interpolate_row(input.data(), blocks.data(), num_blocks, b.data());
      ASSERT_TRUE(std::equal(row.begin(), row.begin() + count, b.begin())) << trial;
      std::reverse(blocks.begin(), blocks.end());
    }
    const int weight = static_cast<int>(rng_.Below(65));
    std::vector<uint8_t> a(static_cast<size_t>(count + kSlack));
    std::vector<uint8_t> b = a;
    kernels_.blend_rows(rows[0].data(), rows[1].data(), weight, 64 - weight, count, a.data());
    expected_.blend_rows(rows[0].data(), rows[1].data(), weight, 64 - weight, count, b.data());
    ASSERT_TRUE(std::equal(a.begin(), a.begin() + count, b.begin())) << trial;
  }
}

INSTANTIATE_TEST_SUITE_P(OfThisProcessor, PixelKernelsTest, testing::ValuesIn(Kernels()),
                         [](const auto& instance) { return instance.param.name; });
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(PixelKernelsTest);

}  // namespace
}  // namespace gw::frontend
