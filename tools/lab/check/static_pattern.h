// What stays where it is in the image while the robot turns: dots of a projector, dirt, a frozen
// image, a part of the robot.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "common/core/image_view.h"
#include "common/core/time.h"

namespace gw::check {

// Horizontal gradients of some images. Horizontal edges do not count: they stay in place when a
// robot turns.
class PatternImages {
 public:
  PatternImages();
  ~PatternImages();
  PatternImages(PatternImages&&) noexcept;
  PatternImages& operator=(PatternImages&&) noexcept;

  // Keeps at most 64 images, spread over the recording.
  void Push(Utime utime, const ImageView& image);

  // Share of the gradients' energy that is the same in all images, 0 to 1; of N images of different
  // views the mean keeps 1/N of the energy by chance, which is taken off. turned(t) is the sum of
  // the robot's turns (rad) up to t, empty where it is not known; images count when the robot has
  // turned by 0.2 rad since the one before. Empty with fewer than 5 such images.
  std::optional<double> StaticShare(
      const std::function<std::optional<double>(Utime)>& turned) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace gw::check
