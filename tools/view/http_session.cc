#include "tools/view/http_session.h"

#include <boost/beast/websocket/rfc6455.hpp>
#include <chrono>
#include <string>

#include "tools/view/client.h"

namespace gw::view {

namespace beast = boost::beast;
namespace http = beast::http;

namespace {

constexpr uint32_t kMaxHeaderBytes = 8 * 1024;
constexpr uint64_t kMaxBodyBytes = 0;

// What the page may do: load its own files, talk to this server, show images it has made.
constexpr char kContentPolicy[] =
    "default-src 'self'; connect-src 'self' ws: wss:; img-src 'self' blob: data:; "
    "style-src 'self' 'unsafe-inline'; frame-ancestors 'self'; base-uri 'none'; form-action 'none'";

std::string_view View(beast::string_view text) {
  return {text.data(), text.size()};
}

// Among those the client offers, separated by commas.
bool Offers(std::string_view offered, std::string_view wanted) {
  while (!offered.empty()) {
    std::string_view one = offered.substr(0, offered.find(','));
    offered.remove_prefix(std::min(offered.size(), one.size() + 1));
    while (one.starts_with(' ')) one.remove_prefix(1);
    while (one.ends_with(' ')) one.remove_suffix(1);
    if (one == wanted) return true;
  }
  return false;
}

http::response<http::string_body> Reply(http::status status, std::string body,
                                        const std::string& type) {
  http::response<http::string_body> response(status, 11);
  response.set(http::field::content_type, type);
  response.set(http::field::cache_control, "no-cache");
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Content-Security-Policy", kContentPolicy);
  response.set("Referrer-Policy", "no-referrer");
  response.keep_alive(false);
  response.body() = std::move(body);
  response.prepare_payload();
  return response;
}

}  // namespace

HttpSession::~HttpSession() {
  if (!handed_over_) host_->ConnectionEnded();
}

void HttpSession::Read() {
  parser_.emplace();
  parser_->header_limit(kMaxHeaderBytes);
  parser_->body_limit(kMaxBodyBytes);
  stream_.expires_after(std::chrono::microseconds(host_->options().request_timeout.us));
  http::async_read(
      stream_, buffer_, *parser_,
      [self = shared_from_this()](beast::error_code error, size_t) { self->OnRead(error); });
}

void HttpSession::OnRead(beast::error_code error) {
  if (error == http::error::end_of_stream) return;
  if (error) {
    // What is no HTTP, too large, or does not come to an end.
    if (error != beast::error::timeout && error != boost::asio::error::connection_reset) {
      ++host_->counters_to_change().refused_requests;
    }
    return;
  }
  Request request = parser_->release();
  const std::string_view host = View(request[http::field::host]);
  if (!HostIsAllowed(host, host_->options().access)) {
    ++host_->counters_to_change().refused_requests;
    return Write(Reply(http::status::misdirected_request,
                       "this name is not served here; see --allow-host\n", "text/plain"));
  }
  if (beast::websocket::is_upgrade(request)) return Upgrade(std::move(request));
  Answer(request);
}

void HttpSession::Answer(const Request& request) {
  const bool head = request.method() == http::verb::head;
  if (!head && request.method() != http::verb::get) {
    ++host_->counters_to_change().refused_requests;
    return Write(Reply(http::status::method_not_allowed, "only GET and HEAD\n", "text/plain"));
  }
  const PageFiles::File* file = host_->page().Find(View(request.target()));
  if (file == nullptr) {
    ++host_->counters_to_change().refused_requests;
    return Write(Reply(http::status::not_found, "not found\n", "text/plain"));
  }
  Response response = Reply(http::status::ok, file->content, file->type);
  if (head) response.body().clear();
  response.keep_alive(request.keep_alive());
  Write(std::move(response));
}

void HttpSession::Upgrade(Request request) {
  const AccessRules& access = host_->options().access;
  const bool origin_fine =
      OriginIsAllowed(View(request[http::field::origin]), View(request[http::field::host]), access);
  if (!origin_fine || !TokenIsRight(View(request.target()), access)) {
    ++host_->counters_to_change().refused_requests;
    return Write(Reply(http::status::forbidden,
                       origin_fine ? "a token is needed: ?token=...\n"
                                   : "pages of this origin may not connect; see --allow-origin\n",
                       "text/plain"));
  }
  if (!Offers(View(request[http::field::sec_websocket_protocol]), kSubprotocol)) {
    ++host_->counters_to_change().refused_requests;
    return Write(Reply(http::status::bad_request,
                       "subprotocol " + std::string(kSubprotocol) + " is needed\n", "text/plain"));
  }
  handed_over_ = true;
  std::make_shared<Client>(stream_.release_socket(), host_)->Start(std::move(request));
}

void HttpSession::Write(Response response) {
  auto kept = std::make_shared<Response>(std::move(response));
  stream_.expires_after(std::chrono::microseconds(host_->options().request_timeout.us));
  http::async_write(
      stream_, *kept, [self = shared_from_this(), kept](beast::error_code error, size_t) {
        if (error) return;
        if (kept->need_eof() || !kept->keep_alive()) {
          self->stream_.socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, error);
          return;
        }
        self->Read();
      });
}

}  // namespace gw::view
