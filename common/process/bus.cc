#include "common/process/bus.h"

#include <lcm/lcm.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <exception>
#include <regex>

#include "lcmtypes/wire/channels.h"

namespace gw::process {
namespace {

// Two stereo pairs in a row with room to spare; 2 MB measured to be enough, 212 kB (the usual
// default of Linux) loses most images (docs/channels.md).
constexpr int kWantedReceiveBuffer = 4 << 20;
constexpr int kMaxMessagesPerPump = 1000;

struct UdpmOptions {
  int receive_buffer = 0;  // 0: the system's default
};

Result<UdpmOptions> ParseUrl(const std::string& url) {
  static const std::regex form(
      R"(udpm://(\d{1,3})\.(\d{1,3})\.(\d{1,3})\.(\d{1,3}):(\d{1,5})(\?(.*))?)");
  static const std::regex option(R"((ttl|recv_buf_size)=(\d{1,9}))");
  const auto bad = [&url](const std::string& why) {
    return Error{ErrorCode::kBadConfig,
                 "LCM URL \"" + url + "\": " + why +
                     "; it has the form "
                     "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304"};
  };
  std::smatch match;
  if (!std::regex_match(url, match, form)) return bad("not understood");
  for (int i = 1; i <= 4; ++i) {
    if (std::stoi(match[i]) > 255) return bad("the address is out of range");
  }
  if (std::stoi(match[1]) < 224 || std::stoi(match[1]) > 239) return bad("not a multicast address");
  if (std::stoi(match[5]) < 1 || std::stoi(match[5]) > 65535)
    return bad("the port is out of range");
  UdpmOptions options;
  std::string rest = match[7];
  while (!rest.empty()) {
    const size_t end = rest.find('&');
    const std::string one = rest.substr(0, end);
    rest = end == std::string::npos ? "" : rest.substr(end + 1);
    std::smatch parts;
    if (!std::regex_match(one, parts, option)) return bad("option \"" + one + "\" is not known");
    if (parts[1] == "recv_buf_size") options.receive_buffer = std::stoi(parts[2]);
  }
  return options;
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
  const auto options = ParseUrl(url);
  if (!options) return options.error();
  lcm_t* lcm = lcm_create(url.c_str());
  if (lcm == nullptr) {
    return Error{ErrorCode::kIo,
                 "cannot join " + url +
                     ": no route for multicast? run: sudo ip link set lo multicast on; "
                     "sudo ip route add 239.255.76.67/32 dev lo"};
  }
  return std::unique_ptr<LiveBus>(
      new LiveBus(lcm, url, ReceiveBufferWarning(options->receive_buffer)));
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
  lcm_subscription_set_queue_capacity(subscription, known->queue_capacity);
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
