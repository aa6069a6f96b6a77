// A small world for tests of the back-end: points on the walls of a room, a robot that drives
// through it with an RGB-D camera and wheel odometry, and a stand-in for the front-end that knows
// which feature shows which point.
//
// Everything follows from the seed; keyframe k is the same whatever was asked before.
#pragma once

#include <map>
#include <vector>

#include "backend/core/map/map.h"
#include "common/camera/camera_model.h"
#include "common/core/random.h"

namespace gw::backend {

RectifiedCamera TestCamera();

struct WorldOptions {
  uint64_t seed = 1;
  int num_points = 3000;
  double pixel_sigma = 0.7;        // at level 0; grows with the level's scale
  double depth_share = 0.8;        // of the features that have depth
  double outlier_share = 0.0;      // of the associations that name a wrong landmark
  double association_share = 1.0;  // of the features of known points that name their landmark
  double pose_sigma_m = 0.01;      // error of the tracked pose
  double pose_sigma_rad = 0.005;
  double dr_sigma_m = 0.002;  // error of DR from keyframe to keyframe
  double dr_sigma_rad = 0.001;
  double half_x = 4, half_y = 3, height = 2.5;  // m; the room
  double radius = 1.5;                          // m; the robot drives on a circle, looking ahead
  int keyframes_per_lap = 40;
  // Landmarks that a tracker still knows: seen within so many keyframes; 0: all of them. Where it
  // is limited the robot does not recognise places by itself, and tracked poses hang on the
  // previous keyframe's, with their errors: drift.
  int memory_keyframes = 0;
};

class World {
 public:
  explicit World(const WorldOptions& options);

  const WorldOptions& options() const { return options_; }
  SE3 TruePose(int k) const;
  const Eigen::Vector3d& point(int i) const { return points_[i].p_W; }

  // The k-th keyframe (id k + 1), as a front-end would send it that tracks in `map`. `blind`: the
  // image shows nothing, and the pose is DR's from the newest keyframe of the map.
  Keyframe Make(int k, const Map& map, bool blind = false);

  // Index of the point that feature i of a keyframe made here shows.
  int PointOf(KeyframeId keyframe, int feature) const { return shown_.at(keyframe)[feature]; }

  // Motion of the body from keyframe k - 1 to k as DR measures it.
  DrIncrement Dr(int k) const;

 private:
  struct Point {
    Eigen::Vector3d p_W;
    Eigen::Vector3d normal_W;  // of the wall, into the room
    double size = 1;           // distance at which it shows at level 0
    Descriptor descriptor;
  };
  WorldOptions options_;
  std::vector<Point> points_;
  std::map<KeyframeId, std::vector<int>> shown_;
  std::map<int, LandmarkId> landmark_of_point_;  // as first created
};

// For maps as bundle adjustment leaves them: little noise, 40 keyframes in a lap. The same room for
// all radii; another one for another seed.
World SettledWorld(double radius, uint64_t seed = 1);

// The map after so many keyframes of a world, each with the local BA that it calls for.
Map DrivenMap(const WorldOptions& options, int keyframes);

// Root mean square distance between the estimated and the true camera positions (m), in the frame
// of the map's first keyframe, which the world makes without error.
double PositionRmse(const World& world, const Map& map);

}  // namespace gw::backend
