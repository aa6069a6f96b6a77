#include "tools/view/viewer.h"

#include <algorithm>
#include <utility>

#include "common/process/memory.h"
#include "common/wire/channels.h"
#include "tools/data/files/json.h"

namespace gw::view {
namespace {

using tools::Json;

constexpr DurationUs kRound = Milliseconds(20);

}  // namespace

Result<std::unique_ptr<Viewer>> Viewer::Create(const ServerOptions& options, PageFiles page,
                                               const foxglove::TranslatorOptions& translator,
                                               process::Bus* bus, std::optional<LogPlayer> player) {
  std::unique_ptr<Viewer> viewer(new Viewer(translator, bus, std::move(player), options.name));
  auto server = Server::Create(options, std::move(page), viewer->MakeSource());
  if (!server) return server.error();
  viewer->server_ = std::move(*server);
  if (auto subscribed = viewer->Subscribe(); !subscribed) return subscribed.error();
  return viewer;
}

Viewer::Viewer(const foxglove::TranslatorOptions& options, process::Bus* bus,
               std::optional<LogPlayer> player, std::string name)
    : live_(options), bus_(bus), player_(std::move(player)), name_(std::move(name)) {
  live_.SetWanted({});
  if (player_) player_->SetWanted({});
}

Server::Source Viewer::MakeSource() {
  Server::Source source;
  source.state = [this](foxglove::Topic topic) { return translator().State(topic); };
  source.wanted = [this](const Server::Topics& wanted) {
    if (player_) {
      player_->SetWanted(wanted);
    } else {
      live_.SetWanted(wanted);
    }
  };
  if (!player_) return source;
  source.playback = [this] { return player_->playback(); };
  source.control = [this](const SetParameters& set) {
    player_->Control(set);
    server_->PublishPlayback();
  };
  return source;
}

Result<Done> Viewer::Subscribe() {
  if (bus_ == nullptr) return Done{};
  for (const wire::Channel& channel : wire::kChannels) {
    const std::string name(channel.name);
    // By the clock that also says how long a process has been silent.
    auto ok = bus_->Subscribe(
        name, [this, name](auto bytes, Utime) { live_.Take(name, bytes, clock_.Now()); });
    if (!ok) return ok;
  }
  return Done{};
}

Result<Done> Viewer::Run() {
  last_round_ = clock_.Now();
  if (bus_ != nullptr) {
    server_->Watch(bus_->fd(), [this] {
      if (const auto pumped = bus_->Pump(0); !pumped) {
        failure_ = pumped.error();
        server_->Stop();
      }
      Pass();
    });
  }
  server_->Every(kRound, [this] { Round(); });
  systemd_.Ready();
  server_->Run();
  systemd_.Stopping();
  if (failure_) return *failure_;
  return Done{};
}

void Viewer::Round() {
  const Utime now = clock_.Now();
  if (player_) {
    player_->Advance(now - last_round_);
    if (player_->TakeJumped()) {
      server_->ResendState();
      server_->PublishPlayback();
    }
    if (playback_rate_.Pass(now)) server_->PublishPlayback();
  } else {
    live_.Tick(now);
  }
  last_round_ = now;
  Pass();
  if (release_rate_.Pass(now)) process::ReleaseFreeMemory();
  if (self_rate_.Pass(now)) ReportSelf(now);
  systemd_.Watchdog();
}

void Viewer::Pass() {
  if (player_ && player_->catching_up()) return;  // until clients have forgotten what they had
  const auto messages = translator().Drain();
  if (!messages.empty()) server_->Publish(messages);
}

// gw.Viewer.
void Viewer::ReportSelf(Utime now) {
  const foxglove::Translator& from = translator();
  const ServerCounters counters = server_->counters();
  Json channels = Json::array();
  for (const auto& [name, count] : from.channels()) {
    int64_t& before = messages_before_[name];
    channels.push_back({{"name", name},
                        {"rate_hz", std::max<int64_t>(count.messages - before, 0)},
                        {"lost", count.lost},
                        {"undecodable", count.undecodable}});
    before = count.messages;
  }
  const Json json = {
      {"timestamp", foxglove::JsonTime(now)},
      {"source", name_},
      {"clients", server_->num_clients()},
      {"dropped", counters.messages_dropped},
      {"refused", counters.refused_full + counters.refused_requests + counters.malformed_messages},
      {"cpu_percent", load_.CpuPercent(now)},
      {"memory_mb", OwnLoad::MemoryMb()},
      {"map_complete", from.map().complete()},
      {"keyframes", from.map().keyframes().size()},
      {"landmarks", from.map().landmarks().size()},
      {"loops", from.map().loops().size()},
      {"pieces", from.map().num_pieces()},
      {"channels", std::move(channels)}};
  server_->Publish({{foxglove::Topic::kViewer, now,
                     std::make_shared<const std::string>(tools::JsonLine(json))}});
}

}  // namespace gw::view
