#include "tools/view/client_queue.h"

#include <gtest/gtest.h>

namespace gw::view {
namespace {

using foxglove::Message;
using foxglove::Topic;

Message Make(Topic topic, size_t bytes = 10) {
  return {topic, Utime{1}, std::make_shared<const std::string>(bytes, 'x')};
}

TEST(ClientQueue, OnlyWhatIsWantedWaits) {
  ClientQueue queue;
  ASSERT_TRUE(queue.Subscribe(1, Topic::kPose));
  EXPECT_FALSE(queue.Subscribe(1, Topic::kImage));  // the id is in use
  queue.Push(Make(Topic::kImage));
  EXPECT_EQ(queue.waiting(), 0u);
  queue.Push(Make(Topic::kPose));
  EXPECT_EQ(queue.waiting(), 1u);
  queue.Unsubscribe(1);
  EXPECT_EQ(queue.waiting(), 0u);
}

TEST(ClientQueue, ANewerImageReplacesTheOneThatWaits) {
  ClientQueue queue;
  queue.Subscribe(1, Topic::kImage);
  for (int i = 0; i < 100; ++i) queue.Push(Make(Topic::kImage, 20'000));
  EXPECT_EQ(queue.waiting(), 1u);
  EXPECT_EQ(queue.dropped(), 99);
}

TEST(ClientQueue, AStalledClientCostsABoundedAmount) {
  ClientQueue queue;
  for (uint32_t i = 0; i < foxglove::kNumTopics; ++i) queue.Subscribe(i, static_cast<Topic>(i));
  queue.TakeStale();
  for (int i = 0; i < 5000; ++i) {
    for (uint32_t t = 0; t < foxglove::kNumTopics; ++t) {
      queue.Push(Make(static_cast<Topic>(t), 200'000));
    }
    ASSERT_LE(queue.waiting_bytes(), ClientQueue::kMaxBytes);
    queue.PushText("x");
  }
  EXPECT_LE(queue.waiting(), ClientQueue::kMaxTexts + 1000);
  EXPECT_GT(queue.dropped(), 10'000);
}

TEST(ClientQueue, WhoMissedAPartOfAStateGetsItWhole) {
  ClientQueue queue;
  queue.Subscribe(1, Topic::kTrajectory);
  const auto index = static_cast<size_t>(Topic::kTrajectory);
  EXPECT_TRUE(queue.TakeStale()[index]);  // new
  EXPECT_FALSE(queue.TakeStale()[index]);
  for (size_t i = 0; i <= ClientQueue::kMaxState; ++i) queue.Push(Make(Topic::kTrajectory));
  EXPECT_EQ(queue.dropped(), 1);
  EXPECT_FALSE(queue.TakeStale()[index]);  // what waits goes first
  while (queue.Pop()) {
  }
  EXPECT_TRUE(queue.TakeStale()[index]);
}

TEST(ClientQueue, TextGoesBeforeDataAndEverySubscriptionGetsItsFrame) {
  ClientQueue queue;
  queue.Subscribe(3, Topic::kPose);
  queue.Subscribe(4, Topic::kPose);
  queue.Push(Make(Topic::kPose));
  queue.PushText("hello");
  EXPECT_EQ(*queue.Pop()->bytes, "hello");
  EXPECT_EQ((*queue.Pop()->bytes)[1], 3);
  EXPECT_EQ((*queue.Pop()->bytes)[1], 4);
  EXPECT_FALSE(queue.Pop());
}

}  // namespace
}  // namespace gw::view
