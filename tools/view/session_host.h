// What the connections of a server need of it.
#pragma once

#include <memory>
#include <string>

#include "tools/view/page_files.h"
#include "tools/view/server.h"

namespace gw::view {

class Client;

class SessionHost {
 public:
  virtual ~SessionHost() = default;
  virtual const ServerOptions& options() const = 0;
  virtual const PageFiles& page() const = 0;
  virtual const Server::Source& source() const = 0;
  virtual ServerCounters& counters_to_change() = 0;
  virtual const std::string& session() const = 0;  // name of this life of the server

  // Every connection calls it once, when it is over.
  virtual void ConnectionEnded() = 0;
  virtual void Joined(const std::shared_ptr<Client>& client) = 0;
  virtual void Left(const std::shared_ptr<Client>& client) = 0;
  virtual void WantedChanged() = 0;
};

}  // namespace gw::view
