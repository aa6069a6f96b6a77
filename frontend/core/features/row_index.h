// The keypoints of the right image by row: the partner of a left keypoint lies on its row, give or
// take what rectification and detection are off.
#pragma once

#include <span>
#include <vector>

#include "common/contract/map.h"
#include "frontend/core/features/image_pyramid.h"
#include "frontend/core/features/orb_keypoint.h"

namespace gw::frontend {

// One rectified image with its features.
struct StereoSide {
  const ImagePyramid& pyramid;
  const std::vector<OrbKeypoint>& keypoints;
  const std::vector<Descriptor>& descriptors;
};

// Levels of the pyramid between the two detections of a point.
inline constexpr int kMaxLevelStep = 1;

class RowIndex {
 public:
  // A keypoint, as far as it tells whether its descriptor is worth a look.
  struct Entry {
    float u, v;
    int level;
    int index;
  };

  // Precondition: height > 0, of the image in px.
  explicit RowIndex(int height) : height_(height) {}

  // Replaces what was there by these keypoints.
  void Fill(const std::vector<OrbKeypoint>& keypoints);

  // At least those within `reach` px of row v, sorted by row. Fill has been called.
  std::span<const Entry> Near(float v, float reach) const;

 private:
  int height_;
  std::vector<int> row_begin_;  // of by_row_, per row of the image; one more at the end
  std::vector<Entry> by_row_;
};

// Where the partner of a left keypoint may lie; px of level 0.
struct PartnerWindow {
  float rows;                             // to either side
  float least_disparity, most_disparity;  // u_left - u_right
};

// The right keypoint that alone looks like the i-th left one, within the window and at most
// kMaxLevelStep beside it: at most 50 of the 256 bits differ, and at most 0.8 of those that differ
// in the second most similar one. -1: there is none.
int UnmistakablePartner(const StereoSide& left, size_t i, const StereoSide& right,
                        const RowIndex& right_rows, const PartnerWindow& window);

}  // namespace gw::frontend
