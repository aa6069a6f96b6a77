#include "tools/data/fault/vision_faults.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace gw::fault {
namespace {

constexpr int kWidth = 320, kHeight = 240;
constexpr CameraOptics kOptics = {200, 0.05, 0.001};

enum class Kind { kStereo, kRgbd };

// Even grey that grows with the number of the frame; the right eye is darker by 100.
CameraImages Images(Kind kind, int frame) {
  CameraImages out;
  out.left = cv::Mat(kHeight, kWidth, CV_8U, cv::Scalar(110 + frame));
  if (kind == Kind::kStereo) {
    out.right = cv::Mat(kHeight, kWidth, CV_8U, cv::Scalar(10 + frame));
  } else {
    out.depth = cv::Mat(kHeight, kWidth, CV_16U, cv::Scalar(2000 + frame));
  }
  return out;
}

class VisionFault {
 public:
  VisionFault(FaultId id, Kind kind) : kind_(kind), faults_({{id, {}}}, kOptics) {}

  // The images of the next frame, at `seconds` since the begin of the fault.
  CameraImages Next(double seconds = 0) {
    const CameraImages in = Images(kind_, frame_++);
    const wire::Bytes bytes = EncodeWith(CameraFrame(), in);
    const auto frame = wire::DecodeCamera(bytes);
    EXPECT_TRUE(frame);
    const auto edited = faults_.Apply(DurationFromSeconds(seconds), frame->frame);
    EXPECT_TRUE(edited);
    const auto out = wire::DecodeCamera(*edited);
    EXPECT_TRUE(out);
    return CopyImages(out->frame);
  }

 private:
  Kind kind_;
  int frame_ = 0;
  VisionFaults faults_;
};

int Grey(const cv::Mat& image, int row = kHeight / 2, int column = kWidth / 2) {
  return image.at<uint8_t>(row, column);
}
int Depth(const cv::Mat& image) {
  return image.at<uint16_t>(kHeight / 2, kWidth / 2);
}
int Changed(const cv::Mat& a, const cv::Mat& b) {
  cv::Mat difference;
  cv::absdiff(a, b, difference);
  return cv::countNonZero(difference);
}

TEST(VisionFaults, TheSecondImageIsLateTheSameOrExchanged) {
  VisionFault late(FaultId::kRightLate, Kind::kStereo);
  EXPECT_EQ(Grey(late.Next().right), 10);  // the first has none before it
  EXPECT_EQ(Grey(late.Next().right), 10);
  EXPECT_EQ(Grey(late.Next().right), 11);
  EXPECT_EQ(Grey(VisionFault(FaultId::kSameEye, Kind::kStereo).Next().right), 110);
  const CameraImages swapped = VisionFault(FaultId::kEyesSwapped, Kind::kStereo).Next();
  EXPECT_EQ(Grey(swapped.left), 10);
  EXPECT_EQ(Grey(swapped.right), 110);
  VisionFault depth(FaultId::kDepthLate, Kind::kRgbd);
  depth.Next();
  EXPECT_EQ(Depth(depth.Next().depth), 2000);
  EXPECT_EQ(Depth(depth.Next().depth), 2001);
  EXPECT_EQ(Depth(VisionFault(FaultId::kDepthScaled, Kind::kRgbd).Next().depth), 2200);
}

TEST(VisionFaults, FlickerIsBrightAndDarkInTurn) {
  VisionFault fault(FaultId::kFlicker, Kind::kStereo);
  EXPECT_EQ(Grey(fault.Next().left), 66);
  EXPECT_EQ(Grey(fault.Next().left), 155);
  EXPECT_EQ(Grey(fault.Next().right), 7);
}

TEST(VisionFaults, HalfOfTheLeftLensIsCovered) {
  const CameraImages out = VisionFault(FaultId::kHalfCovered, Kind::kRgbd).Next();
  EXPECT_LT(Grey(out.left, 100, 40), 100);
  EXPECT_EQ(Grey(out.left, 100, 300), 110);
  EXPECT_EQ(out.depth.at<uint16_t>(100, 40), 0);
  EXPECT_EQ(out.depth.at<uint16_t>(100, 300), 2000);
  EXPECT_EQ(Grey(VisionFault(FaultId::kHalfCovered, Kind::kStereo).Next().right, 100, 40), 10);
}

TEST(VisionFaults, AKeyholeLeavesAWindowInTheMiddleOfBothEyesAndTheDepth) {
  const CameraImages stereo = VisionFault(FaultId::kKeyhole, Kind::kStereo).Next();
  const CameraImages rgbd = VisionFault(FaultId::kKeyhole, Kind::kRgbd).Next();
  const int side = kWidth / 10;
  EXPECT_EQ(cv::countNonZero(stereo.left), side * side);
  EXPECT_EQ(cv::countNonZero(stereo.right), side * side);
  EXPECT_EQ(cv::countNonZero(rgbd.depth), side * side);
  EXPECT_EQ(Grey(stereo.left), 110);
  EXPECT_EQ(Depth(rgbd.depth), 2000);
  EXPECT_EQ(Grey(stereo.left, kHeight / 2, kWidth / 2 + side), 0);
}

// They do not move from image to image, and lie apart by the disparity of their depth.
TEST(VisionFaults, DotsStandStillInBothEyes) {
  VisionFault fault(FaultId::kDots, Kind::kStereo);
  const CameraImages first = fault.Next(), second = fault.Next();
  const cv::Mat dots = first.left - 110, right_dots = first.right - 10;
  EXPECT_GT(cv::countNonZero(dots > 20), 180 * 5);
  EXPECT_EQ(Changed(dots > 20, second.left - 111 > 20), 0);
  const int disparity = 200 / 30;  // px, 0.05 m at 1.5 m: 6.67
  cv::Mat similarity;
  const cv::Rect part(100, 60, 150, 120);
  cv::matchTemplate(right_dots(cv::Rect(50, 60, 220, 120)), dots(part), similarity,
                    cv::TM_CCOEFF_NORMED);
  cv::Point best;
  cv::minMaxLoc(similarity, nullptr, nullptr, nullptr, &best);
  EXPECT_NEAR(part.x - (50 + best.x), disparity, 1.01);
}

TEST(VisionFaults, APersonComesStaysBeforeThreeQuartersAndGoes) {
  VisionFault fault(FaultId::kPerson, Kind::kRgbd);
  const double away = fault.Next(15).depth.at<uint16_t>(200, 160);
  EXPECT_EQ(away, 2000);
  const CameraImages there = fault.Next(5);
  EXPECT_NEAR(cv::countNonZero(there.depth == 1000) / (1.0 * kWidth * kHeight), 0.75, 0.02);
  const int walking = cv::countNonZero(fault.Next(0.7).depth == 1000);
  EXPECT_GT(walking, 0.2 * kWidth * kHeight);
  EXPECT_LT(walking, 0.5 * kWidth * kHeight);
  // In stereo, apart by the disparity of 1 m.
  VisionFault stereo(FaultId::kPerson, Kind::kStereo);
  const CameraImages pair = stereo.Next(5);
  EXPECT_EQ(
      Changed(pair.left(cv::Rect(60, 100, 200, 100)), pair.right(cv::Rect(50, 100, 200, 100))), 0);
}

TEST(VisionFaults, OutsideItsSpanAFaultLeavesTheFrame) {
  VisionFaults faults({{FaultId::kFlicker, {Milliseconds(1000), Milliseconds(2000)}}}, kOptics);
  const wire::Bytes bytes = EncodeWith(CameraFrame(), Images(Kind::kStereo, 0));
  const auto frame = wire::DecodeCamera(bytes);
  ASSERT_TRUE(frame);
  EXPECT_FALSE(faults.Apply(Milliseconds(500), frame->frame));
  EXPECT_TRUE(faults.Apply(Milliseconds(1500), frame->frame));
  EXPECT_TRUE(VisionFaults({{FaultId::kWheelsJump, {}}}, kOptics).empty());
}

}  // namespace
}  // namespace gw::fault
