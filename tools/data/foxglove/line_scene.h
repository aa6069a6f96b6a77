// A long line that grows, as Foxglove scene entities: pieces of a fixed number of points, so that a
// point more costs one short piece, not the whole line.
#pragma once

#include <deque>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/contract/map.h"
#include "tools/data/foxglove/json_parts.h"
#include "tools/data/foxglove/map_view.h"

namespace gw::foxglove {

class LineScene {
 public:
  struct Style {
    std::string name;  // begin of the entities' ids
    double thickness_px = 2;
    double height_m = 0;  // drawn this much above where it is, so that lines do not fight
  };
  explicit LineScene(Style style) : style_(std::move(style)) {}

  // The keyframe whose movement a point follows, which may become known later than the point.
  struct Anchor {
    KeyframeId keyframe;
    Eigen::Vector3d p_K = Eigen::Vector3d::Zero();  // the point in its camera
  };
  // Adds a point in W unless it is nearer than kSpacing to the one before and has its colour.
  void Add(const Eigen::Vector3d& p_W, const Color& color, const std::optional<Anchor>& anchor);
  // The line goes on somewhere else: what is between is not drawn.
  void Break() { broken_ = true; }
  // Moves the points to where their anchors are now.
  void Follow(const MapView& map);

  size_t size() const { return size_; }
  // Entities that changed since the last call; all of them.
  Json TakeChanged(Utime utime);
  Json All(Utime utime);

  static constexpr double kSpacing = 0.03;    // m; below what can be seen on a floor
  static constexpr size_t kPiece = 200;       // points of an entity
  static constexpr size_t kMaxPieces = 1000;  // 6 km; then the oldest goes

 private:
  struct Point {
    Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
    std::optional<Anchor> anchor;
    Color color;
  };
  struct Piece {
    int64_t number = 0;
    std::vector<Point> points;
  };
  Json Entity(const Piece& piece, Utime utime) const;

  Style style_;
  std::deque<Piece> pieces_;
  std::set<int64_t> changed_;
  int64_t next_number_ = 0;
  size_t size_ = 0;
  bool broken_ = false;
};

// An entity of a scene in W, without its primitives.
Json SceneEntity(const std::string& id, Utime utime);
// A foxglove.SceneUpdate of entities that are new or replace those of the same id.
Json SceneUpdate(Json entities);
enum class LineType { kStrip = 0, kList = 2 };
Json LinePrimitive(LineType type, double thickness_px, Json points, const Color& color,
                   Json colors);

}  // namespace gw::foxglove
