// A building to look at and to bump into, made from a floor map and a seed: walls extruded from the
// map's contours, floor, ceiling, lamps, and on request doors, posters, furniture and rugs.
// Everything is a flat rectangle ("surface") with a texture and baked light.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "tools/robot/floorplan/floor_map.h"
#include "tools/sim/sim/texture_library.h"

namespace gw::sim {

enum class WallStyle { kTextured, kMixed, kFaint, kBlank, kRepetitive };
enum class FloorStyle { kWood, kCarpet, kLino };

// A rectangle of the floor, m.
struct Region {
  double x_min = 0, y_min = 0, x_max = 0, y_max = 0;
  bool Contains(const Eigen::Vector2d& p) const {
    return p.x() >= x_min && p.x() <= x_max && p.y() >= y_min && p.y() <= y_max;
  }
};

// Something that stands on the floor and is in no map.
struct LooseBox {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  // m
  double yaw = 0;                                    // rad
  double depth = 0.3, width = 0.3, height = 0.5;     // m; depth along yaw
};

struct WorldConfig {
  WallStyle walls = WallStyle::kMixed;
  FloorStyle floor = FloorStyle::kWood;
  double ceiling_m = 2.6;
  double posters_per_m = 0.35;  // mean number along a wall
  double doors_per_m = 0.08;
  double furniture_per_m = 0.12;
  double lamp_spacing_m = 2.4;
  std::vector<Region> blank_regions;  // bare, blank walls and a floor without structure
  std::vector<Region> carpets;        // the wheels slip more on them
  std::vector<LooseBox> boxes;
  // Decoration depends on the place modulo this (m), so that parts of the map that far apart look
  // alike; 0: every place is different.
  Eigen::Vector2d repeat_m = Eigen::Vector2d::Zero();
};

// A textured rectangle. Seen from its front side, u points right and v down.
struct Surface {
  Eigen::Vector3d origin;             // top left corner
  Eigen::Vector3d u, v;               // unit vectors
  double u_length = 0, v_length = 0;  // m
  int texture = 0;
  double u_texels_per_m = 1, v_texels_per_m = 1;
  double u_offset = 0, v_offset = 0;  // texels at the origin
  float emission = 0;                 // radiance of its own, where the texture is 1
  // Irradiance on a grid over the surface, row by row along u; 1 is what the exposure is made for.
  int light_width = 0, light_height = 0;
  int light_begin = 0;  // index into World::light()
  Eigen::Vector3d Normal() const { return v.cross(u); }
};

// An obstacle that is not in the floor map.
struct Box {
  Eigen::Vector2d centre;
  Eigen::Vector2d axis;  // unit, along the depth
  double half_depth = 0, half_width = 0;
  double bottom = 0;  // m above the floor
};

class World {
 public:
  // reachable_from: a point of the free space that is to be furnished and lit. keep_free: points
  // with which furniture must not interfere (the robot's way).
  World(const floorplan::FloorMap& map, const WorldConfig& config,
        const Eigen::Vector2d& reachable_from, const std::vector<Eigen::Vector2d>& keep_free,
        uint64_t seed);

  const std::vector<Surface>& surfaces() const { return surfaces_; }
  const std::vector<float>& light() const { return light_; }
  const TextureLibrary& textures() const { return textures_; }
  // The map with the furniture in it, each piece with all of the floor under it: where people would
  // not send a robot.
  const floorplan::FloorMap& obstacles() const { return obstacles_; }
  // What a robot so high (m) touches: the map, and what of the furniture stands lower. It passes
  // under a desk, between its legs. In cells of kContactCell or a little less.
  floorplan::FloorMap Contacts(double height_m) const;
  static constexpr double kContactCell = 0.02;  // m: a leg is thinner than the map's cells
  double ceiling_m() const { return config_.ceiling_m; }

 private:
  struct Lamp {
    Eigen::Vector3d position;
    double power = 0;
  };

  void AddWalls();
  void AddLooseBoxes();
  void AddFloorAndCeiling();
  void AddLamps();
  void Decorate(const Eigen::Vector2d& a, const Eigen::Vector2d& b, uint64_t key);
  bool AddFurniture(const Eigen::Vector2d& at, const Eigen::Vector2d& along,
                    const Eigen::Vector2d& out, uint32_t choice, double width);
  void AddBox(const Box& box, double bottom, double top, Material front, Material side,
              uint32_t choice);
  Surface& AddRectangle(const Eigen::Vector3d& origin, const Eigen::Vector3d& u, double u_length,
                        const Eigen::Vector3d& v, double v_length, Material material,
                        uint32_t choice);
  void BakeLight();
  double Irradiance(const Eigen::Vector3d& p, const Eigen::Vector3d& n,
                    const std::vector<int>& lamps) const;
  bool InSight(const Eigen::Vector2d& a, const Eigen::Vector2d& b) const;
  bool InBlankRegion(const Eigen::Vector2d& p) const;
  bool Reachable(const Eigen::Vector2d& p) const;
  uint64_t KeyOf(const Eigen::Vector2d& p) const;

  floorplan::FloorMap map_;
  floorplan::FloorMap obstacles_;
  floorplan::FloorMap walls_;  // the map without its furniture: what keeps light from passing
  WorldConfig config_;
  uint64_t seed_;
  TextureLibrary textures_;
  std::vector<uint8_t> reachable_;
  std::vector<float> clearance_;     // of the map, m
  std::vector<float> way_distance_;  // to keep_free, m
  std::vector<Surface> surfaces_;
  std::vector<Box> boxes_;  // of furniture and loose ones
  std::vector<Lamp> lamps_;
  std::vector<float> light_;
};

}  // namespace gw::sim
