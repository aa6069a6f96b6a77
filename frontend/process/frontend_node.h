// gw-frontend as a node: CAMERA, DR and MAP_UPDATE in, FRAME_POSE and KEYFRAME out.
//
// Images wait in a queue of kMaxImages; when tracking cannot follow, the oldest is dropped and
// counted, so that the pose stays fresh. MAP_UPDATEs wait for the end of an image: after a loop one
// moves the whole map and takes most of the time between two images (3.7 MB, 22 ms for 310
// keyframes). KEYFRAMEs are kept until the back-end acknowledges them.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "common/config/robot_config.h"
#include "common/process/reliable.h"
#include "common/process/shell.h"
#include "frontend/core/tracking/tracker.h"

namespace gw::frontend {

class FrontendNode : public process::Node {
 public:
  static Result<std::unique_ptr<process::Node>> Create(const RobotConfig& config);

  Result<Done> Start(process::Shell& shell) override;
  bool Step(process::Shell& shell) override;

  static constexpr size_t kMaxImages = 4;

 private:
  struct WaitingImage {
    wire::DecodedCamera camera;
    Utime received;
  };

  explicit FrontendNode(Tracker tracker) : tracker_(std::move(tracker)) {}

  void TakeMapUpdates(std::span<const uint8_t> message, process::Shell& shell);
  void ApplyMapUpdates(process::Shell& shell);
  void ProcessImage(const WaitingImage& image, process::Shell& shell);
  void RequestMap(process::Shell& shell);
  void ReportHealth(process::Shell& shell) const;

  Tracker tracker_;
  std::deque<WaitingImage> images_;
  std::optional<process::ReliableSender> keyframes_;
  std::optional<process::ReliableReceiver> updates_;
  std::vector<wire::Bytes> waiting_updates_;
  bool map_wanted_ = true;  // ask for a snapshot
  std::optional<Utime> last_request_;
  int64_t request_seq_ = 0;
  int64_t query_seq_ = 0;
  int64_t session_ = 0;
  std::optional<Utime> last_image_;
  FramePose newest_;  // of the newest image
};

}  // namespace gw::frontend
