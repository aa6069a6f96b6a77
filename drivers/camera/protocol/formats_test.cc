#include <gtest/gtest.h>

#include <numeric>

#include "drivers/camera/protocol/image_format.h"

namespace gw::camera {
namespace {

using Bytes = std::vector<uint8_t>;

TEST(ImageFormat, FourccIsThatOfVideodev2) {
  EXPECT_EQ(kGrey, 0x59455247U);
  EXPECT_EQ(kY8i, 0x20493859U);
  EXPECT_EQ(kZ16, 0x2036315AU);
  EXPECT_EQ(kYuyv, 0x56595559U);
  EXPECT_EQ(FourccName(kZ16), "Z16 ");
  EXPECT_EQ(FourccName(1), "????");
}

TEST(ImageFormat, SizesWithoutPadding) {
  EXPECT_EQ(ImageBytes(kGrey, 640, 480), 307200U);
  for (const uint32_t two_bytes : {kY8i, kZ16, kYuyv}) {
    EXPECT_EQ(ImageBytes(two_bytes, 848, 480), 814080U);
  }
  EXPECT_EQ(ImageBytes(Fourcc('M', 'J', 'P', 'G'), 640, 480), 0U);
}

TEST(ImageFormat, Y8iIsLeftThenRightInEveryPixel) {
  const Bytes both{1, 101, 2, 102, 3, 103};
  Bytes left(3), right(3);
  SplitY8i(both, left, right);
  EXPECT_EQ(left, (Bytes{1, 2, 3}));
  EXPECT_EQ(right, (Bytes{101, 102, 103}));
}

TEST(ImageFormat, LumaOfYuyvIsEveryOtherByte) {
  Bytes grey(4);
  YuyvToGrey(Bytes{10, 128, 20, 129, 30, 130, 40, 131}, grey);
  EXPECT_EQ(grey, (Bytes{10, 20, 30, 40}));
}

TEST(ImageFormat, SideBySideSplitsEveryRow) {
  Bytes both(8);
  std::iota(both.begin(), both.end(), 0);
  Bytes left(4), right(4);
  SplitSideBySide(both, 4, left, right);
  EXPECT_EQ(left, (Bytes{0, 1, 4, 5}));
  EXPECT_EQ(right, (Bytes{2, 3, 6, 7}));
}

}  // namespace
}  // namespace gw::camera
