// KEYFRAME, MAP_UPDATE: delivered once and in order over a bus that may lose, repeat and reorder,
// across restarts of either side.
//
// Every message carries (session, seq, oldest_seq): who sent it, its place, and the oldest message
// that the sender still holds. The receiver acknowledges cumulatively. Both classes are pure: time
// and messages come in as arguments.
//
//   sender.Push(Encode(keyframe));            receiver.Accept(bytes) -> messages, in order
//   for (m : sender.Due(now)) Publish(m);     Publish(Encode(receiver.MakeAck(now)))
//   sender.HandleAck(ack);
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "common/wire/wire.h"

namespace gw::process {

struct ReliableSenderOptions {
  DurationUs resend_after = Milliseconds(200);     // doubles with every try without an answer ...
  DurationUs resend_at_most = Milliseconds(2000);  // ... up to this
  size_t window = 32;                              // messages on their way at once; the others wait
  size_t burst_bytes = 1 << 20;  // of one call of Due, so that the receive buffers can follow
  // Bounds of the queue. When it is full, the oldest message is given up and counted: the receiver
  // learns of the gap from oldest_seq and can ask for a snapshot.
  size_t max_messages = 2000;
  size_t max_bytes = 256u << 20;
};

class ReliableSender {
 public:
  // session: start time of this process in us; must grow from one start to the next.
  ReliableSender(int64_t session, ReliableSenderOptions options = {})
      : session_(session), options_(options) {}

  // message: of wire::Encode(Keyframe, MapUpdate).
  void Push(wire::Bytes message);
  // What to publish now, oldest first; stamped. Valid until the next call of any method.
  std::vector<const wire::Bytes*> Due(Utime now);
  void HandleAck(const wire::Ack& ack);

  size_t waiting() const { return queue_.size(); }
  int64_t resent() const { return resent_; }
  int64_t given_up() const { return given_up_; }

 private:
  struct Entry {
    wire::Bytes message;
    int64_t seq = 0;
    int tries = 0;
    Utime last_try;
    DurationUs patience;
  };

  int64_t session_;
  ReliableSenderOptions options_;
  std::deque<Entry> queue_;
  size_t queue_bytes_ = 0;
  int64_t next_seq_ = 1;
  int64_t receiver_session_ = 0;
  int64_t resent_ = 0;
  int64_t given_up_ = 0;
};

class ReliableReceiver {
 public:
  // session: start time of this process in us.
  explicit ReliableReceiver(int64_t session) : session_(session) {}

  // Messages that are now complete and in order: none, this one, or this and those that waited for
  // it. Each message is given out once per life of the receiver; after its restart, messages that
  // were delivered but not acknowledged come again.
  std::vector<wire::Bytes> Accept(wire::ByteSpan message);

  // Acknowledges all that Accept has given out; call it when those are safe (journalled), after
  // every Accept or later. Empty until a sender was heard.
  std::optional<wire::Ack> MakeAck(Utime now);

  int64_t duplicates() const { return duplicates_; }
  int64_t refused() const { return refused_; }  // malformed, or of a sender that is gone
  // Messages that the sender gave up before they arrived.
  int64_t lost() const { return lost_; }

  static constexpr size_t kMaxEarly = 64;  // messages kept that came before their turn

 private:
  int64_t session_;
  std::optional<int64_t> sender_session_;
  int64_t next_seq_ = 1;
  int64_t ack_seq_ = 0;
  std::map<int64_t, wire::Bytes> early_;
  int64_t duplicates_ = 0;
  int64_t refused_ = 0;
  int64_t lost_ = 0;
};

}  // namespace gw::process
