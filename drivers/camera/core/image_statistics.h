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
  // Hardly anything to see: FAST corners need differences of 7 grey levels and more.
  bool under_exposed() const { return percentile_95 < 40; }
};
// Precondition: a grey image, not empty. Looks at every fourth pixel of every fourth row.
Brightness MeasureBrightness(const ImageView& image);

// Dots of a projector are bright, small (1 to 4 px), round, many on every surface they reach, and
// on much of the image. Natural texture has small dark spots beside its bright ones, and few of
// either in one place.
struct DotPattern {
  int bright = 0;      // small round spots brighter than all around them
  int dark = 0;        // darker
  double covered = 0;  // share of the image's cells, without those too dark or too bright to show
                       // dots, that hold a bright spot
  double density = 0;  // bright spots in a cell that has any, mean
  bool lit() const { return covered > 0.2 && density > 3 && bright > 4 * dark; }
};
// Precondition: a grey image, at least 64 x 64.
DotPattern FindDots(const ImageView& image);

}  // namespace gw::camera
