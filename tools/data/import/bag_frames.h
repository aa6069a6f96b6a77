// Images of a bag, decoded when the log is written.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tools/data/bag/bag.h"
#include "tools/data/import/recording.h"
#include "tools/data/import/ros_camera.h"

namespace gw::importer {

struct BagImage {
  Utime utime;
  bag::MessageRef message;
};

struct BagPair {
  Utime utime;
  bag::MessageRef left, second;  // second: the right eye, or depth
};

// How the images of a bag become those of the log.
struct BagImageRules {
  bool second_is_depth = false;
  double depth_unit_m = 0.001;
  std::optional<Undistorter> left, right;
};

// bag must have the messages of the pairs. Errors of Load name the bag and the topic.
std::unique_ptr<FrameSource> MakeBagFrames(std::unique_ptr<bag::Bag> bag,
                                           std::vector<BagPair> pairs, std::string name,
                                           BagImageRules rules);

// Pairs by stamp; both inputs increase. Depth within half a frame's time, at most 20 ms, and one
// depth image may serve two. Eyes within a quarter of a frame's time: beyond it the robot has moved
// between them, and they are no pair (kBadData, when none is left). Warns of what is left out, and
// of eyes that are apart by more than the jitter of a stamp (1 ms).
Result<std::vector<BagPair>> PairImages(const std::vector<BagImage>& left,
                                        const std::vector<BagImage>& second, bool second_is_depth,
                                        std::vector<std::string>& warnings);

}  // namespace gw::importer
