#include "tools/view/client_queue.h"

#include <algorithm>

#include "tools/view/protocol.h"

namespace gw::view {

using foxglove::Delivery;
using foxglove::Topic;

bool ClientQueue::Subscribe(uint32_t subscription, Topic topic) {
  if (subscriptions_.size() >= kMaxSubscriptions) return false;
  if (!subscriptions_.emplace(subscription, topic).second) return false;
  topics_.set(static_cast<size_t>(topic));
  stale_.set(static_cast<size_t>(topic));
  return true;
}

void ClientQueue::Unsubscribe(uint32_t subscription) {
  const auto it = subscriptions_.find(subscription);
  if (it == subscriptions_.end()) return;
  const Topic topic = it->second;
  subscriptions_.erase(it);
  const bool others = std::any_of(subscriptions_.begin(), subscriptions_.end(),
                                  [topic](const auto& s) { return s.second == topic; });
  if (others) return;
  topics_.reset(static_cast<size_t>(topic));
  stale_.reset(static_cast<size_t>(topic));
  DropAll(topic);
}

void ClientQueue::Append(const foxglove::Message& message) {
  data_.push_back({message.topic,
                   static_cast<uint64_t>(std::max<int64_t>(message.received.us, 0)) * 1000,
                   message.json});
  ++counts_[static_cast<size_t>(message.topic)];
  bytes_ += message.json->size();
}

void ClientQueue::DropOldest(Topic topic) {
  const auto it = std::find_if(data_.begin(), data_.end(),
                               [topic](const Waiting& w) { return w.topic == topic; });
  if (it == data_.end()) return;
  bytes_ -= it->json->size();
  --counts_[static_cast<size_t>(topic)];
  data_.erase(it);
}

void ClientQueue::DropAll(Topic topic) {
  while (CountOf(topic) > 0) DropOldest(topic);
}

void ClientQueue::Push(const foxglove::Message& message) {
  if (!Has(message.topic)) return;
  const size_t index = static_cast<size_t>(message.topic);
  const bool full = bytes_ + message.json->size() > kMaxBytes;
  switch (foxglove::Info(message.topic).delivery) {
    case Delivery::kNewest:
      dropped_ += static_cast<int64_t>(CountOf(message.topic));
      DropAll(message.topic);
      break;
    case Delivery::kEvery:
      if (CountOf(message.topic) < kMaxEvery && !full) break;
      if (CountOf(message.topic) == 0) break;
      ++dropped_;
      DropOldest(message.topic);
      break;
    case Delivery::kState:
      if (stale_[index]) return;  // the whole state will be sent
      if (CountOf(message.topic) < kMaxState && !full) break;
      ++dropped_;
      stale_.set(index);
      return;
  }
  if (bytes_ + message.json->size() > kMaxBytes) {
    ++dropped_;
    return;
  }
  Append(message);
}

void ClientQueue::PushState(const foxglove::Message& message) {
  if (!Has(message.topic)) return;
  // One message may be larger than the bound, if it is alone.
  if (bytes_ > 0 && bytes_ + message.json->size() > kMaxBytes) {
    ++dropped_;
    stale_.set(static_cast<size_t>(message.topic));
    return;
  }
  Append(message);
}

void ClientQueue::ForgetData() {
  data_.clear();
  counts_.fill(0);
  bytes_ = 0;
  stale_ = topics_;
}

void ClientQueue::PushText(std::string text) {
  if (texts_.size() >= kMaxTexts) {
    ++dropped_;
    return;
  }
  texts_.push_back(std::move(text));
}

std::optional<ClientQueue::Item> ClientQueue::Pop() {
  if (ready_.empty() && !texts_.empty()) {
    auto text = std::make_shared<const std::string>(std::move(texts_.front()));
    texts_.pop_front();
    return Item{false, std::move(text)};
  }
  while (ready_.empty() && !data_.empty()) {
    const Waiting waiting = std::move(data_.front());
    data_.pop_front();
    --counts_[static_cast<size_t>(waiting.topic)];
    bytes_ -= waiting.json->size();
    for (const auto& [subscription, topic] : subscriptions_) {
      if (topic != waiting.topic) continue;
      ready_.push_back({true, std::make_shared<const std::string>(
                                  MessageData(subscription, waiting.time_ns, *waiting.json))});
    }
  }
  if (ready_.empty()) return std::nullopt;
  Item item = std::move(ready_.front());
  ready_.pop_front();
  return item;
}

ClientQueue::Topics ClientQueue::TakeStale() {
  Topics due;
  for (size_t i = 0; i < foxglove::kNumTopics; ++i) {
    if (!stale_[i] || counts_[i] > 0) continue;
    due.set(i);
    stale_.reset(i);
  }
  return due;
}

}  // namespace gw::view
