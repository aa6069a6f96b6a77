// A map for other programs. All poses and points are in W.
#pragma once

#include <string>

#include "backend/journal/load.h"
#include "grid/core/floor_image.h"
#include "grid/files/grid_file.h"

namespace gw::tools {

// Pose of the body, with the camera's mounting of the session that made the keyframe.
SE3 BodyPose(const backend::LoadedMap& loaded, const Keyframe& keyframe);

// ASCII PLY: landmarks grey, the keyframes' body positions red, and an edge from each keyframe to
// the one after it in time (of the same session).
std::string PlyText(const backend::LoadedMap& loaded);

// g2o pose graph of the rectified left camera: VERTEX_SE3:QUAT by keyframe id, and EDGE_SE3:QUAT
//  - for each DR increment, with the measured motion and the information alpha * inv(cov) that
//    mapping uses (nominal DR noise of docs/method.md, 1.3; alpha 1 where local BA has not set it),
//  - for each pair with at least min_shared common landmarks, with the motion between the present
//    poses; its information is the number of these landmarks times identity, a weight and not a
//    measured one.
// The rotation part of g2o's error is the vector part of a quaternion, half the angle: information
// in radians is scaled by 4 (2 for the mixed blocks).
std::string G2oText(const backend::LoadedMap& loaded, int min_shared);

struct TumKeyframes {
  std::string text;
  int64_t left_out = 0;  // keyframes at the very time of a newer one: TUM files have one per time
};
// `t tx ty tz qx qy qz qw` of the body, in order of time.
TumKeyframes TumText(const backend::LoadedMap& loaded);

// The floor map: the local grids saved beside the map, where its keyframes are now.
grid::FloorImage FloorOf(const backend::LoadedMap& loaded, grid::GridFile saved);

}  // namespace gw::tools
