#include "grid/process/grid_node.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "common/camera/camera_model.h"
#include "common/wire/channels.h"
#include "common/wire/grid.h"
#include "grid/core/floor_image.h"
#include "grid/files/grid_file.h"
#include "grid/files/map_server.h"

namespace gw::grid {
namespace {

constexpr DurationUs kGridPeriod = Milliseconds(500);
constexpr DurationUs kSavePeriod = Milliseconds(30000);
constexpr DurationUs kRequestInterval = Milliseconds(1000);
constexpr DurationUs kSilence = Milliseconds(1500);  // camera or front-end called silent
constexpr size_t kMaxWaiting = 32;     // scans and poses: a second at the rate of the camera
constexpr size_t kMaxTilesSent = 200;  // in one message: 200 kB
constexpr size_t kRepeatedTiles = 8;   // in each message: a house of 300 m^2 in 10 s

}  // namespace

GridNode::GridNode(const RobotConfig& config, const GridOptions& options,
                   const CameraGeometry& geometry)
    : options_(options),
      looks_(geometry, config.grid),
      map_(config.grid, geometry.rectified.T_BC, config.navigate.robot_radius_m),
      obstacles_(config.grid, config.navigate.robot_radius_m) {}

Result<std::unique_ptr<process::Node>> GridNode::Create(const RobotConfig& config,
                                                        const GridOptions& options) {
  const auto geometry = MakeCameraGeometry(config.calibration);
  if (!geometry) return geometry.error();
  std::unique_ptr<GridNode> node(new GridNode(config, options, *geometry));
  if (const auto loaded = node->LoadSaved(); !loaded) return loaded.error();
  return std::unique_ptr<process::Node>(std::move(node));
}

Result<Done> GridNode::LoadSaved() {
  if (options_.map.empty()) return Done{};
  auto saved = LoadGrid(options_.map);
  if (!saved && saved.error().code == ErrorCode::kNotFound) return Done{};
  if (!saved) {
    return Error{saved.error().code,
                 saved.error().message + "; move it away to begin a new floor map"};
  }
  if (saved->cell_m != map_.cell_m()) {
    return Error{ErrorCode::kBadConfig,
                 options_.map +
                     ": its grid has other cells than grid.cell_m says; set that back, "
                     "or move the file away to begin a new floor map"};
  }
  map_.Restore(std::move(saved->grids));
  return Done{};
}

Result<Done> GridNode::Start(process::Shell& shell) {
  started_ = shell.Now();
  session_ = grid_session_ = started_->us;
  updates_.emplace(session_);
  Result<Done> ok = shell.ListenRaw(wire::kCamera, [this, &shell](auto bytes, Utime received) {
    TakeImage(bytes, received, shell);
  });
  if (!ok) return ok;
  ok = shell.Listen<FramePose>(wire::kFramePose, [this, &shell](const FramePose& pose, Utime) {
    last_pose_ = shell.Now();
    poses_.push_back(pose);
    if (poses_.size() > kMaxWaiting) poses_.pop_front();
  });
  if (!ok) return ok;
  ok = shell.Listen<DrState>(wire::kDr, [this, &shell](const DrState& state, Utime) {
    if (!dr_.Push(state)) shell.health().Count("DR.not_newer");
  });
  if (!ok) return ok;
  return shell.ListenRaw(wire::kMapUpdate,
                         [this, &shell](auto bytes, Utime) { TakeMapUpdates(bytes, shell); });
}

void GridNode::TakeImage(std::span<const uint8_t> message, Utime received, process::Shell& shell) {
  last_image_ = shell.Now();
  const auto header = wire::ReadHeader(message);
  if (header && !looks_.Due(header->utime)) return;  // most images end here, undecoded
  if (image_) shell.health().Count("CAMERA.dropped");
  image_ =
      WaitingImage{{message.begin(), message.end()}, header ? header->utime : Utime{}, received};
}

void GridNode::TakeMapUpdates(std::span<const uint8_t> message, process::Shell& shell) {
  for (const wire::Bytes& bytes : updates_->Accept(message)) {
    const auto update = wire::Decode<MapUpdate>(bytes);
    if (!update) {
      shell.CountUndecodable(wire::kMapUpdate, update.error());
      continue;
    }
    map_known_ = map_known_ || update->snapshot;
    if (!map_.Apply(*update)) continue;
    shell.health().Count("grid.new_map");
    grid_session_ = std::max(grid_session_ + 1, shell.Now().us);
    scans_.clear();
  }
}

void GridNode::Look(process::Shell& shell) {
  WaitingImage image = *std::exchange(image_, std::nullopt);
  const auto camera = wire::DecodeCamera(std::move(image.message));
  if (!camera) {
    shell.CountUndecodable(wire::kCamera, camera.error());
    return;
  }
  auto scan = looks_.Look(camera->frame, map_.length_factor());
  image_refused_ = !scan;
  if (!scan) {
    shell.health().Count("CAMERA.refused");
    return;
  }
  const Utime utime = camera->frame.utime;
  const auto T_OB = dr_.PoseAt(utime);
  const uint32_t epoch = dr_.empty() ? 0 : dr_.newest().reset_counter;
  ObstacleView view = obstacles_.Push(utime, T_OB, epoch, *scan);
  view.seq = ++obstacle_seq_;
  shell.Publish(wire::kObstacles, wire::Encode(view));
  shell.health().AddLatency(shell.Now() - image.received);
  scans_.push_back({utime, std::move(*scan)});
  if (scans_.size() > kMaxWaiting) scans_.pop_front();
}

void GridNode::JoinScansAndPoses() {
  while (!scans_.empty()) {
    const Utime utime = scans_.front().utime;
    const auto pose = std::find_if(poses_.begin(), poses_.end(),
                                   [utime](const FramePose& p) { return p.utime == utime; });
    if (pose != poses_.end()) {
      map_.Add(*pose, scans_.front().scan);
    } else if (poses_.empty() || poses_.back().utime < utime) {
      return;  // it may still come
    }
    scans_.pop_front();
  }
}

void GridNode::RequestMap(process::Shell& shell) {
  const Utime now = shell.Now();
  const Utime since = last_request_.value_or(*started_);
  if (map_known_ || poses_.empty() || now - since < kRequestInterval) return;
  last_request_ = now;
  MapRequest request;
  request.utime = poses_.back().utime;
  wire::Bytes message = wire::Encode(request);
  ++request_seq_;
  wire::SetDelivery({.seq = request_seq_, .session = session_, .oldest_seq = request_seq_},
                    message);
  shell.Publish(wire::kMapRequest, message);
}

void GridNode::PublishTiles(std::vector<GridTile> tiles, process::Shell& shell) {
  GridUpdate update;
  update.utime = map_.utime();
  update.grid_session = grid_session_;
  update.grid_version = map_.version();
  update.map_revision = map_.map_revision();
  update.cell_m = map_.cell_m();
  for (size_t begin = 0; begin < tiles.size(); begin += kMaxTilesSent) {
    const size_t end = std::min(tiles.size(), begin + kMaxTilesSent);
    update.seq = ++grid_seq_;
    update.tiles.assign(std::make_move_iterator(tiles.begin() + static_cast<ptrdiff_t>(begin)),
                        std::make_move_iterator(tiles.begin() + static_cast<ptrdiff_t>(end)));
    shell.Publish(wire::kGrid, wire::Encode(update));
  }
}

void GridNode::PublishGrid(process::Shell& shell) {
  const Utime now = shell.Now();
  if (last_grid_ && now - *last_grid_ < kGridPeriod) return;
  last_grid_ = now;
  std::map<Index2, GridTile> send;
  for (GridTile& tile : map_.Compose()) send.emplace(Index2{tile.x, tile.y}, tile);
  // All others come again in turn, for those who came late or lost one.
  const auto& all = map_.tiles();
  auto next = all.lower_bound(next_repeat_);
  for (size_t i = 0; i < std::min(kRepeatedTiles, all.size()); ++i) {
    if (next == all.end()) next = all.begin();
    send.emplace(next->first, next->second);
    ++next;
  }
  next_repeat_ = next == all.end() ? Index2{INT32_MIN, INT32_MIN} : next->first;
  std::vector<GridTile> tiles;
  tiles.reserve(send.size());
  for (auto& [index, tile] : send) tiles.push_back(tile);
  PublishTiles(std::move(tiles), shell);
}

void GridNode::Save(process::Shell& shell) {
  last_save_ = shell.Now();
  map_.Compose();
  if (map_.version() == saved_version_ || map_.tiles().empty()) return;
  Result<Done> saved{Done{}};
  if (!options_.map.empty()) saved = SaveGrid(options_.map, {map_.cell_m(), map_.Save()});
  const FloorImage image = MakeFloorImage(map_.tiles(), map_.cell_m());
  if (saved && !options_.out.empty() && image.width > 0) {
    saved = WriteMapServer(options_.out, image);
  }
  save_failed_ = !saved;
  if (saved) {
    saved_version_ = map_.version();
    return;
  }
  shell.health().Count("grid.save_failed");
  shell.log().Write(shell.Now(), process::Severity::kError, "grid.save_failed",
                    {{"what", saved.error().message},
                     {"action", "free space or check the disk; it is tried again"}});
}

void GridNode::ReportHealth(process::Shell& shell) const {
  using enum HealthState;
  const GridMapCounters& c = map_.counters();
  shell.health().SetCounter("grid.scans", c.scans);
  shell.health().SetCounter("grid.blind", c.blind);
  shell.health().SetCounter("grid.uncertain", c.uncertain);
  shell.health().SetCounter("grid.grids_moved", c.grids_moved);
  shell.health().SetCounter("grid.tiles_composed", c.tiles_composed);
  const Utime now = shell.Now();
  const auto silent = [now](const auto& last) { return !last || now - *last > kSilence; };
  if (!last_image_) {
    shell.health().SetState(kStarting, "no images yet: is gw-camera running?");
  } else if (silent(last_image_)) {
    shell.health().SetState(kDegraded, "no images: check gw-camera and its cable");
  } else if (image_refused_) {
    shell.health().SetState(kDegraded,
                            "images are not of the kind and size that calibration.camera says: "
                            "check that all processes use one robot YAML");
  } else if (silent(last_pose_)) {
    shell.health().SetState(
        kDegraded, "images have no pose, obstacles only, no floor map: is gw-frontend running?");
  } else if (save_failed_) {
    shell.health().SetState(kDegraded, "the floor map cannot be saved: free space, check the disk");
  } else {
    shell.health().SetState(kOk);
  }
}

bool GridNode::Step(process::Shell& shell) {
  if (image_) Look(shell);
  JoinScansAndPoses();
  RequestMap(shell);
  PublishGrid(shell);
  const bool keeps = !options_.map.empty() || !options_.out.empty();
  if (keeps && shell.Now() - last_save_.value_or(*started_) >= kSavePeriod) Save(shell);
  ReportHealth(shell);
  return true;
}

void GridNode::Stop(process::Shell& shell) {
  if (!options_.map.empty() || !options_.out.empty()) Save(shell);
}

}  // namespace gw::grid
