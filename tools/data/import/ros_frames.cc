#include "tools/data/import/ros_frames.h"

namespace gw::importer {
namespace {

// Rounding of a sender that computes a fixed transform anew each time.
constexpr double kStill = 1e-4;  // m, rad

}  // namespace

void RosFrames::Add(const RosPose& transform) {
  Link& link = links_[{transform.parent, transform.child}];
  link.parent = transform.parent;
  if (!link.poses.empty() && (link.poses.front().T.inverse() * transform.T).Log().norm() > kStill) {
    link.moved = true;
  }
  link.poses.push_back({transform.utime, transform.T});
  parent_of_.emplace(transform.child, transform.parent);
}

bool RosFrames::Has(const std::string& frame) const {
  if (parent_of_.contains(frame)) return true;
  for (const auto& [child, parent] : parent_of_) {
    if (parent == frame) return true;
  }
  return false;
}

std::map<std::string, SE3> RosFrames::Ancestors(const std::string& frame) const {
  std::map<std::string, SE3> poses = {{frame, SE3()}};
  std::string at = frame;
  SE3 T;  // of `frame` in `at`
  for (auto next = parent_of_.find(at); next != parent_of_.end(); next = parent_of_.find(at)) {
    const Link& link = links_.at({next->second, at});
    if (link.moved) break;
    T = link.poses.front().T * T;
    at = next->second;
    if (!poses.emplace(at, T).second) break;  // a ring, which no tf should have
  }
  return poses;
}

std::optional<SE3> RosFrames::Pose(const std::string& in, const std::string& frame) const {
  const std::map<std::string, SE3> of_frame = Ancestors(frame);
  for (const auto& [ancestor, T_AncestorIn] : Ancestors(in)) {
    const auto common = of_frame.find(ancestor);
    if (common != of_frame.end()) return T_AncestorIn.inverse() * common->second;
  }
  return std::nullopt;
}

const std::vector<StampedPose>& RosFrames::Motion(const std::string& parent,
                                                  const std::string& child) const {
  static const std::vector<StampedPose> none;
  const auto link = links_.find({parent, child});
  return link == links_.end() ? none : link->second.poses;
}

std::vector<std::string> RosFrames::Describe() const {
  std::vector<std::string> lines;
  for (const auto& [names, link] : links_) {
    lines.push_back(names.first + " -> " + names.second + (link.moved ? " (moves)" : ""));
  }
  return lines;
}

}  // namespace gw::importer
