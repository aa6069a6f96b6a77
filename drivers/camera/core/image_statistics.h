// What a grey image says about its light: brightness, and whether the dot pattern of an infra-red
// projector is in it. Decided from pixels alone: what the camera claims about its projector does
// not matter, and another camera's projector shows just the same.
#pragma once

#include "common/core/image_view.h"

namespace gw::camera {

struct Brightness {
  double mean = 0;        // grey levels
  int percentile_95 = 0;  // grey level that 95 % of the pixels do not exceed
  double saturated = 0;   // share of pixels at 255
  // True where there is hardly anything to see: FAST corners need differences of 7 grey levels and
  // more.
  bool under_exposed() const { return percentile_95 < 40; }
};
// Looks at every fourth pixel of every fourth row. Precondition: the image is grey and not empty.
Brightness MeasureBrightness(const ImageView& image);

// Dots of a projector are bright, small (1 to 4 px), round, many on every surface they reach, and
// on much of the image. Natural texture has small dark spots beside its bright ones, and few of
// either in one place.
struct DotPattern {
  int bright = 0;  // small round spots brighter than all around them
  int dark = 0;    // small round spots darker than all around them
  // Share of the image's cells that hold a bright spot, cells left out that are too dark or too
  // bright to show dots.
  double covered = 0;
  double density = 0;  // mean number of bright spots in the cells that hold any
  bool lit() const { return covered > 0.2 && density > 3 && bright > 4 * dark; }
};
// Precondition: the image is grey and at least 64 x 64 px large.
DotPattern FindDots(const ImageView& image);

}  // namespace gw::camera
