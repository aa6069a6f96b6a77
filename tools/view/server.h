// HTTP and WebSocket on one port: the page, and Foxglove's protocol for it and for other viewers.
//
// One thread, one loop, in which its user's sources run too (Watch, Every): nothing is shared, and
// nothing waits for a client. Everything a client can do is bounded: time to send a request, size
// of requests and messages, number of connections, what waits to be sent. See
// docs/adr/0030-viewer.md.
#pragma once

#include <bitset>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/core/result.h"
#include "common/core/time.h"
#include "tools/data/foxglove/topics.h"
#include "tools/view/access.h"
#include "tools/view/page_files.h"
#include "tools/view/protocol.h"

namespace gw::view {

struct ServerOptions {
  std::string address = "127.0.0.1";
  uint16_t port = 8765;  // Foxglove's own; 0: any that is free
  AccessRules access;
  std::string name;  // told to clients
  int max_connections = 64;
  DurationUs request_timeout = Milliseconds(10'000);
  DurationUs idle_timeout = Milliseconds(30'000);  // a client that does not answer pings is gone
};

struct ServerCounters {
  int64_t connections = 0;         // accepted
  int64_t refused_full = 0;        // too many at once
  int64_t refused_requests = 0;    // wrong path, method, host, origin, token, or no HTTP
  int64_t malformed_messages = 0;  // of WebSocket clients
  int64_t clients_dropped = 0;     // WebSockets ended by an error or by silence
  int64_t messages_dropped = 0;    // that slow clients did not get
};

class Server {
 public:
  using Topics = std::bitset<foxglove::kNumTopics>;
  struct Source {
    // The state of a topic, for one who begins to listen.
    std::function<std::vector<foxglove::Message>(foxglove::Topic)> state;
    // Somebody listens to other topics than before.
    std::function<void(const Topics&)> wanted;
    // A log's player; both empty without one.
    std::function<Playback()> playback;
    std::function<void(const SetParameters&)> control;
  };

  // Error kIo: the address cannot be used (why).
  static Result<std::unique_ptr<Server>> Create(const ServerOptions& options, PageFiles page,
                                                Source source);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  uint16_t port() const;
  int num_clients() const;  // WebSockets
  ServerCounters counters() const;

  void Publish(const std::vector<foxglove::Message>& messages);
  // All clients forget what they have, and get the state anew.
  void ResendState();
  // Tells the place in a log to who wants to know.
  void PublishPlayback();

  // Inside Run. ready: the descriptor can be read.
  void Watch(int fd, std::function<void()> ready);
  void Every(DurationUs interval, std::function<void()> work);
  // Until Stop, or SIGINT or SIGTERM.
  void Run();
  void Stop();

 private:
  class Impl;
  explicit Server(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace gw::view
