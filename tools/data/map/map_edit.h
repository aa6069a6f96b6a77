// Maps made from maps on disk: two joined, a session or everything outside a rectangle taken out.
// What is given stays as it is; sessions and the floor map follow the keyframes.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "backend/journal/load.h"
#include "common/core/result.h"
#include "grid/files/grid_file.h"

namespace gw::tools {

struct SavedMap {
  backend::LoadedMap map;
  std::optional<grid::GridFile> grid;  // the floor map of gw-grid, if there is one
};

struct EditedMap {
  SavedMap saved;
  std::vector<std::string> notes;  // for people: what was done, and what does not follow
};

// Rectangle of W, m: x0 < x1, y0 < y1.
struct Rectangle {
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};
// "x0,y0,x1,y1". Error kInvalidArgument.
Result<Rectangle> ParseRectangle(const std::string& text);

// Error of all: kBadData when the map contradicts itself.

// `b` in the frame of `a`, and one map with it; keyframes of `b` get ids after those of `a`.
// Errors: kNotFound when they show no place in common, kBadConfig when they were made with
// different cameras or pyramids.
Result<EditedMap> MergeSavedMaps(const SavedMap& a, const SavedMap& b);

// Without the keyframes of a session, counted from 1 as `gw-map info` lists them. Errors:
// kNotFound when there is no such session, or nothing would be left.
Result<EditedMap> RemoveSession(const SavedMap& saved, int session);

// The keyframes whose body is inside, and the landmarks that they observe. Error kNotFound when
// there are none.
Result<EditedMap> CropMap(const SavedMap& saved, const Rectangle& rectangle);

}  // namespace gw::tools
