// gw-grid as a node: CAMERA, FRAME_POSE, MAP_UPDATE and DR in, GRID and OBSTACLES out.
//
// The newest image that is due is looked at; OBSTACLES leave at once, whether or not vision
// knows the place. A scan waits for the FRAME_POSE of its image and then becomes part of the floor
// map. MAP_UPDATE is listened to without acknowledging: updates tell whole poses, so that a lost
// one is made up for by the next; at the start gw-grid asks for a snapshot if none comes by itself.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>

#include "common/config/robot_config.h"
#include "common/good_weights/dr_history.h"
#include "common/process/reliable.h"
#include "common/process/shell.h"
#include "grid/core/grid_map.h"
#include "grid/core/look_taker.h"
#include "grid/core/recent_obstacles.h"

namespace gw::grid {

struct GridOptions {
  std::string map;  // folder of the map on disk: the local grids are kept there
  std::string out;  // folder for map.yaml and map.pgm
};

class GridNode : public process::Node {
 public:
  static Result<std::unique_ptr<process::Node>> Create(const RobotConfig& config,
                                                       const GridOptions& options);

  Result<Done> Start(process::Shell& shell) override;
  bool Step(process::Shell& shell) override;
  void Stop(process::Shell& shell) override;

 private:
  struct WaitingImage {
    wire::Bytes message;
    Utime utime, received;
  };
  struct WaitingScan {
    Utime utime;
    FloorScan scan;
  };

  GridNode(const RobotConfig& config, const GridOptions& options, const CameraGeometry& geometry);

  Result<Done> LoadSaved();
  void TakeImage(std::span<const uint8_t> message, Utime received, process::Shell& shell);
  void TakeMapUpdates(std::span<const uint8_t> message, process::Shell& shell);
  void Look(process::Shell& shell);
  void JoinScansAndPoses();
  void RequestMap(process::Shell& shell);
  void PublishGrid(process::Shell& shell);
  void PublishTiles(std::vector<GridTile> tiles, process::Shell& shell);
  void Save(process::Shell& shell);
  void ReportHealth(process::Shell& shell) const;

  GridOptions options_;
  LookTaker looks_;
  GridMap map_;
  RecentObstacles obstacles_;
  DrHistory dr_;
  std::optional<process::ReliableReceiver> updates_;
  std::optional<WaitingImage> image_;
  std::deque<WaitingScan> scans_;  // without a pose yet, oldest first
  std::deque<FramePose> poses_;    // newest images' poses, oldest first
  bool map_known_ = false;         // a snapshot came
  bool image_refused_ = false;     // the newest image is not of the calibrated kind and size
  std::optional<Utime> started_, last_request_, last_image_, last_pose_, last_grid_, last_save_;
  int64_t session_ = 0;  // of the process
  int64_t grid_session_ = 0;
  int64_t request_seq_ = 0, grid_seq_ = 0, obstacle_seq_ = 0;
  int64_t saved_version_ = 0;
  Index2 next_repeat_;  // the tile that is sent again next
  bool save_failed_ = false;
};

}  // namespace gw::grid
