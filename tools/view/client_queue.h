// What waits to be sent to one client. Bounded: a client that is slow, or stands still, costs a
// fixed amount of memory and no time, and what it does not get is counted.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "tools/data/foxglove/topics.h"

namespace gw::view {

class ClientQueue {
 public:
  using Topics = std::bitset<foxglove::kNumTopics>;

  // Refused (false): the id is in use, or there are too many.
  bool Subscribe(uint32_t subscription, foxglove::Topic topic);
  void Unsubscribe(uint32_t subscription);
  const Topics& topics() const { return topics_; }  // that the client listens to

  // For every subscription of its topic. What is not wanted is ignored.
  void Push(const foxglove::Message& message);
  // Part of the answer to TakeStale; not dropped as long as the queue is not full.
  void PushState(const foxglove::Message& message);
  // Control messages of the protocol, text; always sent, in order, before data.
  void PushText(std::string text);

  // Nothing of what waits is true any more; the state of every topic is due.
  void ForgetData();

  struct Item {
    bool binary = false;
    std::shared_ptr<const std::string> bytes;
  };
  // The next frame to be written.
  std::optional<Item> Pop();

  // Topics whose whole state must be sent: new subscriptions, and those of which a message was
  // dropped, once nothing of them waits any more.
  Topics TakeStale();

  int64_t dropped() const { return dropped_; }
  size_t waiting_bytes() const { return bytes_; }
  size_t waiting() const { return data_.size() + texts_.size(); }

  static constexpr size_t kMaxBytes = 16u << 20;  // a map of 500,000 landmarks
  static constexpr size_t kMaxEvery = 2400;       // images of a minute, when a log jumps
  static constexpr size_t kMaxState = 200;        // a way of 6 km
  static constexpr size_t kMaxTexts = 100;
  static constexpr size_t kMaxSubscriptions = 200;

 private:
  struct Waiting {
    foxglove::Topic topic;
    uint64_t time_ns = 0;
    std::shared_ptr<const std::string> json;
  };
  bool Has(foxglove::Topic topic) const { return topics_[static_cast<size_t>(topic)]; }
  size_t CountOf(foxglove::Topic topic) const { return counts_[static_cast<size_t>(topic)]; }
  void Append(const foxglove::Message& message);
  void DropOldest(foxglove::Topic topic);
  void DropAll(foxglove::Topic topic);

  std::map<uint32_t, foxglove::Topic> subscriptions_;
  Topics topics_;
  Topics stale_;
  std::deque<std::string> texts_;
  std::deque<Waiting> data_;
  std::deque<Item> ready_;  // frames of one message for several subscriptions
  std::array<size_t, foxglove::kNumTopics> counts_{};
  size_t bytes_ = 0;
  int64_t dropped_ = 0;
};

}  // namespace gw::view
