#include "tools/data/import/ros_wheels.h"

#include <algorithm>
#include <cctype>
#include <optional>

namespace gw::importer {
namespace {

std::optional<size_t> FindJoint(const std::vector<std::string>& names, const std::string& side) {
  std::optional<size_t> found;
  for (size_t i = 0; i < names.size(); ++i) {
    std::string name = names[i];
    std::transform(name.begin(), name.end(), name.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (name.find(side) == std::string::npos) continue;
    const bool wheel = name.find("wheel") != std::string::npos;
    if (wheel) return i;
    if (!found) found = i;
  }
  return found;
}

}  // namespace

std::optional<WheelJoints> FindWheelJoints(const RosJoints& joints) {
  if (joints.positions.empty()) return std::nullopt;
  const std::optional<size_t> left = FindJoint(joints.names, "left");
  const std::optional<size_t> right = FindJoint(joints.names, "right");
  if (!left || !right || *left == *right) return std::nullopt;
  return WheelJoints{*left, *right};
}

std::vector<WheelSample> WheelsFromAngles(const std::vector<WheelAngles>& angles, double radius_m,
                                          double track_m) {
  std::vector<WheelSample> wheels;
  for (size_t i = 1; i < angles.size(); ++i) {
    const WheelAngles& a = angles[i - 1];
    const WheelAngles& b = angles[i];
    WheelSample sample;
    sample.utime_begin = a.utime;
    sample.utime = b.utime;
    SetArc(radius_m * (b.left_rad - a.left_rad), radius_m * (b.right_rad - a.right_rad), track_m,
           sample);
    wheels.push_back(sample);
  }
  return wheels;
}

std::vector<WheelSample> WheelsFromTicks(const std::vector<RosTicks>& ticks,
                                         const EncoderBase& base) {
  std::vector<WheelSample> wheels;
  const auto way_m = [&](uint16_t from, uint16_t to) {
    return static_cast<int16_t>(static_cast<uint16_t>(to - from)) / base.ticks_per_metre;
  };
  for (size_t i = 1; i < ticks.size(); ++i) {
    const RosTicks& a = ticks[i - 1];
    const RosTicks& b = ticks[i];
    WheelSample sample;
    sample.utime_begin = a.utime;
    sample.utime = b.utime;
    sample.has_ticks = true;
    sample.left_ticks = b.left;
    sample.right_ticks = b.right;
    sample.contact = b.contact;
    SetArc(way_m(a.left, b.left), way_m(a.right, b.right), base.track_m, sample);
    wheels.push_back(sample);
  }
  return wheels;
}

}  // namespace gw::importer
