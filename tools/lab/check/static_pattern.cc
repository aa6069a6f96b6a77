#include "tools/lab/check/static_pattern.h"

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace gw::check {
namespace {

constexpr size_t kMostImages = 64;
constexpr double kTurn = 0.2;  // rad: some 70 px of a D435i, more than any structure is wide
constexpr int kFewestImages = 5;

}  // namespace

struct PatternImages::State {
  struct Entry {
    Utime utime;
    cv::Mat gradient;  // CV_8S
  };
  std::vector<Entry> entries;
  int stride = 1, pushed = 0;
};

PatternImages::PatternImages() : state_(std::make_unique<State>()) {}
PatternImages::~PatternImages() = default;
PatternImages::PatternImages(PatternImages&&) noexcept = default;
PatternImages& PatternImages::operator=(PatternImages&&) noexcept = default;

void PatternImages::Push(Utime utime, const ImageView& image) {
  if (state_->pushed++ % state_->stride != 0) return;
  // cv::Mat has no view of constant pixels; they are not written.
  const cv::Mat grey(image.height, image.width, CV_8UC1, const_cast<uint8_t*>(image.data),
                     static_cast<size_t>(image.stride));
  cv::Mat smooth, wide, gradient;
  cv::GaussianBlur(grey, smooth, {}, 0.8);
  cv::Sobel(smooth, wide, CV_16S, 1, 0, 3, 0.25);
  wide.convertTo(gradient, CV_8S);
  state_->entries.push_back({utime, gradient});
  if (state_->entries.size() < kMostImages) return;
  std::vector<State::Entry> half;
  for (size_t i = 0; i < state_->entries.size(); i += 2) half.push_back(state_->entries[i]);
  state_->entries = std::move(half);
  state_->stride *= 2;
}

std::optional<double> PatternImages::StaticShare(
    const std::function<std::optional<double>(Utime)>& turned) const {
  cv::Mat sum;
  double energy = 0;
  int count = 0;
  std::optional<double> last;
  for (const State::Entry& entry : state_->entries) {
    const std::optional<double> angle = turned(entry.utime);
    if (!angle || (last && std::abs(*angle - *last) < kTurn)) continue;
    if (!sum.empty() && sum.size() != entry.gradient.size()) continue;
    last = angle;
    cv::Mat gradient;
    entry.gradient.convertTo(gradient, CV_32F);
    energy += cv::norm(gradient, cv::NORM_L2SQR);
    sum = sum.empty() ? gradient : cv::Mat(sum + gradient);
    ++count;
  }
  if (count < kFewestImages || energy <= 0) return std::nullopt;
  const double kept = cv::norm(sum, cv::NORM_L2SQR) / count / energy;
  const double chance = 1.0 / count;
  return (kept - chance) / (1 - chance);
}

}  // namespace gw::check
