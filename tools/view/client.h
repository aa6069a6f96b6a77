// One WebSocket client: takes its subscriptions, and writes what its queue holds, one frame at a
// time, so that a client that does not read stops nothing but itself.
#pragma once

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <memory>
#include <string>

#include "tools/view/client_queue.h"
#include "tools/view/session_host.h"

namespace gw::view {

class Client : public std::enable_shared_from_this<Client> {
 public:
  Client(boost::asio::ip::tcp::socket socket, SessionHost* host);
  ~Client();
  void Start(boost::beast::http::request<boost::beast::http::string_body> request);

  ClientQueue& queue() { return queue_; }
  bool wants_parameters() const { return wants_parameters_; }
  void Send(std::string text);
  // Writes what waits, unless a frame is being written.
  void Kick();

 private:
  void OnAccept(boost::beast::error_code error);
  void Read();
  void OnRead(boost::beast::error_code error);
  void Handle(const ClientMessage& message);
  void Take(const Subscribe& message);
  void Take(const Unsubscribe& message);
  void Take(const GetParameters& message);
  void Take(const SetParameters& message);
  void Take(const SubscribeParameters& message);
  void Take(const NotOffered& message);
  void Take(const Malformed& message);
  void Write();
  void End(bool dropped);

  boost::beast::websocket::stream<boost::beast::tcp_stream> stream_;
  boost::beast::flat_buffer buffer_;
  SessionHost* host_;
  ClientQueue queue_;
  std::shared_ptr<const std::string> writing_;
  bool wants_parameters_ = false;
  bool open_ = false;
  int malformed_ = 0;
};

}  // namespace gw::view
