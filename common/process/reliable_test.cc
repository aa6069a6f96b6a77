#include "common/process/reliable.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "common/core/random.h"

namespace gw::process {
namespace {

using wire::Bytes;

Bytes MessageOf(int64_t number) {
  MapUpdate update;
  update.utime = Utime{number};  // names the message in these tests
  return wire::Encode(update);
}
int64_t NumberOf(const Bytes& message) {
  return wire::Decode<MapUpdate>(message)->utime.us;
}
std::vector<int64_t> NumbersOf(const std::vector<Bytes>& messages) {
  std::vector<int64_t> numbers;
  for (const Bytes& message : messages) numbers.push_back(NumberOf(message));
  return numbers;
}
std::vector<int64_t> NumbersOf(const std::vector<const Bytes*>& messages) {
  std::vector<int64_t> numbers;
  for (const Bytes* message : messages) numbers.push_back(NumberOf(*message));
  return numbers;
}
using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(ReliableSender, SendsAtOnceThenWaitsLongerAndLonger) {
  ReliableSender sender(1);
  sender.Push(MessageOf(10));
  std::vector<int64_t> sent_at_ms;
  for (int64_t ms = 0; ms < 10'000; ms += 10) {
    if (!sender.Due(Utime{ms * 1000}).empty()) sent_at_ms.push_back(ms);
  }
  EXPECT_THAT(sent_at_ms, ElementsAre(0, 200, 600, 1400, 3000, 5000, 7000, 9000));
  EXPECT_EQ(sender.resent(), 7);
}

TEST(ReliableSender, ASignOfLifeEndsTheBackOff) {
  ReliableSender sender(1);
  sender.Push(MessageOf(10));
  sender.Push(MessageOf(11));
  for (int64_t ms = 0; ms < 5000; ms += 10) (void)sender.Due(Utime{ms * 1000});
  sender.HandleAck({Utime{}, 1, 99, 1, 1});
  EXPECT_EQ(sender.waiting(), 1u);
  EXPECT_THAT(NumbersOf(sender.Due(Utime{5'200'000})), ElementsAre(11));
  EXPECT_THAT(sender.Due(Utime{5'300'000}), IsEmpty());
}

TEST(ReliableSender, IgnoresAcknowledgementsThatAreNotForIt) {
  ReliableSender sender(7);
  sender.Push(MessageOf(10));
  sender.HandleAck({Utime{}, 1, 99, 6, 1});  // of its earlier life
  sender.HandleAck({Utime{}, 2, 99, 7, 2});  // of a message that it never sent
  EXPECT_EQ(sender.waiting(), 1u);
  sender.HandleAck({Utime{}, 3, 99, 7, 1});
  EXPECT_EQ(sender.waiting(), 0u);
}

TEST(ReliableSender, GivesTheOldestUpWhenItsQueueIsFull) {
  ReliableSenderOptions options;
  options.max_messages = 3;
  ReliableSender sender(1, options);
  ReliableReceiver receiver(2);
  for (int i = 1; i <= 2; ++i) sender.Push(MessageOf(i));
  EXPECT_THAT(NumbersOf(receiver.Accept(*sender.Due(Utime{0})[0])), ElementsAre(1));
  for (int i = 3; i <= 6; ++i) sender.Push(MessageOf(i));
  EXPECT_EQ(sender.given_up(), 3);  // 1, 2 and 3; the receiver had only 1
  std::vector<int64_t> received;
  for (const Bytes* message : sender.Due(Utime{1})) {
    for (const int64_t number : NumbersOf(receiver.Accept(*message))) received.push_back(number);
  }
  EXPECT_THAT(received, ElementsAre(4, 5, 6));
  EXPECT_EQ(receiver.lost(), 2);
}

TEST(ReliableSender, BoundsMessagesAndBytesOnTheirWay) {
  ReliableSenderOptions options;
  options.window = 4;
  ReliableSender sender(1, options);
  for (int i = 0; i < 10; ++i) sender.Push(MessageOf(i));
  EXPECT_EQ(sender.Due(Utime{0}).size(), 4u);
  EXPECT_EQ(sender.Due(Utime{1}).size(), 0u);
  options.burst_bytes = 1;
  ReliableSender careful(1, options);
  for (int i = 0; i < 10; ++i) careful.Push(MessageOf(i));
  EXPECT_EQ(careful.Due(Utime{0}).size(), 1u);
  EXPECT_EQ(careful.Due(Utime{0}).size(), 1u);
}

TEST(ReliableReceiver, PutsInOrderAndDropsRepeats) {
  ReliableSender sender(1);
  ReliableReceiver receiver(2);
  for (int i = 0; i < 3; ++i) sender.Push(MessageOf(i));
  const auto due = sender.Due(Utime{0});
  EXPECT_THAT(receiver.Accept(*due[2]), IsEmpty());
  EXPECT_THAT(receiver.Accept(*due[2]), IsEmpty());
  EXPECT_THAT(NumbersOf(receiver.Accept(*due[0])), ElementsAre(0));
  EXPECT_EQ(receiver.MakeAck(Utime{5})->acked_seq, 1);
  EXPECT_THAT(NumbersOf(receiver.Accept(*due[1])), ElementsAre(1, 2));
  EXPECT_THAT(receiver.Accept(*due[1]), IsEmpty());
  EXPECT_EQ(receiver.duplicates(), 2);
  const auto ack = receiver.MakeAck(Utime{6});
  EXPECT_EQ(ack->acked_seq, 3);
  EXPECT_EQ(ack->acked_session, 1);
  EXPECT_EQ(ack->session, 2);
}

TEST(ReliableReceiver, ANewSessionOfTheSenderStartsOver) {
  ReliableReceiver receiver(50);
  for (const int64_t session : {100, 200}) {
    ReliableSender sender(session);
    sender.Push(MessageOf(session));
    EXPECT_THAT(NumbersOf(receiver.Accept(*sender.Due(Utime{0})[0])), ElementsAre(session));
  }
  ReliableSender ghost(150);  // a late message of a life that is over
  ghost.Push(MessageOf(150));
  EXPECT_THAT(receiver.Accept(*ghost.Due(Utime{0})[0]), IsEmpty());
  EXPECT_EQ(receiver.refused(), 1);
}

TEST(ReliableReceiver, ARestartedReceiverGoesOnWhereTheAcknowledgementsEnded) {
  ReliableSender sender(1);
  for (int i = 0; i < 5; ++i) sender.Push(MessageOf(i));
  ReliableReceiver before(2);
  for (const Bytes* message : sender.Due(Utime{0})) (void)before.Accept(*message);
  sender.HandleAck({Utime{}, 1, 2, 1, 3});  // 0, 1, 2 are safe; then it dies
  ReliableReceiver after(3);
  std::vector<int64_t> received;
  for (const Bytes* message : sender.Due(Utime{200'000})) {
    for (const int64_t number : NumbersOf(after.Accept(*message))) received.push_back(number);
  }
  EXPECT_THAT(received, ElementsAre(3, 4));
  EXPECT_EQ(after.lost(), 0);
}

TEST(ReliableReceiver, RefusesWhatIsNoMessage) {
  ReliableReceiver receiver(1);
  EXPECT_FALSE(receiver.MakeAck(Utime{0}));
  Bytes unstamped = MessageOf(1);
  Bytes inverted = MessageOf(1);
  wire::SetDelivery({5, 1, 6}, inverted);  // older than the oldest
  for (const Bytes& bad : {Bytes{}, Bytes(10), unstamped, inverted}) {
    EXPECT_THAT(receiver.Accept(bad), IsEmpty());
  }
  EXPECT_EQ(receiver.refused(), 4);
}

TEST(ReliableReceiver, HoldsOnlyABoundedNumberOfEarlyMessages) {
  ReliableReceiver receiver(1);
  for (int64_t seq = 2; seq < 2000; ++seq) {
    Bytes message = MessageOf(seq);
    wire::SetDelivery({seq, 1, 1}, message);
    EXPECT_THAT(receiver.Accept(message), IsEmpty());
  }
  Bytes first = MessageOf(1);
  wire::SetDelivery({1, 1, 1}, first);
  EXPECT_EQ(receiver.Accept(first).size(), ReliableReceiver::kMaxEarly + 1);
}

// A bus that loses, repeats and reorders, in both directions, with restarts of both sides.
struct Flight {
  int64_t arrives_ms;
  bool is_ack;
  Bytes message;
  wire::Ack ack;
};

TEST(Reliable, EverythingArrivesOnceAndInOrderOverABadBus) {
  for (uint64_t seed = 0; seed < 200; ++seed) {
    CounterRng rng(seed, 0, 0);
    const double loss = rng.Uniform(0, 0.6);
    const double repeat = rng.Uniform(0, 0.5);
    const int64_t jitter_ms = 1 + rng.Below(600);
    ReliableSender sender(1);
    ReliableReceiver receiver(2);
    std::vector<Flight> flights;
    std::vector<int64_t> received;
    const auto launch = [&](int64_t now_ms, const Flight& flight) {
      for (int copies = rng.Uniform() < repeat ? 2 : 1; copies > 0; --copies) {
        if (rng.Uniform() < loss) continue;
        flights.push_back(flight);
        flights.back().arrives_ms = now_ms + rng.Below(static_cast<uint32_t>(jitter_ms));
      }
    };
    constexpr int64_t kCount = 150;
    int64_t pushed = 0;
    int64_t now_ms = 0;
    for (; now_ms < 600'000 && (pushed < kCount || sender.waiting() > 0); now_ms += 10) {
      if (pushed < kCount && rng.Uniform() < 0.3) sender.Push(MessageOf(pushed++));
      for (const Bytes* message : sender.Due(Utime{now_ms * 1000})) {
        launch(now_ms, {0, false, *message, {}});
      }
      for (size_t i = 0; i < flights.size();) {
        if (flights[i].arrives_ms > now_ms) {
          ++i;
          continue;
        }
        const Flight flight = std::move(flights[i]);
        flights.erase(flights.begin() + static_cast<ptrdiff_t>(i));
        if (flight.is_ack) {
          sender.HandleAck(flight.ack);
          continue;
        }
        for (const Bytes& message : receiver.Accept(flight.message)) {
          received.push_back(NumberOf(message));
        }
        if (const auto ack = receiver.MakeAck(Utime{now_ms * 1000})) {
          launch(now_ms, {0, true, {}, *ack});
        }
      }
    }
    EXPECT_EQ(sender.waiting(), 0u) << seed << ": not acknowledged after " << now_ms << " ms";
    ASSERT_EQ(received.size(), static_cast<size_t>(kCount)) << seed;
    EXPECT_TRUE(std::is_sorted(received.begin(), received.end())) << seed;
    EXPECT_EQ(received.back(), kCount - 1);
    EXPECT_EQ(sender.given_up() + receiver.lost() + receiver.refused(), 0) << seed;
  }
}

// Restarts: what was acknowledged is never delivered again; what was not arrives at least once.
TEST(Reliable, NothingAcknowledgedIsLostOverRestartsOfTheReceiver) {
  for (uint64_t seed = 0; seed < 200; ++seed) {
    CounterRng rng(seed, 1, 0);
    ReliableSender sender(1);
    auto receiver = std::make_unique<ReliableReceiver>(2);
    std::vector<int64_t> safe;       // journalled: survives the receiver
    std::vector<int64_t> volatile_;  // delivered, not yet journalled
    constexpr int64_t kCount = 100;
    int64_t pushed = 0;
    for (int64_t step = 0; step < 20'000 && (pushed < kCount || sender.waiting() > 0); ++step) {
      const Utime now{step * 20'000};
      if (pushed < kCount && rng.Below(3) == 0) sender.Push(MessageOf(pushed++));
      for (const Bytes* message : sender.Due(now)) {
        if (rng.Below(4) == 0) continue;  // lost
        for (const Bytes& given : receiver->Accept(*message)) {
          volatile_.push_back(NumberOf(given));
        }
      }
      if (rng.Below(5) == 0) {  // the journal is synced, then acknowledged
        safe.insert(safe.end(), volatile_.begin(), volatile_.end());
        volatile_.clear();
        const auto ack = receiver->MakeAck(now);
        if (ack && rng.Below(3) != 0) sender.HandleAck(*ack);
      }
      if (rng.Below(40) == 0) {
        volatile_.clear();
        receiver = std::make_unique<ReliableReceiver>(3 + step);
      }
    }
    EXPECT_EQ(sender.waiting(), 0u) << seed;
    // After a lost acknowledgement and a restart messages come again: a journal keeps the first.
    std::vector<int64_t> unique = safe;
    std::sort(unique.begin(), unique.end());
    unique.erase(std::unique(unique.begin(), unique.end()), unique.end());
    EXPECT_EQ(unique.size(), static_cast<size_t>(kCount)) << seed;
  }
}

}  // namespace
}  // namespace gw::process
