// gw-record as a node: everything on the bus into a SegmentLog, and evidence of faults.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "common/config/robot_config.h"
#include "common/process/shell.h"
#include "tools/robot/record/evidence.h"
#include "tools/robot/record/segment_log.h"

namespace gw::record {

class RecorderNode : public process::Node {
 public:
  // folder: made when it is not there; evidence goes to FOLDER/events. max_gb: of disk for both, a
  // quarter of it for evidence. Errors: kInvalidArgument (max_gb), kIo.
  static Result<std::unique_ptr<process::Node>> Create(const RobotConfig& config,
                                                       const std::string& folder,
                                                       const std::string& max_gb);

  Result<Done> Start(process::Shell& shell) override;
  bool Step(process::Shell& shell) override;
  void Stop(process::Shell& shell) override;

 private:
  RecorderNode(SegmentLog log, EvidenceKeeper evidence)
      : log_(std::move(log)), evidence_(std::move(evidence)) {}

  void Record(process::Shell& shell, const std::string& channel, std::span<const uint8_t> message,
              Utime received);
  void WatchHealth(process::Shell& shell, std::span<const uint8_t> message);
  void BeginEvidence(process::Shell& shell, const std::string& fault);

  SegmentLog log_;
  EvidenceKeeper evidence_;
  FaultWatch watch_;
  int64_t map_revision_ = 0;
  std::optional<Utime> last_flush_;
  std::optional<Utime> last_failure_;
};

}  // namespace gw::record
