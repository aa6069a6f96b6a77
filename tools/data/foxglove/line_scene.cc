#include "tools/data/foxglove/line_scene.h"

#include "tools/data/files/json.h"

namespace gw::foxglove {

Json SceneEntity(const std::string& id, Utime utime) {
  return {{"timestamp", JsonTime(utime)},
          {"frame_id", "world"},
          {"id", id},
          {"lifetime", {{"sec", 0}, {"nsec", 0}}},
          {"frame_locked", true},
          {"metadata", Json::array()},
          {"arrows", Json::array()},
          {"cubes", Json::array()},
          {"spheres", Json::array()},
          {"cylinders", Json::array()},
          {"lines", Json::array()},
          {"triangles", Json::array()},
          {"texts", Json::array()},
          {"models", Json::array()}};
}

Json SceneUpdate(Json entities) {
  return {{"deletions", Json::array()}, {"entities", std::move(entities)}};
}

Json LinePrimitive(LineType type, double thickness_px, Json points, const Color& color,
                   Json colors) {
  return {{"type", static_cast<int>(type)}, {"pose", JsonPose(SE3())},
          {"thickness", thickness_px},      {"scale_invariant", true},
          {"points", std::move(points)},    {"color", JsonColor(color)},
          {"colors", std::move(colors)},    {"indices", Json::array()}};
}

void LineScene::Add(const Eigen::Vector3d& p_W, const Color& color,
                    const std::optional<Anchor>& anchor) {
  const Point point{p_W, anchor, color};
  const Point* last = pieces_.empty() ? nullptr : &pieces_.back().points.back();
  if (last != nullptr && !broken_ && (last->p_W - p_W).norm() < kSpacing &&
      last->color.r == color.r && last->color.g == color.g) {
    return;
  }
  if (last == nullptr || broken_ || pieces_.back().points.size() >= kPiece) {
    Piece piece{next_number_++, {}};
    if (last != nullptr && !broken_) piece.points.push_back(*last);
    pieces_.push_back(std::move(piece));
  }
  broken_ = false;
  pieces_.back().points.push_back(point);
  changed_.insert(pieces_.back().number);
  ++size_;
  if (pieces_.size() > kMaxPieces) {
    size_ -= std::min(size_, pieces_.front().points.size());
    pieces_.pop_front();
  }
}

void LineScene::Follow(const MapView& map) {
  constexpr double kSeen = 0.002;  // m
  for (Piece& piece : pieces_) {
    for (Point& point : piece.points) {
      if (!point.anchor) continue;
      const auto T_WK = map.PoseNow(point.anchor->keyframe);
      if (!T_WK) continue;
      const Eigen::Vector3d p_W = *T_WK * point.anchor->p_K;
      if ((p_W - point.p_W).norm() > kSeen) {
        point.p_W = p_W;
        changed_.insert(piece.number);
      }
    }
  }
}

Json LineScene::Entity(const Piece& piece, Utime utime) const {
  Json points = Json::array(), colors = Json::array();
  for (const Point& point : piece.points) {
    points.push_back(JsonVector(point.p_W + Eigen::Vector3d(0, 0, style_.height_m)));
    colors.push_back(JsonColor(point.color));
  }
  const Color first = piece.points.front().color;
  Json entity = SceneEntity(style_.name + "/" + std::to_string(piece.number), utime);
  entity["lines"].push_back(LinePrimitive(LineType::kStrip, style_.thickness_px, std::move(points),
                                          first, std::move(colors)));
  return entity;
}

Json LineScene::TakeChanged(Utime utime) {
  Json entities = Json::array();
  for (const Piece& piece : pieces_) {
    if (changed_.contains(piece.number)) entities.push_back(Entity(piece, utime));
  }
  changed_.clear();
  return entities;
}

Json LineScene::All(Utime utime) {
  Json entities = Json::array();
  for (const Piece& piece : pieces_) entities.push_back(Entity(piece, utime));
  return entities;
}

}  // namespace gw::foxglove
