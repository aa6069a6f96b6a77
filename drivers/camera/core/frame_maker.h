// Makes the message of one instant out of what the video nodes gave: the eyes apart, the time of
// the middle of the exposure, and what the image itself shows about light and projector.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/config/camera_config.h"
#include "common/contract/samples.h"
#include "drivers/camera/core/frame_clock.h"
#include "drivers/camera/core/image_statistics.h"
#include "drivers/camera/core/raw_frame.h"
#include "drivers/camera/core/recent_share.h"

namespace gw::camera {

class FrameMaker {
 public:
  struct Options {
    uint32_t fourcc = kGrey;    // format of the image: kGrey, kY8i (both eyes) or kYuyv
    bool side_by_side = false;  // the image is kGrey or kYuyv and holds both eyes in a row
    int width = 0, height = 0;  // size of the image of one eye, px
    EmitterMode emitter = EmitterMode::kOff;
    DurationUs transport_delay;
  };
  struct Counters {
    int64_t made = 0;
    int64_t untimed = 0;  // frames whose time was not known: the first half second after a start
    // Frames with the dots of an alternating projector, which are not published.
    int64_t lit = 0;
  };

  explicit FrameMaker(const Options& options);

  // The images of the result point into the maker and into `depth`, until either changes. seq
  // counts from 1 over the maker's life. Precondition: pixels have the size of the format.
  std::optional<CameraFrame> Make(const RawFrame& image, const RawFrame* depth,
                                  uint32_t set_exposure_us);
  // To be called when the stream begins anew, perhaps in the other format of a camera without
  // projector.
  void Restart(uint32_t fourcc);

  const Brightness& brightness() const { return brightness_; }  // brightness of the newest image
  bool dots_seen() const;
  bool under_exposed() const { return dark_.share() > 0.8; }
  const Counters& counters() const { return counters_; }
  const FrameClock& clock() const { return clock_; }

  // Looking for dots costs some milliseconds, so that only one image in so many is looked at,
  // unless the dots decide whether an image is published.
  static constexpr int kDotCheckPeriod = 15;

 private:
  void Unpack(const RawFrame& image);
  // Says whether this image has dots; where it is not looked at, whether the last one that was
  // looked at had.
  void LookForDots();

  Options options_;
  FrameClock clock_;
  std::vector<uint8_t> grey_, left_, right_;
  Brightness brightness_;
  EmitterState emitter_ = EmitterState::kUnknown;
  int since_dot_check_ = kDotCheckPeriod;
  RecentShare dots_{5};
  RecentShare dark_{30};
  Counters counters_;
};

}  // namespace gw::camera
