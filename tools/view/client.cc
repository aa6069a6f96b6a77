#include "tools/view/client.h"

#include <chrono>
#include <utility>

namespace gw::view {

namespace beast = boost::beast;
namespace websocket = beast::websocket;

namespace {

constexpr size_t kMaxMessageBytes = 64 * 1024;  // what clients say is short
constexpr int kMaxMalformed = 20;               // then the connection is closed

}  // namespace

Client::Client(boost::asio::ip::tcp::socket socket, SessionHost* host)
    : stream_(std::move(socket)), host_(host) {}

Client::~Client() {
  host_->ConnectionEnded();
}

void Client::Start(beast::http::request<beast::http::string_body> request) {
  const auto idle = std::chrono::microseconds(host_->options().idle_timeout.us);
  stream_.set_option(websocket::stream_base::timeout{
      std::chrono::microseconds(host_->options().request_timeout.us), idle, true});
  stream_.set_option(websocket::stream_base::decorator([](websocket::response_type& response) {
    response.set(beast::http::field::sec_websocket_protocol,
                 beast::string_view(kSubprotocol.data(), kSubprotocol.size()));
  }));
  stream_.read_message_max(kMaxMessageBytes);
  stream_.auto_fragment(false);
  auto kept = std::make_shared<decltype(request)>(std::move(request));
  stream_.async_accept(
      *kept, [self = shared_from_this(), kept](beast::error_code error) { self->OnAccept(error); });
}

void Client::OnAccept(beast::error_code error) {
  if (error) {
    ++host_->counters_to_change().refused_requests;
    return;
  }
  open_ = true;
  host_->Joined(shared_from_this());
  const bool seekable = static_cast<bool>(host_->source().playback);
  Send(ServerInfo(host_->options().name, host_->session(), seekable));
  Send(Advertise());
  Read();
}

void Client::Send(std::string text) {
  queue_.PushText(std::move(text));
  Kick();
}

void Client::Read() {
  stream_.async_read(buffer_, [self = shared_from_this()](beast::error_code error, size_t) {
    self->OnRead(error);
  });
}

void Client::OnRead(beast::error_code error) {
  if (error) {
    End(error != websocket::error::closed);
    return;
  }
  if (stream_.got_text()) {
    const auto data = buffer_.data();
    Handle(ParseClientMessage({static_cast<const char*>(data.data()), data.size()}));
  } else {
    Take(NotOffered{"binary message"});
  }
  buffer_.consume(buffer_.size());
  if (open_) Read();
}

void Client::Handle(const ClientMessage& message) {
  std::visit([this](const auto& m) { Take(m); }, message);
  Kick();
}

void Client::Take(const Subscribe& message) {
  for (const auto& [subscription, channel] : message.subscriptions) {
    const auto topic = TopicOfChannel(channel);
    if (!topic || !queue_.Subscribe(subscription, *topic)) {
      Take(Malformed{"subscription " + std::to_string(subscription) + " is refused"});
    }
  }
  host_->WantedChanged();
}

void Client::Take(const Unsubscribe& message) {
  for (const uint32_t subscription : message.subscriptions) queue_.Unsubscribe(subscription);
  host_->WantedChanged();
}

void Client::Take(const GetParameters& message) {
  const auto& playback = host_->source().playback;
  if (playback) Send(ParameterValues(playback(), message.id));
}

void Client::Take(const SetParameters& message) {
  const auto& source = host_->source();
  if (!source.control) return Take(NotOffered{"setParameters"});
  source.control(message);
  if (message.id) Send(ParameterValues(source.playback(), message.id));
}

void Client::Take(const SubscribeParameters& message) {
  wants_parameters_ = message.on;
  const auto& playback = host_->source().playback;
  if (message.on && playback) Send(ParameterValues(playback(), std::nullopt));
}

void Client::Take(const NotOffered& message) {
  Take(Malformed{"not offered: " + message.op});
}

void Client::Take(const Malformed& message) {
  ++host_->counters_to_change().malformed_messages;
  if (++malformed_ > kMaxMalformed) return End(true);
  Send(Status(StatusLevel::kWarning, message.why));
}

void Client::Kick() {
  if (!open_ || writing_) return;
  const ClientQueue::Topics stale = queue_.TakeStale();
  for (size_t i = 0; i < foxglove::kNumTopics; ++i) {
    if (!stale[i] || !host_->source().state) continue;
    for (const auto& message : host_->source().state(static_cast<foxglove::Topic>(i))) {
      queue_.PushState(message);
    }
  }
  Write();
}

void Client::Write() {
  const auto item = queue_.Pop();
  if (!item) return;
  writing_ = item->bytes;
  stream_.binary(item->binary);
  stream_.async_write(boost::asio::buffer(*writing_),
                      [self = shared_from_this()](beast::error_code error, size_t) {
                        self->writing_.reset();
                        if (error) return self->End(true);
                        self->Kick();
                      });
}

void Client::End(bool dropped) {
  if (!std::exchange(open_, false)) return;
  if (dropped) ++host_->counters_to_change().clients_dropped;
  // What is being read or written ends with an error, and lets go of this client.
  beast::get_lowest_layer(stream_).cancel();
  beast::get_lowest_layer(stream_).close();
  host_->Left(shared_from_this());
}

}  // namespace gw::view
