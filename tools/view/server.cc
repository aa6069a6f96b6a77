#include "tools/view/server.h"

#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <csignal>
#include <list>
#include <utility>

#include "tools/view/client.h"
#include "tools/view/http_session.h"

namespace gw::view {

namespace net = boost::asio;
using Tcp = net::ip::tcp;
using boost::system::error_code;

class Server::Impl : public SessionHost {
 public:
  Impl(const ServerOptions& options, PageFiles page, Source source)
      : options_(options),
        page_(std::move(page)),
        source_(std::move(source)),
        session_(std::to_string(std::chrono::system_clock::now().time_since_epoch().count())),
        acceptor_(loop_),
        signals_(loop_, SIGINT, SIGTERM) {}
  ~Impl() override { clients_.clear(); }  // before the loop that their sockets belong to

  Result<Done> Listen() {
    error_code error;
    const auto address = net::ip::make_address(options_.address, error);
    if (!error) {
      const Tcp::endpoint endpoint(address, options_.port);
      acceptor_.open(endpoint.protocol(), error);
      if (!error) acceptor_.set_option(net::socket_base::reuse_address(true), error);
      if (!error) acceptor_.bind(endpoint, error);
      if (!error) acceptor_.listen(net::socket_base::max_listen_connections, error);
    }
    if (error) {
      return Error{ErrorCode::kIo, options_.address + ":" + std::to_string(options_.port) +
                                       " cannot be listened to: " + error.message()};
    }
    Accept();
    return Done{};
  }

  uint16_t port() const { return acceptor_.local_endpoint().port(); }
  int num_clients() const { return static_cast<int>(clients_.size()); }
  ServerCounters counters() const {
    ServerCounters counters = counters_;
    for (const auto& client : clients_) counters.messages_dropped += client->queue().dropped();
    return counters;
  }

  void Publish(const std::vector<foxglove::Message>& messages) {
    // A copy, because a client that fails leaves the list.
    const auto clients = clients_;
    for (const auto& client : clients) {
      for (const foxglove::Message& message : messages) client->queue().Push(message);
      client->Kick();
    }
  }
  void ResendState() {
    const auto clients = clients_;
    for (const auto& client : clients) {
      client->queue().ForgetData();
      client->Kick();
    }
  }
  void PublishPlayback() {
    const std::string text = ParameterValues(source_.playback(), std::nullopt);
    const auto clients = clients_;
    for (const auto& client : clients) {
      if (client->wants_parameters()) client->Send(text);
    }
  }

  void Watch(int fd, std::function<void()> ready) {
    watched_.emplace_back(loop_, ::dup(fd));
    WaitFor(&watched_.back(), std::move(ready));
  }
  void Every(DurationUs interval, std::function<void()> work) {
    timers_.emplace_back(loop_);
    Repeat(&timers_.back(), std::chrono::microseconds(interval.us), std::move(work));
  }
  void Run() {
    signals_.async_wait([this](error_code error, int) {
      if (!error) Stop();
    });
    loop_.run();
  }
  void Stop() { loop_.stop(); }

  // SessionHost, for the connections.
  const ServerOptions& options() const override { return options_; }
  const PageFiles& page() const override { return page_; }
  const Source& source() const override { return source_; }
  ServerCounters& counters_to_change() override { return counters_; }
  const std::string& session() const override { return session_; }
  void ConnectionEnded() override { --connections_; }
  void Joined(const std::shared_ptr<Client>& client) override { clients_.push_back(client); }
  void Left(const std::shared_ptr<Client>& client) override {
    counters_.messages_dropped += client->queue().dropped();
    clients_.remove(client);
    WantedChanged();
  }
  void WantedChanged() override {
    Topics wanted;
    for (const auto& client : clients_) wanted |= client->queue().topics();
    if (source_.wanted) source_.wanted(wanted);
  }

 private:
  void Accept() {
    acceptor_.async_accept([this](error_code error, Tcp::socket socket) {
      if (error == net::error::operation_aborted) return;
      if (!error) {
        ++counters_.connections;
        if (connections_ >= options_.max_connections) {
          ++counters_.refused_full;  // closed by leaving
        } else {
          ++connections_;
          std::make_shared<HttpSession>(std::move(socket), this)->Start();
        }
      }
      Accept();
    });
  }

  void WaitFor(net::posix::stream_descriptor* fd, std::function<void()> ready) {
    fd->async_wait(net::posix::stream_descriptor::wait_read,
                   [this, fd, ready = std::move(ready)](error_code error) mutable {
                     if (error) return;
                     ready();
                     WaitFor(fd, std::move(ready));
                   });
  }
  // Late rounds are merged into one.
  void Repeat(net::steady_timer* timer, std::chrono::microseconds interval,
              std::function<void()> work) {
    timer->expires_after(interval);
    timer->async_wait([this, timer, interval, work = std::move(work)](error_code error) mutable {
      if (error) return;
      work();
      Repeat(timer, interval, std::move(work));
    });
  }

  ServerOptions options_;
  PageFiles page_;
  Source source_;
  std::string session_;
  std::list<std::shared_ptr<Client>> clients_;
  int connections_ = 0;
  ServerCounters counters_;
  // The connections that wait in the loop end with it, and still need what is above.
  net::io_context loop_{1};
  Tcp::acceptor acceptor_;
  net::signal_set signals_;
  std::list<net::posix::stream_descriptor> watched_;
  std::list<net::steady_timer> timers_;
};

Server::Server(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Server::~Server() = default;

Result<std::unique_ptr<Server>> Server::Create(const ServerOptions& options, PageFiles page,
                                               Source source) {
  auto impl = std::make_unique<Impl>(options, std::move(page), std::move(source));
  if (auto listening = impl->Listen(); !listening) return listening.error();
  return std::unique_ptr<Server>(new Server(std::move(impl)));
}

uint16_t Server::port() const {
  return impl_->port();
}
int Server::num_clients() const {
  return impl_->num_clients();
}
ServerCounters Server::counters() const {
  return impl_->counters();
}
void Server::Publish(const std::vector<foxglove::Message>& messages) {
  impl_->Publish(messages);
}
void Server::ResendState() {
  impl_->ResendState();
}
void Server::PublishPlayback() {
  impl_->PublishPlayback();
}
void Server::Watch(int fd, std::function<void()> ready) {
  impl_->Watch(fd, std::move(ready));
}
void Server::Every(DurationUs interval, std::function<void()> work) {
  impl_->Every(interval, std::move(work));
}
void Server::Run() {
  impl_->Run();
}
void Server::Stop() {
  impl_->Stop();
}

}  // namespace gw::view
