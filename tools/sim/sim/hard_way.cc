#include "tools/sim/sim/hard_way.h"

#include <algorithm>
#include <cmath>

namespace gw::sim {
namespace {

constexpr double kStep = 0.1;         // s
constexpr double kWallsWithin = 2.1;  // m from the way, both faces of the walls around it

// Metres driven at every kStep, until `length`.
std::vector<double> WayByTime(const RecordedMotion& motion, double length) {
  std::vector<double> way = {0};
  for (double t = kStep; t <= motion.duration_s() && way.back() < length; t += kStep) {
    way.push_back(way.back() + (motion.At(t).position - motion.At(t - kStep).position).norm());
  }
  return way;
}

Region Around(const RecordedMotion& motion, double begin_s, double end_s) {
  Eigen::AlignedBox2d box;
  for (double t = begin_s; t <= end_s; t += kStep) box.extend(motion.At(t).position);
  return {box.min().x() - kWallsWithin, box.min().y() - kWallsWithin, box.max().x() + kWallsWithin,
          box.max().y() + kWallsWithin};
}

}  // namespace

void MakeWayHard(const RecordedMotion& motion, Scenario* scenario) {
  const RecordedConfig& config = scenario->recorded;
  const std::vector<double> way = WayByTime(motion, config.length_m);
  scenario->max_duration_s =
      std::min(scenario->max_duration_s, static_cast<double>(way.size() - 1) * kStep);
  const auto time_at = [&](double metres) {
    const auto at = std::lower_bound(way.begin(), way.end(), metres);
    return static_cast<double>(at - way.begin()) * kStep;
  };
  const int parts = std::max(1, static_cast<int>(std::lround(way.back() / config.every_m)));
  const double part = way.back() / parts;
  for (int i = 0; i < parts; ++i) {
    if (config.dark_s > 0) {
      Event dark;
      dark.kind = EventKind::kLightsOff;
      dark.at_s = time_at((i + 1.0 / 3) * part);
      dark.for_s = config.dark_s;
      scenario->events.push_back(dark);
    }
    if (config.bare_m > 0) {
      const double begin = (i + 2.0 / 3) * part;
      scenario->world.blank_regions.push_back(
          Around(motion, time_at(begin), time_at(begin + config.bare_m)));
    }
  }
}

}  // namespace gw::sim
