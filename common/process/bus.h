// The seam between a process and its messages: bytes in, bytes out. Decoding is gw_wire's business,
// so that a bad message is an event that the process sees and counts.
#pragma once

#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/core/result.h"
#include "common/core/time.h"
#include "common/process/file_handle.h"

struct _lcm_t;  // NOLINT(bugprone-reserved-identifier): LCM's own name

namespace gw::process {

class Bus {
 public:
  // message: valid during the call only. received: clock of the host; for latency, not estimation.
  using Handler = std::function<void(std::span<const uint8_t> message, Utime received)>;

  virtual ~Bus() = default;
  // channel: of common/wire/channels.h, here and below.
  virtual Result<Done> Publish(const std::string& channel, std::span<const uint8_t> message) = 0;
  // Handlers run inside Pump, in order of arrival. There is no unsubscribe: a process listens to
  // the same channels all its life.
  virtual Result<Done> Subscribe(const std::string& channel, Handler handler) = 0;
  // Readable when Pump has something to do. Valid after the first Subscribe.
  virtual int fd() const = 0;
  // Waits up to `timeout_ms` (0: not at all, -1: without limit) for a message, then handles all
  // that are there. Gives their number. What a handler throws comes out here; the message counts as
  // handled.
  virtual Result<int> Pump(int timeout_ms) = 0;
};

// LCM over UDP multicast. Publish may be called from any thread, the rest from one.
class LiveBus : public Bus {
 public:
  // url: udpm://ADDRESS:PORT[?ttl=N][&recv_buf_size=BYTES]. Create the Loop first, so that LCM's
  // receive thread does not take the signals. Errors: kBadConfig for a malformed URL, kIo when the
  // network has no route for it (the text says what to do).
  static Result<std::unique_ptr<LiveBus>> Create(const std::string& url);
  ~LiveBus() override;

  Result<Done> Publish(const std::string& channel, std::span<const uint8_t> message) override;
  Result<Done> Subscribe(const std::string& channel, Handler handler) override;
  int fd() const override;
  Result<int> Pump(int timeout_ms) override;

  // At most so many images wait for this process, in place of those of channels.h: one that only
  // shows them needs the newest, and LCM's buffer, which never shrinks, stays small. Call before
  // Subscribe.
  void HoldImages(int most) { most_images_ = most; }

  // Empty, or why images may get lost and the command against it.
  const std::string& warning() const { return warning_; }

 private:
  struct Subscription;
  LiveBus(_lcm_t* lcm, std::string url, std::string warning);

  _lcm_t* lcm_;
  std::string url_;
  std::string warning_;
  std::optional<int> most_images_;
  std::vector<std::unique_ptr<Subscription>> subscriptions_;
  std::exception_ptr thrown_;
};

// Everything within one object, for tests of process shells: what is published is handled by the
// next Pump. Not for threads.
class MemoryBus : public Bus {
 public:
  MemoryBus();

  Result<Done> Publish(const std::string& channel, std::span<const uint8_t> message) override;
  Result<Done> Subscribe(const std::string& channel, Handler handler) override;
  int fd() const override { return event_.get(); }
  Result<int> Pump(int timeout_ms) override;

  void set_now(Utime now) { now_ = now; }  // `received` of what is published from here on

 private:
  struct Message {
    std::string channel;
    std::vector<uint8_t> bytes;
    Utime received;
  };
  FileHandle event_;
  Utime now_;
  std::deque<Message> waiting_;
  std::multimap<std::string, Handler> handlers_;
};

}  // namespace gw::process
