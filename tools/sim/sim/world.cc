#include "tools/sim/sim/world.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/core/random.h"
#include "tools/robot/floorplan/contours.h"

namespace gw::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

enum Stream : uint64_t { kWallStream = 1, kDecorStream, kLampStream, kRugStream, kThingStream };

constexpr double kPanel = 3.0;             // m of wall with one piece of texture
constexpr double kDecalLift = 0.006;       // m between a wall and what hangs on it
constexpr double kLightStep = 0.25;        // m between samples of baked light
constexpr double kLampReach = 7.0;         // m
constexpr double kFurnitureMaxSize = 2.4;  // m: smaller separate things in the map are no walls
constexpr double kWayMargin = 0.75;        // m between furniture and the robot's way

Vector3d At(const Vector2d& p, double z) {
  return {p.x(), p.y(), z};
}

floorplan::FloorMap WithoutSmallThings(const floorplan::FloorMap& map) {
  floorplan::FloorMap out = map;
  std::vector<uint8_t> seen(map.occupied.size(), 0);
  for (int start = 0; start < static_cast<int>(seen.size()); ++start) {
    if (seen[start] != 0 || map.occupied[start] == 0) continue;
    std::vector<int> cells = {start};
    seen[start] = 1;
    Eigen::AlignedBox2i bounds;
    for (size_t i = 0; i < cells.size(); ++i) {
      const int x = cells[i] % map.width, y = cells[i] / map.width;
      bounds.extend(Eigen::Vector2i(x, y));
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          if (!map.Occupied(x + dx, y + dy)) continue;
          const int next = map.index(x + dx, y + dy);
          if (seen[next] != 0) continue;
          seen[next] = 1;
          cells.push_back(next);
        }
      }
    }
    if ((bounds.sizes().maxCoeff() + 1) * map.resolution >= kFurnitureMaxSize) continue;
    for (const int cell : cells) out.occupied[cell] = 0;
  }
  return out;
}

Vector3d Flat(const Vector2d& p) {
  return {p.x(), p.y(), 0};
}

// The same map, of cells that are `parts` times smaller.
floorplan::FloorMap Refined(const floorplan::FloorMap& map, int parts) {
  floorplan::FloorMap out;
  out.width = map.width * parts;
  out.height = map.height * parts;
  out.resolution = map.resolution / parts;
  out.origin = map.origin;
  out.occupied.reserve(static_cast<size_t>(out.width) * static_cast<size_t>(out.height));
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      out.occupied.push_back(map.occupied[map.index(x / parts, y / parts)]);
    }
  }
  return out;
}

// Every cell that the box covers a part of.
void MarkBox(const Box& box, floorplan::FloorMap* map) {
  const Vector2d along(-box.axis.y(), box.axis.x());
  const double step = map->resolution / 2;
  for (double x = -box.half_width; x <= box.half_width; x += step) {
    for (double y = -box.half_depth; y <= box.half_depth; y += step) {
      const Eigen::Vector2i cell = map->CellOf(box.centre + along * x + box.axis * y);
      if (map->InMap(cell.x(), cell.y())) map->occupied[map->index(cell.x(), cell.y())] = 1;
    }
  }
}

}  // namespace

World::World(const floorplan::FloorMap& map, const WorldConfig& config,
             const Vector2d& reachable_from, const std::vector<Vector2d>& keep_free, uint64_t seed)
    : map_(map),
      obstacles_(map),
      walls_(WithoutSmallThings(map)),
      config_(config),
      seed_(seed),
      textures_(seed),
      reachable_(floorplan::ReachableCells(map, reachable_from)),
      clearance_(floorplan::DistanceToOccupied(map, 5.0)) {
  floorplan::FloorMap way = map;
  std::fill(way.occupied.begin(), way.occupied.end(), 0);
  for (const Vector2d& p : keep_free) {
    const Eigen::Vector2i cell = way.CellOf(p);
    if (way.InMap(cell.x(), cell.y())) way.occupied[way.index(cell.x(), cell.y())] = 1;
  }
  way_distance_ = floorplan::DistanceToOccupied(way, 5.0);
  AddWalls();
  AddLooseBoxes();
  AddFloorAndCeiling();
  AddLamps();
  BakeLight();
}

bool World::InBlankRegion(const Vector2d& p) const {
  return std::any_of(config_.blank_regions.begin(), config_.blank_regions.end(),
                     [&p](const Region& region) { return region.Contains(p); });
}

bool World::Reachable(const Vector2d& p) const {
  const Eigen::Vector2i cell = map_.CellOf(p);
  return map_.InMap(cell.x(), cell.y()) && reachable_[map_.index(cell.x(), cell.y())] != 0;
}

uint64_t World::KeyOf(const Vector2d& p) const {
  Vector2d q = p - map_.origin;
  for (int i = 0; i < 2; ++i) {
    if (config_.repeat_m[i] > 0)
      q[i] -= config_.repeat_m[i] * std::floor(q[i] / config_.repeat_m[i]);
  }
  const auto x = static_cast<uint64_t>(std::llround(q.x() * 10) + 1'000'000);
  const auto y = static_cast<uint64_t>(std::llround(q.y() * 10) + 1'000'000);
  return x << 32 | y;
}

Surface& World::AddRectangle(const Vector3d& origin, const Vector3d& u, double u_length,
                             const Vector3d& v, double v_length, Material material,
                             uint32_t choice) {
  Surface s;
  s.origin = origin;
  s.u = u;
  s.v = v;
  s.u_length = u_length;
  s.v_length = v_length;
  s.texture = textures_.Variant(material, choice);
  const Texture& texture = textures_.texture(s.texture);
  const double period = textures_.PeriodMetres(material);
  if (period > 0) {
    s.u_texels_per_m = texture.width() / period;
    s.v_texels_per_m = texture.height() / period;
    CounterRng rng(seed_, kWallStream, choice);
    s.u_offset = rng.Below(texture.width());
    s.v_offset = rng.Below(texture.height());
  } else {
    s.u_texels_per_m = texture.width() / u_length;
    s.v_texels_per_m = texture.height() / v_length;
    s.u_offset = s.v_offset = -0.5;  // texel borders on the surface's borders
  }
  surfaces_.push_back(s);
  return surfaces_.back();
}

void World::AddWalls() {
  const double lift = 1.5 * map_.resolution;
  for (const floorplan::Contour& contour : floorplan::TraceContours(map_, 1.45 * map_.resolution)) {
    Eigen::AlignedBox2d bounds;
    for (const Vector2d& p : contour.vertices) bounds.extend(p);
    // The outline of a hole in a wall also is small, but its free side is inside.
    const bool thing = bounds.sizes().maxCoeff() < kFurnitureMaxSize;
    const Vector2d middle = bounds.center();
    CounterRng thing_rng(seed_, kThingStream, KeyOf(middle));
    const double thing_height =
        bounds.sizes().maxCoeff() < 0.25 ? 0.75 : thing_rng.Uniform(0.5, 1.4);
    const auto thing_material = bounds.sizes().maxCoeff() < 0.25 ? Material::kTrim
                                : thing_rng.Below(2) == 0        ? Material::kPanelling
                                                                 : Material::kPlaster;
    const size_t n = contour.vertices.size();
    for (size_t i = 0; i < n; ++i) {
      const Vector2d a = contour.vertices[i];
      const Vector2d b = contour.vertices[(i + 1) % n];
      const double length = (b - a).norm();
      const Vector2d along = (b - a) / length;
      const Vector2d out(along.y(), -along.x());
      bool visible = false;
      for (int k = 0; k <= 8 && !visible; ++k) {
        visible = Reachable(a + (b - a) * ((k + 0.5) / 9) + out * lift);
      }
      if (!visible) continue;
      const Vector2d centre = 0.5 * (a + b);
      const bool blank = InBlankRegion(centre + out * lift);
      const double height = thing ? thing_height : config_.ceiling_m;
      CounterRng rng(seed_, kWallStream, KeyOf(centre + 0.01 * out));
      Material material = Material::kPlaster;
      WallStyle style = blank ? WallStyle::kBlank : config_.walls;
      if (style == WallStyle::kMixed) {
        style = rng.Below(10) < 6 ? WallStyle::kTextured : WallStyle::kFaint;
      }
      switch (style) {
        case WallStyle::kFaint:
          material = Material::kFaint;
          break;
        case WallStyle::kBlank:
          material = Material::kBlank;
          break;
        case WallStyle::kRepetitive:
          material = Material::kRepetitive;
          break;
        default: {
          const uint32_t dice = rng.Below(8);
          material = dice < 5   ? Material::kPlaster
                     : dice < 7 ? Material::kBrick
                                : Material::kPanelling;
        }
      }
      if (thing && !blank) material = thing_material;
      const int panels = std::max(1, static_cast<int>(std::ceil(length / kPanel)));
      for (int k = 0; k < panels; ++k) {
        const Vector2d start = a + along * (length * k / panels);
        // One wall keeps its variant of the material; the offset differs from panel to panel.
        Surface& panel = AddRectangle(At(start, height), Flat(along), length / panels,
                                      -Vector3d::UnitZ(), height, material, rng.Below(1u << 30));
        if (style == WallStyle::kRepetitive) panel.u_offset = panel.v_offset = 0;
      }
      if (thing) continue;
      if (!blank) {
        AddRectangle(At(a + out * kDecalLift, 0.08), Flat(along), length, -Vector3d::UnitZ(), 0.08,
                     Material::kTrim, rng.Below(1000));
        Decorate(a, b, KeyOf(centre + 0.01 * out));
      }
    }
  }
}

void World::Decorate(const Vector2d& a, const Vector2d& b, uint64_t key) {
  const double length = (b - a).norm();
  const Vector2d along = (b - a) / length;
  const Vector2d out(along.y(), -along.x());
  CounterRng rng(seed_, kDecorStream, key);
  const double per_m = config_.posters_per_m + config_.doors_per_m + config_.furniture_per_m;
  if (per_m <= 0) return;
  double s = rng.Uniform(0.2, 0.6);
  while (true) {
    // Space between two things: exponential, so that their number is Poisson.
    s += 0.15 - std::log(1 - rng.Uniform()) * std::max(0.0, 1 / per_m - 0.9);
    const double dice = rng.Uniform() * per_m;
    const uint32_t choice = rng.Below(1u << 30);
    const double size = rng.Uniform();
    const double lift = rng.Uniform();
    const auto fits = [&](double width) { return s + width + 0.15 < length; };
    if (!fits(0.3)) return;
    const Vector2d at = a + along * s;
    if (InBlankRegion(at + out * 0.15)) {
      s += 0.5;
      continue;
    }
    if (dice < config_.posters_per_m) {
      const double width = 0.35 + 0.6 * size;
      const double height = width * (choice % 3 == 0 ? 0.7 : 1.35);
      if (!fits(width)) return;
      AddRectangle(At(at + out * kDecalLift, 0.35 + height + lift * 0.9), Flat(along), width,
                   -Vector3d::UnitZ(), height, Material::kPoster, choice);
      s += width;
    } else if (dice < config_.posters_per_m + config_.doors_per_m) {
      constexpr double kWidth = 0.95, kHeight = 2.05, kFrame = 0.08;
      if (!fits(kWidth + 2 * kFrame)) {
        s += 0.3;
        continue;
      }
      AddRectangle(At(at + out * 1.5 * kDecalLift, kHeight + kFrame), Flat(along),
                   kWidth + 2 * kFrame, -Vector3d::UnitZ(), kHeight + kFrame, Material::kTrim,
                   choice);
      AddRectangle(At(at + along * kFrame + out * 2.5 * kDecalLift, kHeight), Flat(along), kWidth,
                   -Vector3d::UnitZ(), kHeight, Material::kDoor, choice);
      s += kWidth + 2 * kFrame;
    } else {
      const double width = 0.5 + 0.6 * size;
      if (!fits(width)) return;
      AddFurniture(at + along * (width / 2), along, out, choice, width);
      s += width;
    }
  }
}

bool World::AddFurniture(const Vector2d& at, const Vector2d& along, const Vector2d& out,
                         uint32_t choice, double width) {
  CounterRng rng(seed_, kThingStream, choice);
  const uint32_t kind = rng.Below(4);
  const double depth = kind == 0 ? 0.32 : kind == 3 ? 0.6 : 0.42;
  const Box box{at + out * (depth / 2 + 0.01), out, depth / 2, width / 2};
  // Room to pass in front of it, and nothing near the robot's way.
  for (const double side : {-0.5, 0.0, 0.5}) {
    for (double d = 0.2; d < depth + 1.4; d += 0.1) {
      const Vector2d p = at + along * (side * width) + out * d;
      if (!Reachable(p) || obstacles_.Occupied(map_.CellOf(p).x(), map_.CellOf(p).y()))
        return false;
      const Eigen::Vector2i cell = map_.CellOf(p);
      if (d < depth + 0.1 && way_distance_[map_.index(cell.x(), cell.y())] < kWayMargin)
        return false;
    }
  }
  const double tall = rng.Uniform();
  switch (kind) {
    case 0:
      AddBox(box, 0, 1.5 + 0.5 * tall, Material::kBooks, Material::kPanelling, choice);
      break;
    case 1:
      AddBox(box, 0, 0.7 + 0.6 * tall, Material::kCabinet, Material::kPanelling, choice);
      break;
    case 2:
      AddBox(box, 0, 0.3 + 0.2 * tall, Material::kCardboard, Material::kCardboard, choice);
      AddBox({box.centre, box.axis, box.half_depth * 0.8, box.half_width * 0.7}, 0.3 + 0.2 * tall,
             0.6 + 0.3 * tall, Material::kCardboard, Material::kCardboard, choice + 1);
      break;
    default: {  // desk
      AddBox(box, 0.70, 0.75, Material::kPanelling, Material::kPanelling, choice);
      for (const double dx : {-1.0, 1.0}) {
        for (const double dy : {-1.0, 1.0}) {
          const Vector2d leg = box.centre + along * (dx * (box.half_width - 0.03)) +
                               out * (dy * (box.half_depth - 0.03));
          AddBox({leg, out, 0.025, 0.025}, 0, 0.70, Material::kTrim, Material::kTrim, choice);
        }
      }
      AddBox({box.centre - out * 0.1, out, 0.15, 0.12}, 0, 0.45, Material::kCardboard,
             Material::kTrim, choice);
    }
  }
  MarkBox(box, &obstacles_);
  return true;
}

floorplan::FloorMap World::Contacts(double height_m) const {
  const int parts = static_cast<int>(std::ceil(map_.resolution / kContactCell - 1e-9));
  floorplan::FloorMap out = Refined(map_, parts);
  for (const Box& box : boxes_) {
    if (box.bottom < height_m) MarkBox(box, &out);
  }
  return out;
}

void World::AddLooseBoxes() {
  for (const LooseBox& loose : config_.boxes) {
    const Box box{loose.centre, Vector2d(std::cos(loose.yaw), std::sin(loose.yaw)), loose.depth / 2,
                  loose.width / 2};
    CounterRng rng(seed_, kThingStream, KeyOf(loose.centre));
    AddBox(box, 0, loose.height, Material::kCardboard, Material::kCardboard, rng.Below(1u << 30));
    MarkBox(box, &obstacles_);
  }
}

void World::AddBox(const Box& box, double bottom, double top, Material front, Material side,
                   uint32_t choice) {
  const Vector2d out = box.axis;
  const Vector2d along(-out.y(), out.x());  // right, seen from outside
  const double height = top - bottom;
  boxes_.push_back(box);
  boxes_.back().bottom = bottom;
  const auto face = [&](const Vector2d& normal, double half_depth, double half_width,
                        Material material) {
    const Vector2d right(-normal.y(), normal.x());
    const Vector2d start = box.centre + normal * half_depth - right * half_width;
    AddRectangle(At(start, top), Flat(right), 2 * half_width, -Vector3d::UnitZ(), height, material,
                 choice);
  };
  face(out, box.half_depth, box.half_width, front);
  face(-out, box.half_depth, box.half_width, side);
  face(along, box.half_width, box.half_depth, side);
  face(-along, box.half_width, box.half_depth, side);
  // Top, seen from above: v points down the page.
  AddRectangle(At(box.centre - along * box.half_width - out * box.half_depth, top), Flat(along),
               2 * box.half_width, Flat(out), 2 * box.half_depth, side, choice);
  if (bottom > 0) {
    AddRectangle(At(box.centre - along * box.half_width + out * box.half_depth, bottom),
                 Flat(along), 2 * box.half_width, -Flat(out), 2 * box.half_depth, side, choice);
  }
}

void World::AddFloorAndCeiling() {
  const double w = map_.width * map_.resolution;
  const double h = map_.height * map_.resolution;
  const Material floor = config_.floor == FloorStyle::kWood     ? Material::kWoodFloor
                         : config_.floor == FloorStyle::kCarpet ? Material::kCarpet
                                                                : Material::kLino;
  AddRectangle(At(map_.origin + Vector2d(0, h), 0), Vector3d::UnitX(), w, -Vector3d::UnitY(), h,
               floor, 0);
  AddRectangle(At(map_.origin, config_.ceiling_m), Vector3d::UnitX(), w, Vector3d::UnitY(), h,
               Material::kCeiling, 0);
  const auto patch = [&](const Region& r, double z, Material material) {
    AddRectangle({r.x_min, r.y_max, z}, Vector3d::UnitX(), r.x_max - r.x_min, -Vector3d::UnitY(),
                 r.y_max - r.y_min, material, 0);
  };
  for (const Region& region : config_.carpets) patch(region, 0.003, Material::kCarpet);
  for (const Region& region : config_.blank_regions) {
    patch(region, 0.004, Material::kLino);
    AddRectangle({region.x_min, region.y_min, config_.ceiling_m - 0.004}, Vector3d::UnitX(),
                 region.x_max - region.x_min, Vector3d::UnitY(), region.y_max - region.y_min,
                 Material::kBlank, 0);
  }
}

void World::AddLamps() {
  const double step = config_.lamp_spacing_m;
  const int columns = static_cast<int>(map_.width * map_.resolution / step) + 1;
  const int rows = static_cast<int>(map_.height * map_.resolution / step) + 1;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      // The freest place of the grid square, so that narrow rooms get their lamp too.
      Vector2d best = Vector2d::Zero();
      double best_score = 0;
      for (double y = 0.1; y < 1; y += 0.1) {
        for (double x = 0.1; x < 1; x += 0.1) {
          const Vector2d p = map_.origin + step * Vector2d(column + x, row + y);
          if (!Reachable(p)) continue;
          const Eigen::Vector2i cell = map_.CellOf(p);
          const double score = std::min(1.2, 1.0 * clearance_[map_.index(cell.x(), cell.y())]) -
                               0.3 * Vector2d(x - 0.5, y - 0.5).norm();
          if (score > best_score) {
            best_score = score;
            best = p;
          }
        }
      }
      if (best_score < 0.3) continue;
      CounterRng rng(seed_, kLampStream, KeyOf(map_.origin + step * Vector2d(column, row)));
      const double power = rng.Below(12) == 0 ? 0.15 : rng.Uniform(0.75, 1.25);
      lamps_.push_back({At(best, config_.ceiling_m - 0.05), power});
      if (InBlankRegion(best)) continue;
      constexpr double kSize = 0.6;
      Surface& panel =
          AddRectangle(At(best - Vector2d(kSize / 2, kSize / 2), config_.ceiling_m - 0.02),
                       Vector3d::UnitX(), kSize, Vector3d::UnitY(), kSize, Material::kLamp, 0);
      panel.emission = static_cast<float>(3.0 * power);
    }
  }
}

bool World::InSight(const Vector2d& a, const Vector2d& b) const {
  const double length = (b - a).norm();
  const int steps = static_cast<int>(length / (0.7 * map_.resolution)) + 1;
  for (int i = 1; i < steps; ++i) {
    const Eigen::Vector2i cell = map_.CellOf(a + (b - a) * (static_cast<double>(i) / steps));
    if (walls_.Occupied(cell.x(), cell.y())) return false;
  }
  return true;
}

double World::Irradiance(const Vector3d& p, const Vector3d& n,
                         const std::vector<int>& lamps) const {
  double sum = 0;
  for (const int index : lamps) {
    const Lamp& lamp = lamps_[index];
    const Vector3d to_lamp = lamp.position - p;
    const double d2 = to_lamp.squaredNorm();
    const double d = std::sqrt(d2);
    const double cos_surface = n.dot(to_lamp) / d;
    const double cos_lamp = to_lamp.z() / d;
    if (cos_surface <= 0 || cos_lamp <= 0) continue;
    sum += lamp.power * cos_surface * cos_lamp / (d2 + 0.6);
  }
  return sum;
}

void World::BakeLight() {
  constexpr double kLampGain = 2.4;  // a wall 1.5 m from a lamp gets about 1
  constexpr double kBounce = 0.35;   // light from everywhere, where any lamp is near
  for (Surface& s : surfaces_) {
    const bool vertical = std::abs(s.v.z()) > 0.5;
    const double v_step = vertical ? kLightStep / 2 : kLightStep;
    s.light_width = 2 + static_cast<int>(s.u_length / kLightStep);
    s.light_height = 2 + static_cast<int>(s.v_length / v_step);
    s.light_begin = static_cast<int>(light_.size());
    light_.resize(light_.size() + static_cast<size_t>(s.light_width) * s.light_height, 0.0f);
    const Vector3d normal = s.Normal();
    const auto shade = [&](int x, int y, const std::vector<int>& near) {
      const Vector3d p = s.origin + s.u * (s.u_length * x / (s.light_width - 1)) +
                         s.v * (s.v_length * y / (s.light_height - 1));
      double bounce = 0;
      for (const int index : near) {
        bounce += lamps_[index].power / (1 + (lamps_[index].position - p).squaredNorm() / 4);
      }
      // Corners get less of the light that comes from everywhere.
      double open = 1;
      if (vertical) {
        open -= 0.35 * std::exp(-p.z() / 0.12) + 0.2 * std::exp(-(config_.ceiling_m - p.z()) / 0.2);
      } else if (map_.InMap(map_.CellOf(p.head<2>()).x(), map_.CellOf(p.head<2>()).y())) {
        const Eigen::Vector2i cell = map_.CellOf(p.head<2>());
        open -= 0.4 * std::exp(-clearance_[map_.index(cell.x(), cell.y())] / 0.25);
      }
      const double e = open * (kLampGain * Irradiance(p, normal, near) + kBounce * bounce) + 0.02;
      light_[s.light_begin + static_cast<size_t>(y) * s.light_width + x] = static_cast<float>(e);
    };
    const auto near_lamps = [&](const Vector2d& p) {
      std::vector<int> near;
      for (size_t i = 0; i < lamps_.size(); ++i) {
        const Vector2d lamp = lamps_[i].position.head<2>();
        if ((lamp - p).squaredNorm() < kLampReach * kLampReach && InSight(lamp, p)) {
          near.push_back(static_cast<int>(i));
        }
      }
      return near;
    };
    for (int x = 0; x < s.light_width; ++x) {
      const Vector3d top = s.origin + s.u * (s.u_length * x / (s.light_width - 1));
      if (vertical) {
        // The same lamps light a vertical line; look from just before the wall, not from inside.
        // The ends of a wall are looked at from a little further in for the same reason.
        const double inset = std::min(0.12, s.u_length / 2);
        const double along = std::clamp(s.u_length * x / (s.light_width - 1), inset,
                                        std::max(inset, s.u_length - inset));
        const Vector3d eye = s.origin + s.u * along + normal * 1.2 * map_.resolution;
        const std::vector<int> near = near_lamps(eye.head<2>());
        for (int y = 0; y < s.light_height; ++y) shade(x, y, near);
        continue;
      }
      for (int y = 0; y < s.light_height; ++y) {
        const Vector3d p = top + s.v * (s.v_length * y / (s.light_height - 1));
        shade(x, y, near_lamps(p.head<2>()));
      }
    }
  }
}

}  // namespace gw::sim
