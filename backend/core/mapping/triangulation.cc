#include "backend/core/mapping/triangulation.h"

#include <algorithm>
#include <cmath>

#include "backend/core/mapping/landmark_state.h"
#include "backend/core/mapping/matching.h"
#include "common/core/chi_square.h"
#include "common/core/median.h"

namespace gw::backend {
namespace {

constexpr size_t kNeighbours = 10;
constexpr double kMaxCosParallax = 0.9998;
constexpr double kScaleSlack = 1.5;  // times scale_factor: distances against pyramid levels
constexpr double kEpipolarChi2 = kChi2One95;
constexpr double kNearestShare = 0.3;  // of the median depth: nearer points are not searched for
constexpr double kFarDepth = 100;      // m; stands for infinity on an epipolar segment
constexpr double kStep = 20;           // px between look-ups along a segment

Eigen::Vector3d Ray(const RectifiedCamera& camera, const Feature& f) {
  return camera.Unproject(f.u, f.v, 1.0);
}

// Cosine of the angle under which the (virtual) stereo pair sees the feature's depth.
double StereoCos(const RectifiedCamera& camera, const Feature& f) {
  if (!f.has_depth()) return 1.0;
  return std::cos(2.0 * std::atan2(0.5 * camera.baseline_m, f.depth));
}

bool Fits(const MappingContext& context, const PosedFeature& view, const Eigen::Vector3d& p_W) {
  const Eigen::Vector3d p_C = view.T_CW * p_W;
  if (!(p_C.z() > kMinProjectionDepth)) return false;
  return FitOf(context.camera, PixelOf(view.feature, context.pyramid), p_C).pixel_ok();
}

// Depth of the midpoint between the closest points of both rays: least squares of
// a * ray_a - b * ray_b = baseline. Rays in W, not normalised.
std::optional<Eigen::Vector3d> CrossRays(const PosedFeature& a, const PosedFeature& b,
                                         const Eigen::Vector3d& ray_a,
                                         const Eigen::Vector3d& ray_b) {
  const Eigen::Vector3d baseline = b.T_WC.translation() - a.T_WC.translation();
  const double aa = ray_a.squaredNorm();
  const double bb = ray_b.squaredNorm();
  const double ab = ray_a.dot(ray_b);
  const double det = aa * bb - ab * ab;
  if (!(det > 1e-12 * aa * bb)) return std::nullopt;
  const double da = (bb * ray_a.dot(baseline) - ab * ray_b.dot(baseline)) / det;
  const double db = (ab * ray_a.dot(baseline) - aa * ray_b.dot(baseline)) / det;
  if (da <= 0 || db <= 0) return std::nullopt;
  return 0.5 * (a.T_WC.translation() + da * ray_a + b.T_WC.translation() + db * ray_b);
}

// Features of `keyframe` without landmark close to the segment where a ray of the newest appears.
class SegmentSearch {
 public:
  explicit SegmentSearch(const MapKeyframe& keyframe)
      : keyframe_(keyframe), stamp_(keyframe.frame.features.size(), -1) {}

  const std::vector<int>& Find(int query, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                               double radius) {
    found_.clear();
    const int steps = static_cast<int>(std::min(100.0, std::ceil((to - from).norm() / kStep)));
    for (int i = 0; i <= steps; ++i) {
      const Eigen::Vector2d uv = steps == 0 ? from : from + (to - from) * i / steps;
      keyframe_.grid.ForEachNear(
          static_cast<float>(uv.x()), static_cast<float>(uv.y()),
          static_cast<float>(0.5 * kStep + radius), [&](int index) {
            if (stamp_[index] == query || keyframe_.frame.landmarks[index].valid()) {
              return;
            }
            stamp_[index] = query;
            found_.push_back(index);
          });
    }
    return found_;
  }

 private:
  const MapKeyframe& keyframe_;
  std::vector<int> stamp_;  // last query that has seen the feature
  std::vector<int> found_;
};

double MedianDepth(const Map& map, const MapKeyframe& keyframe) {
  const SE3 T_CW = keyframe.frame.T_WC.inverse();
  std::vector<double> depths;
  for (const LandmarkId id : keyframe.frame.landmarks) {
    if (id.valid()) depths.push_back((T_CW * map.FindLandmark(id)->p_W).z());
  }
  return depths.empty() ? 0 : MedianOf(&depths);
}

// Squared distance of a pixel to the line through two others; to the point when they coincide.
double SquaredDistanceToLine(const Eigen::Vector2d& p, const Eigen::Vector2d& a,
                             const Eigen::Vector2d& b) {
  const Eigen::Vector2d along = b - a;
  const double length2 = along.squaredNorm();
  const Eigen::Vector2d d = p - a;
  if (length2 < 1e-6) return d.squaredNorm();
  const double cross = along.x() * d.y() - along.y() * d.x();
  return cross * cross / length2;
}

}  // namespace

std::optional<Eigen::Vector3d> Triangulate(const MappingContext& context, const PosedFeature& a,
                                           const PosedFeature& b) {
  const RectifiedCamera& camera = context.camera;
  const Eigen::Vector3d ray_a = a.T_WC.rotation() * Ray(camera, a.feature);
  const Eigen::Vector3d ray_b = b.T_WC.rotation() * Ray(camera, b.feature);
  const double cos_rays = ray_a.dot(ray_b) / (ray_a.norm() * ray_b.norm());
  const double cos_a = StereoCos(camera, a.feature);
  const double cos_b = StereoCos(camera, b.feature);

  std::optional<Eigen::Vector3d> p_W;
  if (cos_rays <= std::min(cos_a, cos_b)) {
    const bool enough =
        cos_rays < kMaxCosParallax || a.feature.has_depth() || b.feature.has_depth();
    if (cos_rays > 0 && enough) p_W = CrossRays(a, b, ray_a, ray_b);
  } else {
    const PosedFeature& better = cos_a <= cos_b ? a : b;
    const Feature& f = better.feature;
    p_W = better.T_WC * camera.Unproject(f.u, f.v, f.depth);
  }
  if (!p_W || !Fits(context, a, *p_W) || !Fits(context, b, *p_W)) return std::nullopt;

  const double distance_a = (*p_W - a.T_WC.translation()).norm();
  const double distance_b = (*p_W - b.T_WC.translation()).norm();
  const double by_distance = distance_b / distance_a;
  const double by_level =
      context.pyramid.Scale(a.feature.level) / context.pyramid.Scale(b.feature.level);
  const double slack = kScaleSlack * context.pyramid.factor();
  if (by_distance * slack < by_level || by_distance > by_level * slack) return std::nullopt;
  return p_W;
}

int TriangulateNewLandmarks(Map& map, const MappingContext& context) {
  const RectifiedCamera& camera = context.camera;
  const MapKeyframe& newest = *map.FindKeyframe(map.newest_keyframe());
  const double near_depth = kNearestShare * MedianDepth(map, newest);
  if (!(near_depth > 0)) return 0;
  const SE3 T_WC = newest.frame.T_WC;
  const SE3 T_CW = T_WC.inverse();
  int created = 0;
  auto neighbours = map.Neighbours(newest.frame.id, 1);
  if (neighbours.size() > kNeighbours) neighbours.resize(kNeighbours);
  for (const auto& [neighbour_id, shared] : neighbours) {
    const MapKeyframe& neighbour = *map.FindKeyframe(neighbour_id);
    const SE3 T_WN = neighbour.frame.T_WC;
    const SE3 T_NW = T_WN.inverse();
    const SE3 T_NC = T_NW * T_WC;
    // Closer views than a stereo pair add nothing to a feature, with depth or without.
    if (T_NC.translation().norm() < camera.baseline_m) continue;
    SegmentSearch search(neighbour);
    for (size_t i = 0; i < newest.frame.features.size(); ++i) {
      if (newest.frame.landmarks[i].valid()) continue;
      const LandmarkId id = LandmarkId::From(newest.frame.id, static_cast<int>(i));
      if (map.FindLandmark(id) != nullptr) continue;
      const Feature& f = newest.frame.features[i];
      const double sigma = context.pyramid.Scale(f.level);
      double nearest = near_depth;
      double farthest = kFarDepth;
      if (f.has_depth()) {  // three sigma of its disparity either way
        const double disparity = camera.bf() / f.depth;
        const double reach = 3 * DisparitySigma(camera, context.pyramid, f.level, disparity);
        nearest = camera.bf() / (disparity + reach);
        if (disparity > reach) farthest = camera.bf() / (disparity - reach);
      }
      const Eigen::Vector3d near_N = T_NC * camera.Unproject(f.u, f.v, nearest);
      const Eigen::Vector3d far_N = T_NC * camera.Unproject(f.u, f.v, farthest);
      if (near_N.z() < kMinProjectionDepth || far_N.z() < kMinProjectionDepth) continue;
      const Eigen::Vector2d from = camera.Project(near_N);
      const Eigen::Vector2d to = camera.Project(far_N);

      int best = -1;
      int best_distance = kMatchHamming + 1;
      for (const int candidate : search.Find(static_cast<int>(i), from, to, 2 * sigma)) {
        const Feature& g = neighbour.frame.features[candidate];
        const double sigma_g = context.pyramid.Scale(g.level);
        if (SquaredDistanceToLine({g.u, g.v}, from, to) > kEpipolarChi2 * sigma_g * sigma_g) {
          continue;
        }
        const int distance =
            HammingDistance(newest.frame.descriptors[i], neighbour.frame.descriptors[candidate]);
        if (distance < best_distance) {
          best_distance = distance;
          best = candidate;
        }
      }
      if (best < 0) continue;
      const auto p_W =
          Triangulate(context, {T_WC, T_CW, f}, {T_WN, T_NW, neighbour.frame.features[best]});
      if (!p_W) continue;
      map.AddLandmark(id).p_W = *p_W;
      map.AddObservation(id, {newest.frame.id, static_cast<int32_t>(i)});
      map.AddObservation(id, {neighbour_id, best});
      RefreshGeometry(map, context, id);
      RefreshDescriptor(map, id);
      ++created;
    }
  }
  return created;
}

}  // namespace gw::backend
