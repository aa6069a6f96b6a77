// The whole system and a simulated robot in one process, in lockstep: the simulator's messages go
// to the stages of gw-slam, to the composer and glide of POSE and to the eyes of gw-grid; what they
// say goes to the driver (a tour or exploration), whose command goes back to the simulator. No
// clock: the same scenario gives the same drive, however busy the machine is. What it leaves out of
// the live system is the time that tracking an image and matching a stereo pair take (10 to 30 ms
// each).
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "backend/core/map/map.h"
#include "common/good_weights/dr_history.h"
#include "dr_ekf/core/pose_composer.h"
#include "dr_ekf/pose/pose_glide.h"
#include "grid/core/grid_map.h"
#include "grid/core/look_taker.h"
#include "grid/core/recent_obstacles.h"
#include "tools/lab/slam/slam_session.h"
#include "tools/robot/navigate/driver.h"
#include "tools/sim/closed_loop/pose_steps.h"
#include "tools/sim/sim/simulation.h"

namespace gw::sim {

struct ClosedLoopOptions {
  bool truth = false;     // drive on the true pose
  bool obstacles = true;  // show the driver what stands in the way
  dr_ekf::GlideRates rates;
};

// The bumper began to be pressed. In the frame of the driver's map.
struct Contact {
  double seconds = 0;  // since the begin
  navigate::RobotPose truth;
  double pose_error_m = 0;  // of the pose that it drove on
};

// What a drive was like.
struct DriveReport {
  double seconds = 0;
  int reached = 0, stops = 0;
  std::vector<Contact> contacts;
  int blocked = 0, held = 0;
  double way_m = 0;
  double blind_s = 0, blind_way_m = 0;  // while it moved, and saw no floor ahead
  double seeing_s = 0, seeing_way_m = 0;
  bool finished = false;
};

class ClosedLoop {
 public:
  // T_MG: the frame of the simulator's truth in that of the driver's map; T_MW: the world of
  // POSE. `sim` is of Drive::kExternal.
  static Result<std::unique_ptr<ClosedLoop>> Create(std::unique_ptr<Simulation> sim,
                                                    const RobotConfig& config,
                                                    tools::MapStart start,
                                                    std::unique_ptr<navigate::Driver> driver,
                                                    const SE3& T_MG, const SE3& T_MW,
                                                    const ClosedLoopOptions& options);

  // Until the tour is finished, the scenario's time is over, or goes_on, which is asked every
  // simulated second, says no.
  void Run(const std::function<bool(double seconds)>& goes_on);

  // Called with every pose that the driver gets, the truth in its map, and what it does.
  std::function<void(const navigate::RobotPose&)> on_pose;
  std::function<void(const navigate::RobotPose&)> on_truth;
  std::function<void(const navigate::Event&)> on_event;

  double seconds() const { return sim_->seconds(); }  // since the begin
  const DriveReport& report() const { return report_; }
  const PoseSteps& steps() const { return steps_; }
  const navigate::Driver& driver() const { return *driver_; }
  tools::SlamSession& slam() { return slam_; }
  grid::GridMap& grid() { return grid_; }

 private:
  ClosedLoop(std::unique_ptr<Simulation> sim, const RobotConfig& config,
             const CameraGeometry& geometry, tools::SlamSession slam,
             std::unique_ptr<navigate::Driver> driver, const SE3& T_MG, const SE3& T_MW,
             const ClosedLoopOptions& options);

  void Watch();
  void Deliver(const Outgoing& message);
  void TakeState(const DrState& state);
  void TakeImage(const CameraFrame& frame, const FramePose& pose);
  void SendGrid();
  void TakeTruth(const GroundTruth& truth);
  void TellPose(const navigate::RobotPose& pose);
  void TakeContact(const ContactFlags& contact);
  void Control();

  std::unique_ptr<Simulation> sim_;
  tools::SlamSession slam_;
  std::unique_ptr<navigate::Driver> driver_;
  SE3 T_MG_, T_MW_;
  ClosedLoopOptions options_;
  dr_ekf::PoseComposer composer_;
  dr_ekf::PoseGlide glide_;
  PoseSteps steps_;
  DrHistory dr_;
  grid::LookTaker looks_;
  grid::RecentObstacles obstacles_;
  grid::GridMap grid_;
  int64_t grid_session_ = 1, grid_seq_ = 0;
  std::optional<FramePose> frame_;                   // of the image that was delivered last
  std::optional<navigate::RobotPose> pose_, truth_;  // newest that the driver got, and the truth
  std::optional<Eigen::Vector2d> last_position_;
  bool pressed_ = false;
  bool sees_ = true;
  int64_t commands_ = 0;
  DriveReport report_;
};

}  // namespace gw::sim
