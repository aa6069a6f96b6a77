#include "grid/core/recent_obstacles.h"

#include <algorithm>
#include <cmath>

#include "grid/core/scan_evidence.h"

namespace gw::grid {
namespace {

// Five looks at the floor are enough to forget what was there.
constexpr float kMostObstacle = 2 * Cell::kHit;

}  // namespace

ObstacleView RecentObstacles::Push(Utime utime, const std::optional<SE3>& T_OB,
                                   uint32_t odometry_epoch, const FloorScan& scan) {
  if (!T_OB || epoch_ != odometry_epoch) cells_.clear();
  epoch_ = T_OB ? std::optional(odometry_epoch) : std::nullopt;
  const Pose2 T_CellsB = T_OB ? Pose2(*T_OB) : Pose2();
  for (const CellEvidence& e : EvidenceOf(scan, T_CellsB, config_.cell_m, footprint_m_)) {
    const auto known = cells_.find(e.index);
    if (known == cells_.end() && e.cell.log_odds < 0) continue;
    Seen& seen = known != cells_.end() ? known->second : cells_[e.index];
    seen = {std::min(kMostObstacle, seen.log_odds + e.cell.log_odds), utime};
  }
  const DurationUs memory = DurationFromSeconds(config_.memory_s);
  const Pose2 T_BCells = T_CellsB.inverse();
  ObstacleView view;
  view.utime = utime;
  view.cell_m = config_.cell_m;
  view.seen_ahead_m = SeenAhead(scan, footprint_m_);
  for (auto it = cells_.begin(); it != cells_.end();) {
    const Eigen::Vector2d p_B =
        T_BCells * (config_.cell_m * Eigen::Vector2d(it->first.x + 0.5, it->first.y + 0.5));
    const bool gone = it->second.log_odds <= 0 || utime < it->second.utime ||
                      utime - it->second.utime > memory || p_B.norm() > 2 * config_.max_range_m;
    if (gone) {
      it = cells_.erase(it);
      continue;
    }
    view.obstacles.push_back(p_B.cast<float>());
    ++it;
  }
  std::stable_sort(view.obstacles.begin(), view.obstacles.end(),
                   [](const auto& a, const auto& b) { return a.norm() < b.norm(); });
  return view;
}

double SeenAhead(const FloorScan& scan, double half_width_m) {
  double floor = 0, obstacle = scan.max_range + scan.origin.norm();
  for (int bin = 0; bin < scan.num_bearings; ++bin) {
    const Eigen::Vector2d direction(std::cos(scan.bearing(bin)), std::sin(scan.bearing(bin)));
    const auto at = [&](float range) -> Eigen::Vector2d {
      return scan.origin.cast<double>() + direction * static_cast<double>(range);
    };
    for (const FloorScan::Stretch& s : scan.FreeAt(bin)) {
      const Eigen::Vector2d p = at(s.to);
      if (std::abs(p.y()) <= half_width_m) floor = std::max(floor, p.x());
    }
    for (const FloorScan::Hit& hit : scan.HitsAt(bin)) {
      const Eigen::Vector2d p = at(hit.range);
      if (std::abs(p.y()) <= half_width_m && p.x() > 0) obstacle = std::min(obstacle, p.x());
    }
  }
  return std::min(floor, obstacle);
}

}  // namespace gw::grid
