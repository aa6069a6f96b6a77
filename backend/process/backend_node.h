// gw-backend as a node: KEYFRAME in, MAP_UPDATE out, the map in a journal on disk.
//
// A keyframe is acknowledged once it is in the journal. When the journal fails (full disk), mapping
// goes on without it, HEALTH says so, and a checkpoint is tried again every kJournalRetry.
// Localise only: the map is read and never changed; keyframes are acknowledged and dropped, and the
// front-end is told to make none.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "backend/core/mapper.h"
#include "backend/journal/journal.h"
#include "backend/process/solver_thread.h"
#include "common/config/robot_config.h"
#include "common/process/reliable.h"
#include "common/process/shell.h"

namespace gw::backend {

class BackendNode : public process::Node {
 public:
  // map_directory: empty for a map that dies with the process. It is opened by Start.
  // Error kInvalidArgument: kFrozen without a directory.
  static Result<std::unique_ptr<process::Node>> Create(const RobotConfig& config,
                                                       const std::string& map_directory,
                                                       MapUse use);

  Result<Done> Start(process::Shell& shell) override;
  bool Step(process::Shell& shell) override;
  void Stop(process::Shell& shell) override;

 private:
  BackendNode(const RobotConfig& config, const RectifiedCamera& camera, std::string map_directory,
              MapUse use, Mapper mapper)
      : config_(config),
        camera_(camera),
        map_directory_(std::move(map_directory)),
        use_(use),
        mapper_(std::move(mapper)) {}

  Result<Done> OpenMap(process::Shell& shell);
  void TakeKeyframes(std::span<const uint8_t> message, process::Shell& shell);
  void Insert(const Keyframe& keyframe, bool journalled, process::Shell& shell);
  void Publish(const MapUpdate& update, process::Shell& shell);
  void TakeOutcomes(process::Shell& shell);
  void TakeLoop(const LoopGraphResult& result, process::Shell& shell);
  void StartJobs();
  template <typename Record>
  void Journalize(const Record& record, process::Shell& shell);
  void CareForJournal(process::Shell& shell);

  RobotConfig config_;
  RectifiedCamera camera_;
  std::string map_directory_;
  MapUse use_;
  Mapper mapper_;
  std::optional<Journal> journal_;
  SolverThread solver_;               // local BA, and the pose graphs of loops, which go first
  SolverThread global_solver_;        // global BA after every closed loop; a newer loop abandons it
  bool dirty_ = false;                // keyframes came since the last local BA job was cut
  std::optional<LoopGraphJob> loop_;  // waits for the solver
  bool loop_runs_ = false;            // in the solver
  bool global_wanted_ = false;
  int64_t place_match_seq_ = 0;
  std::optional<process::ReliableReceiver> keyframes_;
  std::optional<process::ReliableSender> updates_;
  std::optional<Utime> last_journal_try_;
};

}  // namespace gw::backend
