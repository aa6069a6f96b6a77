#include "common/process/reliable.h"

#include <algorithm>
#include <utility>

namespace gw::process {

void ReliableSender::Push(wire::Bytes message) {
  while (!queue_.empty() && (queue_.size() >= options_.max_messages ||
                             queue_bytes_ + message.size() > options_.max_bytes)) {
    queue_bytes_ -= queue_.front().message.size();
    queue_.pop_front();
    ++given_up_;
  }
  queue_bytes_ += message.size();
  queue_.push_back({std::move(message), next_seq_++, 0, {}, options_.resend_after});
}

std::vector<const wire::Bytes*> ReliableSender::Due(Utime now) {
  std::vector<const wire::Bytes*> due;
  size_t bytes = 0;
  const size_t window = std::min(options_.window, queue_.size());
  for (size_t i = 0; i < window && bytes < options_.burst_bytes; ++i) {
    Entry& entry = queue_[i];
    if (entry.tries > 0) {
      if (now - entry.last_try < entry.patience) continue;
      entry.patience = std::min(entry.patience + entry.patience, options_.resend_at_most);
      ++resent_;
    }
    ++entry.tries;
    entry.last_try = now;
    wire::SetDelivery({entry.seq, session_, queue_.front().seq}, entry.message);
    bytes += entry.message.size();
    due.push_back(&entry.message);
  }
  return due;
}

void ReliableSender::HandleAck(const wire::Ack& ack) {
  if (ack.acked_session != session_ || ack.acked_seq >= next_seq_) return;
  bool progress = std::exchange(receiver_session_, ack.session) != ack.session;
  while (!queue_.empty() && queue_.front().seq <= ack.acked_seq) {
    queue_bytes_ -= queue_.front().message.size();
    queue_.pop_front();
    progress = true;
  }
  if (!progress) return;
  // The receiver lives: what it misses need not wait for the patience of a silent time.
  for (Entry& entry : queue_) entry.patience = options_.resend_after;
}

std::vector<wire::Bytes> ReliableReceiver::Accept(wire::ByteSpan message) {
  std::vector<wire::Bytes> complete;
  const auto delivery = wire::ReadDelivery(message);
  if (!delivery || delivery->oldest_seq < 1 || delivery->seq < delivery->oldest_seq ||
      (sender_session_ && delivery->session < *sender_session_)) {
    ++refused_;
    return complete;
  }
  if (sender_session_ != delivery->session) {  // the first, or a new life of the sender
    sender_session_ = delivery->session;
    next_seq_ = delivery->oldest_seq;
    early_.clear();
  }
  if (delivery->oldest_seq > next_seq_) {
    // The sender no longer has what we wait for. What came early is still good.
    int64_t missing = delivery->oldest_seq - next_seq_;
    while (!early_.empty() && early_.begin()->first < delivery->oldest_seq) {
      complete.push_back(std::move(early_.begin()->second));
      early_.erase(early_.begin());
      --missing;
    }
    lost_ += missing;
    next_seq_ = delivery->oldest_seq;
  }
  if (delivery->seq < next_seq_ || early_.contains(delivery->seq)) {
    ++duplicates_;
  } else if (early_.size() < kMaxEarly || delivery->seq == next_seq_) {
    early_.emplace(delivery->seq, wire::Bytes(message.begin(), message.end()));
  }
  while (!early_.empty() && early_.begin()->first == next_seq_) {
    complete.push_back(std::move(early_.begin()->second));
    early_.erase(early_.begin());
    ++next_seq_;
  }
  return complete;
}

std::optional<wire::Ack> ReliableReceiver::MakeAck(Utime now) {
  if (!sender_session_) return std::nullopt;
  return wire::Ack{now, ++ack_seq_, session_, *sender_session_, next_seq_ - 1};
}

}  // namespace gw::process
