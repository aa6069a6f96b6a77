#include "drivers/camera/core/frame_maker.h"

#include "common/core/check.h"

namespace gw::camera {
namespace {

ImageView Grey(const std::vector<uint8_t>& pixels, int width, int height) {
  return {pixels.data(), width, height, width, PixelFormat::kGray8};
}

}  // namespace

FrameMaker::FrameMaker(const Options& options)
    : options_(options), clock_(options.transport_delay) {
  Restart(options.fourcc);
}

void FrameMaker::Restart(uint32_t fourcc) {
  options_.fourcc = fourcc;
  const bool two_eyes = options_.side_by_side || fourcc == kY8i;
  const size_t pixels = static_cast<size_t>(options_.width) * static_cast<size_t>(options_.height);
  left_.resize(pixels);
  right_.resize(two_eyes ? pixels : 0);
  clock_.Restart();
}

void FrameMaker::Unpack(const RawFrame& image) {
  const int sensor_width = options_.width * (options_.side_by_side ? 2 : 1);
  GW_CHECK(image.pixels.size() == ImageBytes(options_.fourcc, sensor_width, options_.height));
  if (options_.fourcc == kY8i) return SplitY8i(image.pixels, left_, right_);
  std::vector<uint8_t>& grey = options_.side_by_side ? grey_ : left_;
  if (options_.fourcc == kYuyv) {
    grey.resize(image.pixels.size() / 2);
    YuyvToGrey(image.pixels, grey);
  } else {
    grey = image.pixels;
  }
  if (options_.side_by_side) SplitSideBySide(grey_, sensor_width, left_, right_);
}

void FrameMaker::LookForDots() {
  const bool every = options_.emitter == EmitterMode::kAlternating;
  if (++since_dot_check_ < kDotCheckPeriod && !every) return;
  since_dot_check_ = 0;
  const bool lit = FindDots(Grey(left_, options_.width, options_.height)).lit();
  emitter_ = lit ? EmitterState::kOn : EmitterState::kOff;
  dots_.Add(lit);
}

bool FrameMaker::dots_seen() const {
  // While the projector alternates, two or three of five images have dots; when all of them have,
  // it does not alternate.
  return dots_.share() > (options_.emitter == EmitterMode::kAlternating ? 0.9 : 0.5);
}

std::optional<CameraFrame> FrameMaker::Make(const RawFrame& image, const RawFrame* depth,
                                            uint32_t set_exposure_us) {
  Unpack(image);
  brightness_ = MeasureBrightness(Grey(left_, options_.width, options_.height));
  dark_.Add(brightness_.under_exposed());
  LookForDots();
  const auto stamp = clock_.Add(image, set_exposure_us);
  if (options_.emitter == EmitterMode::kAlternating && emitter_ == EmitterState::kOn) {
    ++counters_.lit;
    return std::nullopt;
  }
  if (!stamp) {
    ++counters_.untimed;
    return std::nullopt;
  }
  CameraFrame frame;
  frame.utime = stamp->mid_exposure;
  frame.seq = ++counters_.made;
  frame.exposure_us = stamp->exposure_us;
  frame.emitter = emitter_;
  frame.left = Grey(left_, options_.width, options_.height);
  if (!right_.empty()) frame.right = Grey(right_, options_.width, options_.height);
  if (depth != nullptr) {
    frame.depth = {depth->pixels.data(), options_.width, options_.height, 2 * options_.width,
                   PixelFormat::kDepth16};
  }
  return frame;
}

}  // namespace gw::camera
