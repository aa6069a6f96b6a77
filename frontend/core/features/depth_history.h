// The newest depth images, kept.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/core/image_view.h"

namespace gw::frontend {

class DepthHistory {
 public:
  // By how many images before the newest; empty: there is none. Valid until the next Push.
  const ImageView& Before(size_t images) const { return images_[images].view; }

  // Precondition: kDepth16.
  void Push(const ImageView& depth);
  void Clear();

 private:
  struct Image {
    std::vector<uint8_t> rows;
    ImageView view;  // of them
  };
  std::array<Image, 2> images_;  // newest first
};

}  // namespace gw::frontend
