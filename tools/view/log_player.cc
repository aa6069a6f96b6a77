#include "tools/view/log_player.h"

#include <algorithm>

#include "common/wire/channels.h"

namespace gw::view {
namespace {

// On the way to a place, what is older than this before it is only of the moment.
constexpr double kMoment = 0.5;  // s
// So much of the time before the place is told for charts.
constexpr double kHistory = 60;  // s

bool IsOfTheMoment(std::string_view channel) {
  return channel == wire::kCamera || channel == wire::kFrameDetail || channel == wire::kImu ||
         channel == wire::kWheel;
}

foxglove::Translator::Topics Charted() {
  foxglove::Translator::Topics topics;
  topics.set(static_cast<size_t>(foxglove::Topic::kWeights));
  topics.set(static_cast<size_t>(foxglove::Topic::kError));
  return topics;
}

}  // namespace

Result<LogPlayer> LogPlayer::Open(const std::string& path,
                                  const foxglove::TranslatorOptions& options, double speed) {
  auto reader = process::EventLogReader::Open(path);
  if (!reader) return reader.error();
  LogPlayer player(std::move(*reader), options);
  int64_t events = 0;
  while (const auto event = player.reader_.Next()) {
    player.clock_.Add(event->received);
    ++events;
  }
  if (player.reader_.error()) return *player.reader_.error();
  if (events == 0) return Error{ErrorCode::kBadData, path + ": holds no event of LCM"};
  player.duration_s_ = player.clock_.length().seconds();
  player.speed_ = std::clamp(speed, 0.0, kMaxSpeed);
  player.wanted_.set();
  player.Restart();
  return player;
}

LogPlayer::LogPlayer(process::EventLogReader reader, const foxglove::TranslatorOptions& options)
    : reader_(std::move(reader)), options_(options) {}

void LogPlayer::Restart() {
  reader_.Rewind();
  clock_ = tools::LogClock();
  translator_ = std::make_unique<foxglove::Translator>(options_);
  translator_->SetWanted(wanted_);
  next_ = reader_.Next();
  next_s_ = next_ ? clock_.Add(next_->received).seconds() : 0;
}

void LogPlayer::SetWanted(const foxglove::Translator::Topics& wanted) {
  const bool more = (wanted & ~wanted_).any();
  wanted_ = wanted;
  if (catching_up_) return;
  translator_->SetWanted(wanted_);
  // Who comes while it stands sees where it stands.
  if (more && paused_) {
    const double place = position_s_;
    Restart();
    Seek(place);
  }
}

void LogPlayer::Seek(double position_s) {
  position_s = std::clamp(position_s, 0.0, duration_s_);
  if (position_s < position_s_) Restart();
  position_s_ = position_s;
  catching_up_ = true;
  translator_->SetWanted({});
}

void LogPlayer::Control(const SetParameters& set) {
  if (set.speed) speed_ = std::clamp(*set.speed, 0.0, kMaxSpeed);
  if (set.paused) {
    paused_ = *set.paused;
    // Played again from its end, a log begins anew.
    if (!paused_ && !set.position_s && position_s_ >= duration_s_) Seek(0);
  }
  if (set.position_s) Seek(*set.position_s);
}

Playback LogPlayer::playback() const {
  return {position_s_, duration_s_, speed_, paused_};
}

void LogPlayer::Advance(DurationUs elapsed, int most_events) {
  if (!paused_ && !catching_up_) {
    position_s_ = std::min(position_s_ + elapsed.seconds() * speed_, duration_s_);
  }
  TakeIn(most_events);
  if (catching_up_ && (!next_ || next_s_ > position_s_)) Arrive();
  if (position_s_ >= duration_s_ && !next_) paused_ = true;
}

void LogPlayer::TakeIn(int most_events) {
  for (int i = 0; i < most_events && next_ && next_s_ <= position_s_; ++i) {
    const double before = position_s_ - next_s_;
    if (!catching_up_ || before <= kMoment || !IsOfTheMoment(next_->channel)) {
      if (catching_up_) {
        translator_->SetWanted(before <= kMoment    ? wanted_
                               : before <= kHistory ? wanted_ & Charted()
                                                    : foxglove::Translator::Topics());
      }
      translator_->Take(next_->channel, next_->data, next_->received);
      translator_->Tick(next_->received);
    }
    next_ = reader_.Next();
    if (next_) next_s_ = clock_.Add(next_->received).seconds();
  }
}

void LogPlayer::Arrive() {
  catching_up_ = false;
  jumped_ = true;
  translator_->SetWanted(wanted_);
}

}  // namespace gw::view
