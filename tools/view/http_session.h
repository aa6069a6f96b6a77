// One connection until it is either over or a WebSocket: answers requests for the page.
#pragma once

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>
#include <memory>
#include <optional>

#include "tools/view/session_host.h"

namespace gw::view {

class HttpSession : public std::enable_shared_from_this<HttpSession> {
 public:
  HttpSession(boost::asio::ip::tcp::socket socket, SessionHost* host)
      : stream_(std::move(socket)), host_(host) {}
  ~HttpSession();
  void Start() { Read(); }

 private:
  using Request = boost::beast::http::request<boost::beast::http::string_body>;
  using Response = boost::beast::http::response<boost::beast::http::string_body>;

  void Read();
  void OnRead(boost::beast::error_code error);
  void Answer(const Request& request);
  void Upgrade(Request request);
  void Write(Response response);

  boost::beast::tcp_stream stream_;
  boost::beast::flat_buffer buffer_{16 * 1024};  // of requests; a larger one is an error
  std::optional<boost::beast::http::request_parser<boost::beast::http::string_body>> parser_;
  SessionHost* host_;
  bool handed_over_ = false;
};

}  // namespace gw::view
