#include "tools/data/fault/person.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "common/core/random.h"

namespace gw::fault {
namespace {

constexpr uint64_t kClothStream = 0x9E8502;
constexpr double kDistance = 1;                          // m
constexpr double kWidth = 0.82, kTop = 0.08;             // shares of the image
constexpr double kPeriod = 20, kWalk = 1.5, kStay = 10;  // s
constexpr double kSway = 0.01, kSwayRate = 0.5;          // share of the image's width; Hz

// Where the person's middle is, in shares of the image's width; none: away.
std::optional<double> MiddleAt(double t) {
  t = std::fmod(t, kPeriod);
  const double outside = 0.5 + kWidth / 2;  // from the middle of the image
  if (t < kWalk) return 0.5 - outside * (1 - t / kWalk);
  if (t < kWalk + kStay) return 0.5 + kSway * std::sin(2 * M_PI * kSwayRate * (t - kWalk));
  if (t < 2 * kWalk + kStay) return 0.5 + outside * (t - kWalk - kStay) / kWalk;
  return std::nullopt;
}

// Patches of random grey in three sizes, from 4 px on: something that a corner detector likes.
cv::Mat Cloth(int width, int height) {
  cv::Mat sum(height, width, CV_32F, cv::Scalar(120));
  for (const int size : {4, 12, 40}) {
    cv::Mat patches(height / size + 1, width / size + 1, CV_32F);
    CounterRng rng(0, kClothStream, static_cast<uint64_t>(size));
    for (float& value : cv::Mat_<float>(patches)) value = static_cast<float>(rng.Uniform(-40, 40));
    cv::Mat large;
    cv::resize(patches, large, cv::Size(patches.cols * size, patches.rows * size), 0, 0,
               cv::INTER_NEAREST);
    sum += large(cv::Rect(0, 0, width, height));
  }
  cv::Mat out;
  sum.convertTo(out, CV_8U);
  return out;
}

// Where the person is in an image of this size: a body with round shoulders.
cv::Mat Shape(int width, int height) {
  cv::Mat shape = cv::Mat::zeros(height, width, CV_8U);
  const int round = width / 8;
  cv::rectangle(shape, {0, round}, {width, height}, 255, cv::FILLED);
  cv::rectangle(shape, {round, 0}, {width - round, round}, 255, cv::FILLED);
  cv::circle(shape, {round, round}, round, 255, cv::FILLED);
  cv::circle(shape, {width - 1 - round, round}, round, 255, cv::FILLED);
  return shape;
}

// Puts `person` at columns x and on, down to the lower border.
void Place(const cv::Mat& person, const cv::Mat& shape, int x, cv::Mat* image) {
  const cv::Rect at(x, image->rows - person.rows, person.cols, person.rows);
  const cv::Rect seen = at & cv::Rect(0, 0, image->cols, image->rows);
  if (seen.empty()) return;
  const cv::Rect part = seen - at.tl();
  person(part).copyTo((*image)(seen), shape(part));
}

}  // namespace

void DrawPerson(const CameraOptics& optics, DurationUs since_begin, CameraImages* images) {
  const auto middle = MiddleAt(since_begin.seconds());
  if (!middle) return;
  const int width = static_cast<int>(kWidth * images->left.cols);
  const int height = static_cast<int>((1 - kTop) * images->left.rows);
  const cv::Mat cloth = Cloth(width, height), shape = Shape(width, height);
  const int x = static_cast<int>(std::lround(*middle * images->left.cols)) - width / 2;
  Place(cloth, shape, x, &images->left);
  if (!images->right.empty()) {
    const double disparity = optics.fx_px * optics.baseline_m / kDistance;
    Place(cloth, shape, x - static_cast<int>(std::lround(disparity)), &images->right);
  }
  if (!images->depth.empty()) {
    const cv::Mat near(height, width, CV_16U, cv::Scalar(kDistance / optics.depth_unit_m));
    Place(near, shape, x, &images->depth);
  }
}

}  // namespace gw::fault
