// Where frames are in each other, of tf and tf_static.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tools/data/import/ros_messages.h"
#include "tools/data/import/trajectory.h"

namespace gw::importer {

class RosFrames {
 public:
  // A transform of tf or tf_static.
  void Add(const RosPose& transform);

  bool Has(const std::string& frame) const;
  // Pose of `frame` in `in` along transforms that never changed (by more than 1e-4 m and rad): what
  // is bolted together. Empty where none leads there.
  std::optional<SE3> Pose(const std::string& in, const std::string& frame) const;
  // Poses of child in parent of a single transform, as they were sent, in no order.
  const std::vector<StampedPose>& Motion(const std::string& parent, const std::string& child) const;
  // "parent -> child", those that moved, with a star.
  std::vector<std::string> Describe() const;

 private:
  struct Link {
    std::string parent;
    std::vector<StampedPose> poses;
    bool moved = false;
  };
  // The frames from `frame` to its root, with its pose in each.
  std::map<std::string, SE3> Ancestors(const std::string& frame) const;

  std::map<std::pair<std::string, std::string>, Link> links_;  // parent, child
  std::map<std::string, std::string> parent_of_;
};

}  // namespace gw::importer
