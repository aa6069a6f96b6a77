// GRID as a floor map: what gw-grid says of the floor, put together again.
#pragma once

#include <cstdint>
#include <map>
#include <utility>

#include "common/contract/grid.h"
#include "tools/robot/floorplan/floor_map.h"

namespace gw::navigate {

class FloorTiles {
 public:
  // True: something is different. Tiles that are older than what is known are ignored; another
  // grid_session or another size of cells begins anew.
  bool Take(const GridUpdate& update);

  bool empty() const { return tiles_.empty(); }
  // In W, the smallest rectangle that holds all tiles and one unknown cell around them.
  floorplan::FloorMap Map() const;

 private:
  std::map<std::pair<int32_t, int32_t>, GridTile> tiles_;  // by y, x
  int64_t session_ = 0;
  double cell_m_ = 0;
};

}  // namespace gw::navigate
