// A small floor for the tests of this folder.
#pragma once

#include "tools/robot/floorplan/floor_map.h"

namespace gw::floorplan {

// A room of 6 x 5 m, inside of its walls 5.6 x 4.6 m, with a pillar of 0.4 m in the middle.
inline FloorMap RoomForTest() {
  FloorMap map;
  map.width = 60;
  map.height = 50;
  map.resolution = 0.1;
  map.occupied.assign(60 * 50, 0);
  for (int y = 0; y < 50; ++y) {
    for (int x = 0; x < 60; ++x) {
      const bool border = x < 2 || y < 2 || x > 57 || y > 47;
      const bool pillar = x > 26 && x < 31 && y > 22 && y < 27;
      map.occupied[map.index(x, y)] = border || pillar ? 1 : 0;
    }
  }
  return map;
}

}  // namespace gw::floorplan
