#include "tools/data/fault/image_faults.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "common/core/random.h"

namespace gw::fault {
namespace {

constexpr uint64_t kDropStream = 0xFA017D;

bool Contains(const std::vector<tools::Span>& spans, DurationUs t) {
  return std::any_of(spans.begin(), spans.end(), [t](const auto& s) { return s.Contains(t); });
}

cv::Mat AsMat(const ImageView& view) {
  const int type = view.format == PixelFormat::kDepth16 ? CV_16UC1 : CV_8UC1;
  // OpenCV has no read-only Mat; nobody writes through this one.
  return cv::Mat(view.height, view.width, type, const_cast<uint8_t*>(view.data),
                 static_cast<size_t>(view.stride));
}

}  // namespace

bool ImageFaults::Lost(DurationUs since_begin, int64_t seq) const {
  for (size_t i = 0; i < plan_.drop.size(); ++i) {
    const Drop& drop = plan_.drop[i];
    if (!drop.span.Contains(since_begin)) continue;
    CounterRng rng(plan_.seed, kDropStream + i, static_cast<uint64_t>(seq));
    if (rng.Uniform() < drop.probability) return true;
  }
  return false;
}

bool ImageFaults::Touches(DurationUs since_begin) const {
  const auto blurred = [&](const Blur& blur) { return blur.span.Contains(since_begin); };
  return Contains(plan_.freeze, since_begin) || Contains(plan_.black, since_begin) ||
         std::any_of(plan_.blur.begin(), plan_.blur.end(), blurred);
}

void ImageFaults::Remember(DurationUs since_begin, const wire::Bytes& message) {
  if (plan_.freeze.empty() || Contains(plan_.freeze, since_begin)) return;
  last_before_freeze_ = message;
}

wire::Bytes ImageFaults::Apply(DurationUs since_begin, CameraFrame frame,
                               FaultSummary& summary) const {
  wire::DecodedCamera frozen;  // keeps the pixels that the frame looks at
  if (Contains(plan_.freeze, since_begin) && !last_before_freeze_.empty()) {
    Result<wire::DecodedCamera> decoded = wire::DecodeCamera(last_before_freeze_);
    if (decoded) {
      frozen = *std::move(decoded);
      ++summary.frozen_frames;
      frame.left = frozen.frame.left;
      frame.right = frozen.frame.right;
      frame.depth = frozen.frame.depth;
    }
  }
  std::vector<cv::Mat> owned;  // keeps the pixels that views look at; a Mat shares them
  const auto replace = [&owned](ImageView& view, cv::Mat pixels) {
    view = {pixels.data, pixels.cols, pixels.rows, static_cast<int>(pixels.step[0]), view.format};
    owned.push_back(std::move(pixels));
  };
  if (Contains(plan_.black, since_begin)) {
    ++summary.black_frames;
    for (ImageView* view : {&frame.left, &frame.right, &frame.depth}) {
      if (!view->empty()) replace(*view, cv::Mat::zeros(AsMat(*view).size(), AsMat(*view).type()));
    }
  }
  bool counted = false;
  for (const Blur& blur : plan_.blur) {
    if (!blur.span.Contains(since_begin)) continue;
    if (!counted) ++summary.blurred_frames;
    counted = true;
    for (ImageView* view : {&frame.left, &frame.right}) {
      if (view->empty()) continue;
      cv::Mat blurred;
      cv::GaussianBlur(AsMat(*view), blurred, cv::Size(), blur.sigma_px);
      replace(*view, std::move(blurred));
    }
  }
  return wire::Encode(frame);
}

}  // namespace gw::fault
