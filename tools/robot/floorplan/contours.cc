#include "tools/robot/floorplan/contours.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>

namespace gw::floorplan {
namespace {

// Directions of edges between cells, counter-clockwise.
constexpr std::array<int, 4> kDx = {1, 0, -1, 0};
constexpr std::array<int, 4> kDy = {0, 1, 0, -1};

constexpr double kSmallShare = 0.1;  // tolerance of small outlines, of their size

double DistanceToSegment(const Eigen::Vector2d& p, const Eigen::Vector2d& a,
                         const Eigen::Vector2d& b) {
  const Eigen::Vector2d ab = b - a;
  const double length2 = ab.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(ab) / length2, 0.0, 1.0) : 0.0;
  return (p - a - t * ab).norm();
}

// Marks the vertices of [first, last] to keep; both ends are kept already.
void DouglasPeucker(const std::vector<Eigen::Vector2d>& points, size_t first, size_t last,
                    double tolerance, std::vector<uint8_t>* keep) {
  double worst = tolerance;
  size_t split = 0;
  for (size_t i = first + 1; i < last; ++i) {
    const double d = DistanceToSegment(points[i], points[first], points[last]);
    if (d > worst) {
      worst = d;
      split = i;
    }
  }
  if (split == 0) return;
  (*keep)[split] = 1;
  DouglasPeucker(points, first, split, tolerance, keep);
  DouglasPeucker(points, split, last, tolerance, keep);
}

// `loop` closed; starts the simplification at an extreme vertex, which is a true corner.
Contour Simplify(std::vector<Eigen::Vector2d> loop, double tolerance) {
  Eigen::AlignedBox2d bounds;
  for (const Eigen::Vector2d& p : loop) bounds.extend(p);
  // Small things would lose their shape.
  tolerance = std::min(tolerance, kSmallShare * bounds.sizes().maxCoeff());
  const auto corner = std::min_element(loop.begin(), loop.end(), [](const auto& a, const auto& b) {
    return a.x() + 1.001 * a.y() < b.x() + 1.001 * b.y();
  });
  std::rotate(loop.begin(), corner, loop.end());
  size_t far = 0;
  for (size_t i = 0; i < loop.size(); ++i) {
    if ((loop[i] - loop[0]).squaredNorm() > (loop[far] - loop[0]).squaredNorm()) far = i;
  }
  loop.push_back(loop[0]);
  std::vector<uint8_t> keep(loop.size(), 0);
  keep[0] = keep[far] = 1;
  DouglasPeucker(loop, 0, far, tolerance, &keep);
  DouglasPeucker(loop, far, loop.size() - 1, tolerance, &keep);
  Contour out;
  for (size_t i = 0; i + 1 < loop.size(); ++i) {
    if (keep[i] != 0) out.vertices.push_back(loop[i]);
  }
  return out;
}

}  // namespace

std::vector<Contour> TraceContours(const FloorMap& map, double tolerance) {
  // Edges between an occupied and a free cell leave the grid vertex (x, y) in direction d, with the
  // occupied cell on the left.
  const int vertex_width = map.width + 1;
  const auto has_edge = [&map](int x, int y, int d) {
    // Cells left and right of the edge.
    constexpr std::array<std::array<int, 4>, 4> kSides = {
        {{0, 0, 0, -1}, {-1, 0, 0, 0}, {-1, -1, -1, 0}, {0, -1, -1, -1}}};
    const auto& s = kSides[d];
    return map.Occupied(x + s[0], y + s[1]) && !map.Occupied(x + s[2], y + s[3]);
  };
  std::vector<uint8_t> done(static_cast<size_t>(vertex_width) * (map.height + 1), 0);  // bit per d
  std::vector<Contour> out;
  for (int y0 = 0; y0 <= map.height; ++y0) {
    for (int x0 = 0; x0 <= map.width; ++x0) {
      for (int d0 = 0; d0 < 4; ++d0) {
        if (!has_edge(x0, y0, d0) || (done[y0 * vertex_width + x0] & (1 << d0)) != 0) continue;
        std::vector<Eigen::Vector2d> loop;
        int x = x0, y = y0, d = d0;
        do {
          done[y * vertex_width + x] |= static_cast<uint8_t>(1 << d);
          loop.emplace_back(map.origin + map.resolution * Eigen::Vector2d(x, y));
          x += kDx[d];
          y += kDy[d];
          // Right first: crosses to the cell that touches at the corner only.
          for (const int turn : {3, 0, 1}) {
            const int next = (d + turn) % 4;
            if (has_edge(x, y, next)) {
              d = next;
              break;
            }
          }
        } while (x != x0 || y != y0 || d != d0);
        out.push_back(Simplify(std::move(loop), tolerance));
      }
    }
  }
  return out;
}

}  // namespace gw::floorplan
