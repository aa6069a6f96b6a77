// The image of a floor map: how dark each pixel is, and whether it is opaque.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/core/result.h"

namespace gw::floorplan {

struct MapImage {
  int width = 0, height = 0;
  std::vector<uint8_t> grey;    // 0 black to 255 white, row 0 on top
  std::vector<uint8_t> opaque;  // 1 or 0; empty: all pixels are
};

// PGM (P2 and P5, comments, any white up to 65535, which is scaled to 255), PNG and what else
// OpenCV reads; 8 or 16 bits. The colours of a pixel are averaged, as map_server does. A pixel that
// is not fully opaque says nothing.
// Errors: kNotFound, kBadData (no such image, or one that is cut off); they name the file.
Result<MapImage> LoadMapImage(const std::string& path);

}  // namespace gw::floorplan
