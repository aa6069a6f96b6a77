#include "tools/data/map/map_export.h"

#include <Eigen/LU>
#include <cinttypes>
#include <map>

#include "common/good_weights/camera_motion.h"
#include "grid/core/grid_map.h"
#include "tools/data/files/format.h"

namespace gw::tools {
namespace {

std::string PoseColumns(const SE3& T) {
  const Eigen::Vector3d& p = T.translation();
  const Eigen::Quaterniond& q = T.rotation();
  return Format("%.9f %.9f %.9f %.9f %.9f %.9f %.9f", p.x(), p.y(), p.z(), q.x(), q.y(), q.z(),
                q.w());
}

std::string G2oEdge(KeyframeId from, KeyframeId to, const SE3& T_FromTo,
                    const Matrix6d& information) {
  std::string out = Format("EDGE_SE3:QUAT %" PRId64 " %" PRId64 " ", from.value, to.value) +
                    PoseColumns(T_FromTo);
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) {
      const double half_angles = (i < 3 ? 1.0 : 2.0) * (j < 3 ? 1.0 : 2.0);
      out += Format(" %.9g", half_angles * information(i, j));
    }
  }
  return out + "\n";
}

}  // namespace

SE3 BodyPose(const backend::LoadedMap& loaded, const Keyframe& keyframe) {
  SE3 T_BC;
  for (const backend::MapSession& session : loaded.sessions) {
    if (session.first_keyframe <= keyframe.id) T_BC = session.T_BC;
  }
  return keyframe.T_WC * T_BC.inverse();
}

std::string PlyText(const backend::LoadedMap& loaded) {
  const backend::Map& map = loaded.map;
  std::string vertices;
  for (const LandmarkId id : map.SortedLandmarkIds()) {
    const Eigen::Vector3d& p = map.FindLandmark(id)->p_W;
    vertices += Format("%.6f %.6f %.6f 200 200 200\n", p.x(), p.y(), p.z());
  }
  std::map<KeyframeId, size_t> vertex_of;
  size_t next = map.num_landmarks();
  std::string edges;
  size_t num_edges = 0;
  for (const auto& [id, keyframe] : map.keyframes()) {
    const Eigen::Vector3d p = BodyPose(loaded, keyframe.frame).translation();
    vertices += Format("%.6f %.6f %.6f 220 40 40\n", p.x(), p.y(), p.z());
    vertex_of[id] = next++;
    const auto previous = vertex_of.find(keyframe.frame.previous);
    if (previous == vertex_of.end()) continue;
    edges += Format("%zu %zu\n", previous->second, vertex_of[id]);
    ++num_edges;
  }
  return Format(
             "ply\nformat ascii 1.0\ncomment landmarks grey, keyframes red; metres\n"
             "element vertex %zu\nproperty float x\nproperty float y\nproperty float z\n"
             "property uchar red\nproperty uchar green\nproperty uchar blue\n"
             "element edge %zu\nproperty int vertex1\nproperty int vertex2\nend_header\n",
             next, num_edges) +
         vertices + edges;
}

std::string G2oText(const backend::LoadedMap& loaded, int min_shared) {
  const backend::Map& map = loaded.map;
  std::string out;
  for (const auto& [id, keyframe] : map.keyframes()) {
    out +=
        Format("VERTEX_SE3:QUAT %" PRId64 " ", id.value) + PoseColumns(keyframe.frame.T_WC) + "\n";
  }
  for (const auto& [id, keyframe] : map.keyframes()) {
    const Keyframe& f = keyframe.frame;
    if (f.dr && map.FindKeyframe(f.previous) != nullptr) {
      const SE3 T_BC = BodyPose(loaded, f).inverse() * f.T_WC;
      const DrMotion motion = CameraMotion(*f.dr, T_BC, DrWeightConfig());
      const double alpha = keyframe.dr_alpha > 0 ? keyframe.dr_alpha : 1.0;
      out += G2oEdge(f.previous, id, motion.T_CaCb, alpha * motion.cov.inverse());
    }
    for (const auto& [other, shared] : keyframe.covisible) {
      if (other >= id || shared < min_shared) continue;
      const SE3 T_OtherThis = map.FindKeyframe(other)->frame.T_WC.inverse() * f.T_WC;
      out += G2oEdge(other, id, T_OtherThis, shared * Matrix6d::Identity());
    }
  }
  return out;
}

TumKeyframes TumText(const backend::LoadedMap& loaded) {
  TumKeyframes out;
  std::map<Utime, SE3> by_time;
  for (const auto& [id, keyframe] : loaded.map.keyframes()) {
    const bool first = by_time.count(keyframe.frame.utime) == 0;
    by_time[keyframe.frame.utime] = BodyPose(loaded, keyframe.frame);
    if (!first) ++out.left_out;
  }
  for (const auto& [utime, T_WB] : by_time) {
    out.text += Format("%.6f ", utime.seconds()) + PoseColumns(T_WB) + "\n";
  }
  return out;
}

grid::FloorImage FloorOf(const backend::LoadedMap& loaded, grid::GridFile saved) {
  // Poses are told as those of bodies, each with the mounting of its own session.
  MapUpdate bodies;
  for (const auto& [id, keyframe] : loaded.map.keyframes()) {
    bodies.keyframes.push_back({id, keyframe.frame.utime, BodyPose(loaded, keyframe.frame)});
  }
  SE3 T_BC;
  if (!loaded.sessions.empty()) T_BC = loaded.sessions.back().T_BC;
  for (const grid::GridMap::SavedGrid& piece : saved.grids) {
    if (auto removal = loaded.map.FindRemoval(piece.keyframe)) {
      removal->T_ParentC = T_BC * removal->T_ParentC * T_BC.inverse();
      bodies.removed_keyframes.push_back(*removal);
    }
  }
  GridConfig config;
  config.cell_m = saved.cell_m;
  grid::GridMap map(config, SE3(), 0);
  map.Restore(std::move(saved.grids));
  map.Apply(bodies);
  map.Compose();
  return grid::MakeFloorImage(map.tiles(), map.cell_m());
}

}  // namespace gw::tools
