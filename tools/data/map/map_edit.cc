#include "tools/data/map/map_edit.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cinttypes>
#include <cmath>
#include <limits>
#include <utility>

#include "backend/core/map/map_check.h"
#include "backend/core/merge_maps.h"
#include "backend/core/piece/map_edit.h"
#include "tools/data/files/format.h"
#include "tools/data/map/map_export.h"

namespace gw::tools {
namespace {

Result<Done> CheckWhole(const SavedMap& saved) {
  const backend::MapFaults faults = backend::CheckMap(saved.map.map);
  if (faults.count == 0) return Done{};
  return Error{
      ErrorCode::kBadData,
      Format("the map contradicts itself in %" PRId64 " places, first: %s; gw-map check says more",
             static_cast<int64_t>(faults.count), faults.texts[0].c_str())};
}

// A new map of this content, with the sessions and the floor map of what it was made from.
EditedMap Begin(backend::Map map, const SavedMap& from) {
  EditedMap out;
  out.saved.map.map = std::move(map);
  out.saved.map.sessions = from.map.sessions;
  out.saved.grid = from.grid;
  if (!from.map.pending.empty()) {
    out.notes.push_back(
        Format("%zu keyframes that were recorded last are left out: no process has "
               "taken them into the map yet",
               from.map.pending.size()));
  }
  return out;
}

// Local grids of keyframes that are gone would have nothing to hang on.
void DropLooseGrids(EditedMap* edited) {
  if (!edited->saved.grid) return;
  auto& grids = edited->saved.grid->grids;
  const size_t before = grids.size();
  std::erase_if(grids, [&](const auto& piece) {
    return edited->saved.map.map.FindKeyframe(piece.keyframe) == nullptr;
  });
  edited->notes.push_back(Format("floor map: %zu of %zu local grids stay", grids.size(), before));
  if (grids.empty()) edited->saved.grid.reset();
}

std::string CountNote(const backend::Map& before, const backend::Map& after) {
  return Format("%zu of %zu keyframes and %zu of %zu landmarks stay", after.keyframes().size(),
                before.keyframes().size(), after.num_landmarks(), before.num_landmarks());
}

// The camera of a session. What a depth image's disparities are worth is not kept with the map: its
// depth counts here as that of a stereo pair. Nor is the range kept: what the map has of depth was
// in it.
RectifiedCamera CameraOf(const backend::MapSession& session) {
  RectifiedCamera camera;
  const backend::FeatureSource& source = session.source;
  camera.width = source.width;
  camera.height = source.height;
  camera.fx = source.fx;
  camera.fy = source.fy;
  camera.cx = source.cx;
  camera.cy = source.cy;
  camera.baseline_m = source.baseline_m;
  camera.depth_max_m = std::numeric_limits<double>::infinity();
  camera.T_BC = session.T_BC;
  return camera;
}

void AppendGrids(const SavedMap& b, int64_t ids_by, EditedMap* merged) {
  std::optional<grid::GridFile>& into = merged->saved.grid;
  if (!b.grid) return;
  if (into && into->cell_m != b.grid->cell_m) {
    merged->notes.push_back(
        Format("the floor map of the second map has cells of %g m, that of the "
               "first of %g m: only the first is kept",
               b.grid->cell_m, into->cell_m));
    return;
  }
  if (!into) into = grid::GridFile{b.grid->cell_m, {}};
  for (grid::GridMap::SavedGrid piece : b.grid->grids) {
    piece.keyframe.value += ids_by;
    into->grids.push_back(std::move(piece));
  }
}

}  // namespace

Result<Rectangle> ParseRectangle(const std::string& text) {
  std::array<double, 4> value{};
  const char* at = text.data();
  const char* const end = at + text.size();
  bool good = true;
  for (size_t i = 0; i < value.size() && good; ++i) {
    const auto parsed = std::from_chars(at, end, value[i]);
    good = parsed.ec == std::errc() && std::isfinite(value[i]) &&
           (i + 1 < value.size() ? parsed.ptr != end && *parsed.ptr == ',' : parsed.ptr == end);
    at = parsed.ptr + (i + 1 < value.size() ? 1 : 0);
  }
  if (good && value[0] < value[2] && value[1] < value[3]) {
    return Rectangle{value[0], value[1], value[2], value[3]};
  }
  return Error{ErrorCode::kInvalidArgument,
               "--rectangle " + text + ": give x0,y0,x1,y1 in metres, x0 < x1 and y0 < y1"};
}

Result<EditedMap> MergeSavedMaps(const SavedMap& a, const SavedMap& b) {
  for (const SavedMap* saved : {&a, &b}) {
    if (const auto whole = CheckWhole(*saved); !whole) return whole.error();
    if (saved->map.sessions.empty() || saved->map.map.keyframes().empty()) {
      return Error{ErrorCode::kNotFound, "one of the maps has no keyframes"};
    }
  }
  const backend::MapSession& session = a.map.sessions.back();
  const std::string differs = backend::Difference(session.source, b.map.sessions.back().source);
  if (!differs.empty()) {
    return Error{ErrorCode::kBadConfig,
                 "the maps were made with different cameras: " + differs + " in the second"};
  }
  FrontendConfig frontend;
  frontend.orb.num_levels = session.source.num_levels;
  frontend.orb.scale_factor = session.source.scale_factor;
  auto merged =
      backend::MergeMaps(a.map.map, b.map.map, BackendConfig(), frontend, CameraOf(session));
  if (!merged) return merged.error();
  EditedMap out = Begin(std::move(merged->map), a);
  const int64_t ids_by = a.map.map.newest_keyframe().value;
  for (backend::MapSession of_b : b.map.sessions) {
    of_b.first_keyframe.value += ids_by;
    out.saved.map.sessions.push_back(of_b);
  }
  AppendGrids(b, ids_by, &out);
  DropLooseGrids(&out);
  out.notes.push_back(
      Format("joined: %d views of the second map agree in where it lies in the "
             "first; %d loops closed besides",
             merged->views, merged->loops));
  return out;
}

Result<EditedMap> RemoveSession(const SavedMap& saved, int session) {
  if (const auto whole = CheckWhole(saved); !whole) return whole.error();
  const std::vector<backend::MapSession>& sessions = saved.map.sessions;
  const auto count = static_cast<int>(sessions.size());
  if (session < 1 || session > count) {
    return Error{ErrorCode::kNotFound,
                 Format("--session %d: the map has sessions 1 to %d (gw-map info lists them)",
                        session, count)};
  }
  const KeyframeId begin = sessions[static_cast<size_t>(session) - 1].first_keyframe;
  const bool last = session == count;
  const KeyframeId end = last ? KeyframeId{saved.map.map.newest_keyframe().value + 1}
                              : sessions[static_cast<size_t>(session)].first_keyframe;
  backend::Map kept =
      backend::KeepKeyframes(saved.map.map, [&](const backend::MapKeyframe& keyframe) {
        return keyframe.frame.id < begin || keyframe.frame.id >= end;
      });
  if (kept.keyframes().empty()) {
    return Error{ErrorCode::kNotFound,
                 Format("--session %d: all keyframes are of it, nothing would be left", session)};
  }
  EditedMap out = Begin(std::move(kept), saved);
  out.saved.map.sessions.erase(out.saved.map.sessions.begin() + (session - 1));
  out.notes.push_back(CountNote(saved.map.map, out.saved.map.map));
  DropLooseGrids(&out);
  return out;
}

Result<EditedMap> CropMap(const SavedMap& saved, const Rectangle& r) {
  if (const auto whole = CheckWhole(saved); !whole) return whole.error();
  backend::Map kept =
      backend::KeepKeyframes(saved.map.map, [&](const backend::MapKeyframe& keyframe) {
        const Eigen::Vector3d p = BodyPose(saved.map, keyframe.frame).translation();
        return p.x() >= r.x0 && p.x() <= r.x1 && p.y() >= r.y0 && p.y() <= r.y1;
      });
  if (kept.keyframes().empty()) {
    return Error{ErrorCode::kNotFound, "no keyframe of the map lies in the rectangle (W, metres)"};
  }
  EditedMap out = Begin(std::move(kept), saved);
  out.notes.push_back(CountNote(saved.map.map, out.saved.map.map));
  DropLooseGrids(&out);
  return out;
}

}  // namespace gw::tools
