// Depth of the camera's images: measured by an RGB-D camera, or matched between the eyes of a
// stereo pair (semi-global matching: Hirschmueller, "Stereo Processing by Semiglobal Matching and
// Mutual Information", PAMI 2008, as in OpenCV), at a reduced size.
//
// A stereo match counts when both eyes agree on it (left-right check), when it is clearly better
// than the next best (uniqueness), when it is not an island, and when the image has structure
// there. At the edges of things both kinds of camera measure depths between thing and background;
// these are steeper than any surface can be whose plane passes the camera at kNearestPlane, and do
// not count either. What does not count has no depth: unknown, never far away.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "common/camera/camera_model.h"
#include "common/config/grid_config.h"
#include "common/contract/samples.h"

namespace gw::grid {

// Pixels of a depth image and where they look, on a robot that stands level.
struct DepthRays {
  int width = 0, height = 0;         // px, of the reduced image
  Eigen::Vector3f origin;            // camera in B, m
  std::vector<Eigen::Vector3f> ray;  // in B: the point of a pixel is origin + depth * ray
  // Standard deviation of a depth z (m): sigma_per_m2 * z^2.
  double sigma_per_m2 = 0;
};

// m along the optical axis, one a pixel of DepthRays, row by row; 0: not known.
using DepthImage = std::vector<float>;

// m: nearer to a surface than this the robot, whose middle the camera is near, touches it.
inline constexpr double kNearestPlane = 0.2;

// Takes away the depths between a thing and its background. focal_px: of the reduced columns.
// A plane n p = h has 1 / z = n (x, y, 1) / h, which changes by at most 1 / h per unit of x.
void RemoveEdges(int width, double focal_px, DepthImage* depth);

class DepthSource {
 public:
  virtual ~DepthSource() = default;
  const DepthRays& rays() const { return rays_; }
  // False for an image that is not of the calibrated kind and size.
  virtual bool Measure(const CameraFrame& frame, DepthImage* depth) = 0;

 protected:
  DepthRays rays_;
};

std::unique_ptr<DepthSource> MakeDepthSource(const CameraGeometry& geometry,
                                             const GridConfig& config);

}  // namespace gw::grid
