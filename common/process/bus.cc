#include "common/process/bus.h"

#include <lcm/lcm.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <exception>
#include <string_view>
#include <system_error>
#include <utility>

#include "common/wire/channels.h"

namespace gw::process {
namespace {

// Two stereo pairs in a row with room to spare; 2 MB measured to be enough, 212 kB (the usual
// default of Linux) loses most images (docs/channels.md).
constexpr int kWantedReceiveBuffer = 4 << 20;
constexpr int kMaxMessagesPerPump = 1000;

// Take a piece off the front of `text`; false, and nothing taken, when it is not there.
bool Take(std::string_view& text, std::string_view piece) {
  if (!text.starts_with(piece)) return false;
  text.remove_prefix(piece.size());
  return true;
}
bool TakeNumber(std::string_view& text, int min, int max, int& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || number < min || number > max) return false;
  text.remove_prefix(static_cast<size_t>(end - text.data()));
  return true;
}

// Gives recv_buf_size, 0 when the URL leaves it to the system. LCM itself would ignore what it does
// not understand, or print and go on.
Result<int> ParseReceiveBuffer(const std::string& url) {
  std::string_view rest = url;
  int ignored = 0;
  bool fine = Take(rest, "udpm://") && TakeNumber(rest, 224, 239, ignored);  // multicast
  for (int i = 0; i < 3; ++i) fine = fine && Take(rest, ".") && TakeNumber(rest, 0, 255, ignored);
  fine = fine && Take(rest, ":") && TakeNumber(rest, 1, 65535, ignored);
  int receive_buffer = 0;
  for (std::string_view separator = "?"; fine && !rest.empty(); separator = "&") {
    fine = Take(rest, separator) &&
           ((Take(rest, "ttl=") && TakeNumber(rest, 0, 255, ignored)) ||
            (Take(rest, "recv_buf_size=") && TakeNumber(rest, 1, 1 << 30, receive_buffer)));
  }
  if (fine) return receive_buffer;
  return Error{ErrorCode::kBadConfig,
               "LCM URL \"" + url +
                   "\" is not of the form "
                   "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304" +
                   (rest.empty() ? "" : "; not understood: \"" + std::string(rest) + "\"")};
}

// What the kernel really grants; it cuts a large request silently to net.core.rmem_max.
int GrantedReceiveBuffer(int requested) {
  const FileHandle probe(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (requested > 0) {
    ::setsockopt(probe.get(), SOL_SOCKET, SO_RCVBUF, &requested, sizeof(requested));
  }
  int doubled = 0;
  socklen_t size = sizeof(doubled);
  if (::getsockopt(probe.get(), SOL_SOCKET, SO_RCVBUF, &doubled, &size) != 0) return 0;
  return doubled / 2;  // the kernel reports twice what it grants
}

std::string ReceiveBufferWarning(int requested) {
  const int granted = GrantedReceiveBuffer(requested);
  const int wanted = std::max(requested, kWantedReceiveBuffer);
  if (granted >= wanted) return "";
  const std::string size = std::to_string(wanted);
  std::string text = "receive buffer of " + std::to_string(granted) + " bytes instead of " + size +
                     ": images will get lost; ";
  if (requested < wanted) return text + "add recv_buf_size=" + size + " to the LCM URL";
  return text + "run: sudo sysctl -w net.core.rmem_max=" + size;
}

int WaitReadable(int fd, int timeout_ms) {
  pollfd descriptor{fd, POLLIN, 0};
  return ::poll(&descriptor, 1, timeout_ms);
}

}  // namespace

struct LiveBus::Subscription {
  LiveBus* bus;
  Handler handler;

  // Called from C code: nothing may be thrown through it.
  static void Receive(const lcm_recv_buf_t* buffer, const char*, void* self) {
    auto* subscription = static_cast<Subscription*>(self);
    try {
      subscription->handler({static_cast<const uint8_t*>(buffer->data), buffer->data_size},
                            Utime{buffer->recv_utime});
    } catch (...) {
      subscription->bus->thrown_ = std::current_exception();
    }
  }
};

LiveBus::LiveBus(_lcm_t* lcm, std::string url, std::string warning)
    : lcm_(lcm), url_(std::move(url)), warning_(std::move(warning)) {}

LiveBus::~LiveBus() {
  lcm_destroy(lcm_);
}

Result<std::unique_ptr<LiveBus>> LiveBus::Create(const std::string& url) {
  const auto receive_buffer = ParseReceiveBuffer(url);
  if (!receive_buffer) return receive_buffer.error();
  lcm_t* lcm = lcm_create(url.c_str());
  if (lcm == nullptr) {
    return Error{ErrorCode::kIo,
                 "cannot join " + url +
                     ": no route for multicast? run: sudo ip link set lo multicast on; "
                     "sudo ip route add 239.255.76.67/32 dev lo"};
  }
  return std::unique_ptr<LiveBus>(new LiveBus(lcm, url, ReceiveBufferWarning(*receive_buffer)));
}

Result<Done> LiveBus::Publish(const std::string& channel, std::span<const uint8_t> message) {
  if (lcm_publish(lcm_, channel.c_str(), message.data(), static_cast<unsigned>(message.size())) !=
      0) {
    return Error{ErrorCode::kIo, "cannot publish " + channel + " on " + url_};
  }
  return Done{};
}

Result<Done> LiveBus::Subscribe(const std::string& channel, Handler handler) {
  const wire::Channel* known = wire::FindChannel(channel);
  if (known == nullptr) {
    return Error{ErrorCode::kInvalidArgument, "channel " + channel + " is not in channels.h"};
  }
  subscriptions_.push_back(std::make_unique<Subscription>(Subscription{this, std::move(handler)}));
  lcm_subscription_t* subscription =
      lcm_subscribe(lcm_, channel.c_str(), &Subscription::Receive, subscriptions_.back().get());
  // Asking for the descriptor shows whether LCM's receive thread and its self test came up.
  if (subscription == nullptr || fd() < 0) {
    return Error{ErrorCode::kIo, "cannot receive on " + url_ +
                                     ": multicast does not come back to this host; check "
                                     "firewall and route"};
  }
  const bool limited = most_images_ && channel == wire::kCamera;
  lcm_subscription_set_queue_capacity(subscription,
                                      limited ? *most_images_ : known->queue_capacity);
  return Done{};
}

int LiveBus::fd() const {
  return lcm_get_fileno(lcm_);
}

Result<int> LiveBus::Pump(int timeout_ms) {
  if (timeout_ms != 0 && WaitReadable(fd(), timeout_ms) < 0 && errno != EINTR) {
    return Error{ErrorCode::kIo, "cannot wait for " + url_ + ": " + std::strerror(errno)};
  }
  for (int handled = 0; handled < kMaxMessagesPerPump; ++handled) {
    const int result = lcm_handle_timeout(lcm_, 0);
    if (thrown_) std::rethrow_exception(std::exchange(thrown_, nullptr));
    if (result < 0) return Error{ErrorCode::kIo, "cannot receive on " + url_};
    if (result == 0) return handled;
  }
  return kMaxMessagesPerPump;
}

MemoryBus::MemoryBus() : event_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}

Result<Done> MemoryBus::Publish(const std::string& channel, std::span<const uint8_t> message) {
  waiting_.push_back({channel, {message.begin(), message.end()}, now_});
  ::eventfd_write(event_.get(), 1);
  return Done{};
}

Result<Done> MemoryBus::Subscribe(const std::string& channel, Handler handler) {
  handlers_.emplace(channel, std::move(handler));
  return Done{};
}

Result<int> MemoryBus::Pump(int timeout_ms) {
  WaitReadable(event_.get(), timeout_ms);
  eventfd_t ignored = 0;
  ::eventfd_read(event_.get(), &ignored);
  // What handlers publish waits for the next Pump, as on the real bus.
  const int count = static_cast<int>(waiting_.size());
  for (int i = 0; i < count; ++i) {
    const Message message = std::move(waiting_.front());
    waiting_.pop_front();
    const auto [begin, end] = handlers_.equal_range(message.channel);
    for (auto it = begin; it != end; ++it) it->second(message.bytes, message.received);
  }
  return count;
}

}  // namespace gw::process
