// Is something wrong with what the camera shows, though it may still be tracked? A lens of which
// one side is covered, and light or exposure that jumps from image to image. Both cost features and
// are seen by nobody until they cost the pose.
//
// A blank wall shows no features, and loses none: what was found in the image before, and must be
// in a column of the image now as the camera has moved, is found again. Where it is not, time and
// again, and no feature ever shows from there to the side of the image, that side is covered.
//
// Brightness that a camera sees by driving goes on as it was going. That it is elsewhere than in
// the middle between the images before and after, time and again, is none of the world's doing.
#pragma once

#include <array>
#include <deque>

#include "common/core/time.h"
#include "frontend/core/features/feature_frame.h"
#include "frontend/core/features/view_fault.h"

namespace gw::frontend {

class ViewWatch {
 public:
  // width: of the image, px.
  explicit ViewWatch(double width) : width_(width) {}

  // A landmark that was found in the image before is expected at u in this one, as its pose is now
  // known: px, where it is inside.
  void Expect(double u, bool found);
  // Every image that can be used, in order of time; after what was expected of it.
  void Observe(Utime utime, const FeatureFrame& seen);

  ViewFault fault() const { return fault_; }

 private:
  static constexpr size_t kColumns = 32;
  struct Column {
    double features = 0;  // seen, lately
    double expected = 0;  // landmarks, lately
    double found = 0;     // of them
  };
  using Columns = std::array<Column, kColumns>;
  struct Light {
    Utime utime;
    double brightness = 0;
  };

  size_t ColumnOf(double u) const;
  bool Flickers() const;
  static bool IsCovered(const Columns& from_side);
  ViewFault Judge() const;

  double width_;
  Columns columns_;
  std::deque<Light> light_;
  ViewFault fault_ = ViewFault::kNone;
};

}  // namespace gw::frontend
