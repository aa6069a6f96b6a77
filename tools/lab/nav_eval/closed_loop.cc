#include "tools/lab/nav_eval/closed_loop.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "tools/lab/eval/align.h"
#include "tools/robot/floorplan/pursuit.h"

namespace gw::navigate {
namespace {

using Eigen::Vector2d;
using floorplan::Leg;
using floorplan::Waypoint;

constexpr DurationUs kMaxGap = Milliseconds(100);  // of the truth, to interpolate over
constexpr DurationUs kMaxDiff = Milliseconds(50);  // to its nearest sample; TaskSLAM-Bench

Waypoint Planar(const SE3& T) {
  const Eigen::Vector3d ahead = T.rotation() * Eigen::Vector3d::UnitX();
  return {T.translation().head<2>(), std::atan2(ahead.y(), ahead.x())};
}

// Calls read(fields) for every line after the header, with commas as spaces.
template <typename ReadLine>
Result<Done> ReadCsv(const std::string& path, ReadLine&& read) {
  std::ifstream in(path);
  if (!in)
    return Error{ErrorCode::kNotFound, path + ": cannot open; gw-navigate --record makes it"};
  std::string line;
  std::getline(in, line);
  for (int number = 2; std::getline(in, line); ++number) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream fields(line);
    if (!read(fields)) {
      return Error{ErrorCode::kBadData,
                   path + ":" + std::to_string(number) + ": not a line of this record"};
    }
  }
  return Done{};
}

double DistanceToSegment(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  const Vector2d d = b - a;
  const double length2 = d.squaredNorm();
  const double along = length2 > 0 ? std::clamp(d.dot(p - a) / length2, 0.0, 1.0) : 0.0;
  return (a + along * d - p).norm();
}

double DistanceToLegs(const Vector2d& p, const std::vector<Leg>& legs) {
  double nearest = INFINITY;
  for (const Leg& leg : legs) {
    for (size_t i = 1; i < leg.size(); ++i) {
      nearest = std::min(nearest, DistanceToSegment(p, leg[i - 1], leg[i]));
    }
  }
  return nearest;
}

struct Spread {
  double m = 0, rad = 0;
};

// Mean distance to the mean.
Spread SpreadOf(const std::vector<Waypoint>& stops) {
  Vector2d mean = Vector2d::Zero(), heading = Vector2d::Zero();
  for (const Waypoint& s : stops) {
    mean += s.position / static_cast<double>(stops.size());
    heading += Vector2d(std::cos(s.yaw), std::sin(s.yaw));
  }
  const double mean_yaw = std::atan2(heading.y(), heading.x());
  Spread spread;
  for (const Waypoint& s : stops) {
    spread.m += (s.position - mean).norm() / static_cast<double>(stops.size());
    spread.rad += std::abs(floorplan::AngleTo(mean_yaw, s.yaw)) / static_cast<double>(stops.size());
  }
  return spread;
}

void MeasureStops(const TourRecord& record, const eval::Trajectory& truth, ClosedLoop* out) {
  std::map<int, std::vector<Waypoint>> stood;  // by waypoint
  for (const StopRecord& stop : record.stops) {
    ++out->stops;
    if (!stop.reached) continue;
    const auto pairs = eval::Associate(truth, {{stop.utime, SE3()}}, kMaxGap, kMaxDiff);
    if (pairs.empty()) continue;
    ++out->reached;
    const Waypoint at = Planar(pairs.front().T_ref);
    stood[stop.waypoint].push_back(at);
    out->accuracy_m += (at.position - stop.place.position).norm();
    out->accuracy_rad += std::abs(floorplan::AngleTo(at.yaw, stop.place.yaw));
  }
  if (out->reached > 0) {
    out->accuracy_m /= out->reached;
    out->accuracy_rad /= out->reached;
  }
  for (const auto& [waypoint, stops] : stood) {
    if (stops.size() < 2) continue;
    ++out->precision_waypoints;
    const Spread spread = SpreadOf(stops);
    out->precision_m += spread.m;
    out->precision_rad += spread.rad;
  }
  if (out->precision_waypoints > 0) {
    out->precision_m /= out->precision_waypoints;
    out->precision_rad /= out->precision_waypoints;
  }
}

}  // namespace

Result<TourRecord> ReadTourRecord(const std::string& folder) {
  TourRecord record;
  auto read = ReadCsv(folder + "/stops.csv", [&record](std::istream& in) {
    StopRecord s;
    std::string status;
    in >> s.utime.us >> s.stop >> s.waypoint >> status >> s.place.position.x() >>
        s.place.position.y() >> s.place.yaw;
    s.reached = status == "reached";
    record.stops.push_back(s);
    return !in.fail() && (s.reached || status == "unreachable");
  });
  if (!read) return read.error();
  int last_stop = -1;
  read = ReadCsv(folder + "/plan.csv", [&](std::istream& in) {
    int stop = 0;
    Vector2d p;
    in >> stop >> p.x() >> p.y();
    auto& legs = record.legs[stop];
    // A new way to the same stop begins far from where the last one ended.
    const bool goes_on = stop == last_stop && !legs.empty() &&
                         (legs.back().back() - p).norm() < 2 * floorplan::kLegSpacing;
    if (!goes_on) legs.emplace_back();
    legs.back().push_back(p);
    last_stop = stop;
    return !in.fail();
  });
  if (!read) return read.error();
  auto poses = eval::ReadTum(folder + "/pose.tum");
  if (!poses) return poses.error();
  record.poses = *std::move(poses);
  return record;
}

Result<ClosedLoop> Evaluate(const TourRecord& record, const eval::Trajectory& truth) {
  const auto pairs = eval::Associate(truth, record.poses, kMaxGap, kMaxDiff);
  if (pairs.empty()) {
    return Error{ErrorCode::kBadData, "the poses of the tour and the truth share no time"};
  }
  ClosedLoop out;
  MeasureStops(record, truth, &out);
  double est2 = 0, nav2 = 0;
  int planned = 0;
  size_t next = 0;  // stop
  for (const eval::PosePair& pair : pairs) {
    const Vector2d p = Planar(pair.T_ref).position;
    est2 += (p - Planar(pair.T_est).position).squaredNorm();
    while (next < record.stops.size() && record.stops[next].utime < pair.utime) ++next;
    const auto legs = record.legs.find(static_cast<int>(next));
    if (legs == record.legs.end()) continue;
    const double off = DistanceToLegs(p, legs->second);
    if (!std::isfinite(off)) continue;
    nav2 += off * off;
    ++planned;
  }
  out.est_rmse_m = std::sqrt(est2 / static_cast<double>(pairs.size()));
  out.nav_rmse_m = planned > 0 ? std::sqrt(nav2 / planned) : 0;
  return out;
}

}  // namespace gw::navigate
