#include "backend/core/bundle/window.h"

#include <gtest/gtest.h>

#include "backend/core/piece/map_edit.h"
#include "backend/test/world.h"

namespace gw::backend {
namespace {

// One lap and a bit: the newest keyframes see again what the first ones saw.
Map Driven(int keyframes) {
  return DrivenMap({.num_points = 600, .keyframes_per_lap = 10}, keyframes);
}

std::vector<KeyframeId> Fixed(const LocalBaJob& job, KeyframeId from, KeyframeId to) {
  std::vector<KeyframeId> out;
  for (const auto& keyframe : job.keyframes) {
    if (keyframe.fixed && keyframe.id >= from && keyframe.id <= to) out.push_back(keyframe.id);
  }
  return out;
}

// A piece whose first keyframe was cropped away is held by the oldest that is left, in local and in
// global BA.
TEST(Window, APieceIsHeldByTheFirstKeyframeThatIsThere) {
  const Map both = PutTogether(Driven(5), Driven(12));
  const Map cropped =
      KeepKeyframes(both, [](const MapKeyframe& k) { return k.frame.id != KeyframeId{6}; });
  EXPECT_EQ(both.FirstOfPieces(),
            (std::map<KeyframeId, KeyframeId>{{{}, KeyframeId{1}}, {{6}, KeyframeId{6}}}));
  EXPECT_EQ(cropped.FirstOfPieces(),
            (std::map<KeyframeId, KeyframeId>{{{}, KeyframeId{1}}, {{6}, KeyframeId{7}}}));

  const MappingContext context({.local_keyframes = 5}, {}, TestCamera());
  const auto window = CutLocalWindow(cropped, context);
  ASSERT_TRUE(window);
  // There are others, outside the window, that hold it, too.
  EXPECT_GT(Fixed(*window, {8}, {17}).size(), 0u);
  EXPECT_EQ(Fixed(*window, {7}, {7}).size(), 1u);

  const auto whole = CutWholeMap(cropped, context);
  ASSERT_TRUE(whole);
  EXPECT_EQ(Fixed(*whole, {1}, {17}), (std::vector<KeyframeId>{{1}, {7}}));
}

}  // namespace
}  // namespace gw::backend
