// One depth image, seen from above: for every bearing, where the floor was seen and where something
// stands that the robot would touch.
//
// A point is floor up to step_m above or below it, an obstacle from there to robot_height_m, a hole
// below; tilt_deg raises these limits with the distance. What is higher is not in the way. Floor is
// free only where it was seen: what is known of the space in front of a wall is not enough, a low
// thing without texture may stand there. Standing things are seen in many pixels of one bearing;
// their distance is the median of these, which halves the noise of stereo, and their foot keeps
// what was seen of the floor from reaching into them. Where seen floor ends, it ends three standard
// deviations earlier: the foot of a wall without texture is not seen. What is so far away that its
// place is not known to two cells is not put anywhere, but ends what is free.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "common/config/grid_config.h"
#include "grid/core/depth_source.h"

namespace gw::grid {

struct FloorScan {
  struct Stretch {
    float from = 0, to = 0;  // m from the camera's foot
  };
  struct Hit {
    float range = 0;  // m from the camera's foot
    float sigma = 0;  // m, of one of its pixels
  };

  Eigen::Vector2f origin = Eigen::Vector2f::Zero();  // the camera's foot in B, m
  float first_bearing = 0;                           // rad in B, of the middle of bin 0
  float bearing_step = 0;                            // rad, to the left
  int num_bearings = 0;
  float max_range = 0;
  // Bin b has [begin[b], begin[b + 1]) of the lists.
  std::vector<int> free_begin, hit_begin;
  std::vector<Stretch> free;  // floor that was seen
  std::vector<Hit> hits;      // obstacles and the edges of holes

  std::span<const Stretch> FreeAt(int bin) const {
    return std::span(free).subspan(static_cast<size_t>(free_begin[static_cast<size_t>(bin)]),
                                   Length(free_begin, bin));
  }
  std::span<const Hit> HitsAt(int bin) const {
    return std::span(hits).subspan(static_cast<size_t>(hit_begin[static_cast<size_t>(bin)]),
                                   Length(hit_begin, bin));
  }
  float bearing(int bin) const { return first_bearing + bearing_step * static_cast<float>(bin); }

 private:
  static size_t Length(const std::vector<int>& begin, int bin) {
    return static_cast<size_t>(begin[static_cast<size_t>(bin) + 1] -
                               begin[static_cast<size_t>(bin)]);
  }
};

class FloorScanner {
 public:
  FloorScanner(const DepthRays& rays, const GridConfig& config);

  // Precondition: `depth` has one number for each ray.
  FloorScan Scan(const DepthImage& depth) const;

 private:
  // A pixel as its bearing sees it.
  struct Pixel {
    int index = 0;
    float range_per_depth = 0;   // horizontal way per metre of depth
    float height_per_depth = 0;  // change of height per metre of depth
    float slope() const { return height_per_depth / range_per_depth; }
  };
  struct Point {
    float range = 0, sigma = 0;  // m
  };

  void ScanBearing(std::span<const Pixel> pixels, const DepthImage& depth, FloorScan* scan) const;
  void AddHits(std::vector<Point>* points, size_t least_support, FloorScan* scan) const;
  // Ends each stretch of seen floor three standard deviations of its far end earlier.
  void TrimFree(size_t first_free, FloorScan* scan) const;
  void DropBlurred(size_t first_hit, FloorScan* scan) const;
  void CutFree(size_t first_free, size_t first_hit, FloorScan* scan) const;

  GridConfig config_;
  float camera_height_;
  float sigma_per_m2_;
  float row_slope_;  // change of slope from one row to the next
  FloorScan empty_;
  std::vector<int> pixel_begin_;  // of the bins in pixels_
  std::vector<Pixel> pixels_;     // of each bin from below upwards
};

}  // namespace gw::grid
