// What the images of a recording look like: exposure, sharpness, what the two eyes have in common,
// depth.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/camera/camera_model.h"
#include "common/contract/samples.h"
#include "tools/lab/check/static_pattern.h"

namespace gw::check {

// What is measured on every image.
struct ImageFact {
  Utime utime;
  int width = 0, height = 0;
  double mean_grey = 0;
  double burnt_share = 0;     // of the pixels, at 250 or above
  bool same_as_last = false;  // byte for byte
  bool same_eyes = false;     // the right image is the left one, byte for byte
};

// What is measured on some stereo pairs, a few a second: corners of the left image found in the
// right one, in rectified pixels.
struct PairFact {
  Utime utime;
  int matches = 0;
  double disparity_low_px = 0;     // 10 % of the matches are below: the farthest points
  double disparity_median_px = 0;  // left minus right; positive for a point at a finite distance
  double row_offset_px = 0;        // median of left minus right row
  double row_spread_px = 0;        // median deviation from it
};

// What is measured on some depth images.
struct DepthFact {
  double measured_share = 0;  // of the pixels, that have any value
  double usable_share = 0;    // of these, within the calibration's depth_min_m to depth_max_m
  double median_m = 0;
};

struct ImageFacts {
  std::vector<ImageFact> images;
  std::vector<PairFact> pairs;
  std::vector<DepthFact> depths;
  // Structure finer than a few pixels over that of some ten pixels, median over some images: about
  // 1 for a sharp image, whose contrast per octave is constant (Field, "Relations between the
  // statistics of natural images", 1987), far below for one out of focus.
  double sharpness = 1;
  PatternImages patterns;
};

class ImageScanner {
 public:
  explicit ImageScanner(const CameraGeometry& geometry);
  ~ImageScanner();
  void Push(const CameraFrame& frame);
  ImageFacts Finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace gw::check
