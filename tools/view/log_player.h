// Plays a log into a translator: at any speed, paused, from any place. Time is told by the caller.
//
// A place is reached by taking in everything before it, because map, way and health are the sum of
// what was said; images and what is only of the moment are skipped on the way there.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "common/process/event_log.h"
#include "tools/data/foxglove/translator.h"
#include "tools/data/log/log_clock.h"
#include "tools/view/protocol.h"

namespace gw::view {

class LogPlayer {
 public:
  // Reads the log once, for its length. Errors of EventLogReader::Open; kBadData: holds no event.
  static Result<LogPlayer> Open(const std::string& path, const foxglove::TranslatorOptions& options,
                                double speed);

  // Time passed. At most `most_events` are taken in, so that a long way is gone in steps.
  void Advance(DurationUs elapsed, int most_events = 2000);
  void Control(const SetParameters& set);
  Playback playback() const;

  foxglove::Translator& translator() { return *translator_; }
  void SetWanted(const foxglove::Translator::Topics& wanted);
  bool catching_up() const { return catching_up_; }
  // True once after a jump has arrived: what clients have is of another time.
  bool TakeJumped() { return std::exchange(jumped_, false); }

  static constexpr double kMaxSpeed = 100;

 private:
  LogPlayer(process::EventLogReader reader, const foxglove::TranslatorOptions& options);

  void Restart();
  void Seek(double position_s);
  void TakeIn(int most_events);
  void Arrive();

  process::EventLogReader reader_;
  foxglove::TranslatorOptions options_;
  std::unique_ptr<foxglove::Translator> translator_;
  foxglove::Translator::Topics wanted_;
  tools::LogClock clock_;
  std::optional<process::LogEvent> next_;
  double next_s_ = 0;      // place of next_ in the log
  double position_s_ = 0;  // everything before is taken in, or will be
  double duration_s_ = 0;
  double speed_ = 1;
  bool paused_ = false;
  bool catching_up_ = false;
  bool jumped_ = false;
};

}  // namespace gw::view
