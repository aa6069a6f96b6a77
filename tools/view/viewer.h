// gw-view: what comes from the bus or a log goes to the clients of a server.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "common/process/bus.h"
#include "common/process/clock.h"
#include "common/process/sd_notify.h"
#include "tools/data/foxglove/translator.h"
#include "tools/view/log_player.h"
#include "tools/view/own_load.h"
#include "tools/view/server.h"

namespace gw::view {

class Viewer {
 public:
  // Exactly one of bus and player. The bus must live as long as the viewer.
  static Result<std::unique_ptr<Viewer>> Create(const ServerOptions& options, PageFiles page,
                                                const foxglove::TranslatorOptions& translator,
                                                process::Bus* bus, std::optional<LogPlayer> player);

  uint16_t port() const { return server_->port(); }
  // Until SIGINT or SIGTERM. Error kIo: the bus has failed.
  Result<Done> Run();

 private:
  Viewer(const foxglove::TranslatorOptions& options, process::Bus* bus,
         std::optional<LogPlayer> player, std::string name);
  Server::Source MakeSource();
  Result<Done> Subscribe();
  foxglove::Translator& translator() { return player_ ? player_->translator() : live_; }
  void Round();
  void Pass();
  void ReportSelf(Utime now);

  foxglove::Translator live_;
  process::Bus* bus_;
  std::optional<LogPlayer> player_;
  std::string name_;
  process::Clock clock_;
  process::SdNotify systemd_;
  std::unique_ptr<Server> server_;
  Utime last_round_;
  foxglove::RateLimit self_rate_{Milliseconds(1000)};
  foxglove::RateLimit playback_rate_{Milliseconds(200)};
  // What piled up while this process was held up would stay with it.
  foxglove::RateLimit release_rate_{Milliseconds(10'000)};
  OwnLoad load_;
  std::map<std::string, int64_t> messages_before_;
  std::optional<Error> failure_;
};

}  // namespace gw::view
