#include "common/core/id_table.h"

#include <gtest/gtest.h>

#include <map>
#include <string>

#include "common/core/random.h"

namespace gw {
namespace {

void ExpectEqual(const IdTable<std::string>& table, const std::map<int64_t, std::string>& model) {
  ASSERT_EQ(table.size(), model.size());
  std::map<int64_t, std::string> all;
  table.ForEach([&](int64_t id, const std::string& value) { all[id] = value; });
  EXPECT_EQ(all, model);
  for (const auto& [id, value] : model) ASSERT_TRUE(table.Find(id) && *table.Find(id) == value);
}

// Few ids, so that they collide, come back, and leave gaps of every shape.
TEST(IdTable, IsAMapThroughAnyHistory) {
  for (uint64_t seed = 0; seed < 8; ++seed) {
    IdTable<std::string> table;
    std::map<int64_t, std::string> model;
    CounterRng rng(seed, 1, 0);
    for (int step = 0; step < 20000; ++step) {
      const auto id = static_cast<int64_t>(1 + rng.Below(3000)) << (seed % 4 * 14);
      if (rng.Below(2) == 0) {
        const auto [value, is_new] = table.Insert(id);
        EXPECT_EQ(is_new, !model.contains(id));
        EXPECT_EQ(*value, model[id]);
        *value = model[id] = std::to_string(step);
      } else {
        EXPECT_EQ(table.Erase(id), model.erase(id) == 1);
      }
      EXPECT_EQ(table.Contains(id), model.contains(id));
    }
    ExpectEqual(table, model);
    IdTable<std::string> copy = table;
    for (const auto& [id, value] : model) table.Erase(id);
    EXPECT_TRUE(table.empty());
    ExpectEqual(copy, model);
    table = copy;
    ExpectEqual(table, model);
  }
}

TEST(IdTable, ValuesStayWhereTheyAre) {
  IdTable<int> table;
  int* const first = table.Insert(7).first;
  *first = 42;
  for (int64_t id = 100; id < 5000; ++id) table.Insert(id);
  for (int64_t id = 100; id < 5000; id += 2) table.Erase(id);
  EXPECT_EQ(table.Find(7), first);
  EXPECT_EQ(*first, 42);
}

TEST(IdTable, ZeroAndNegativeIdsAreIdsLikeOthers) {
  IdTable<int> table;
  EXPECT_EQ(table.Find(0), nullptr);
  EXPECT_FALSE(table.Erase(1));
  table.Insert(1);
  EXPECT_EQ(table.Find(0), nullptr);
  EXPECT_EQ(table.Find(-1), nullptr);
  EXPECT_FALSE(table.Erase(0));
  *table.Insert(0).first = 5;
  *table.Insert(-1).first = 6;
  EXPECT_EQ(*table.Find(0), 5);
  EXPECT_EQ(*table.Find(-1), 6);
  EXPECT_EQ(table.size(), 3u);
}

}  // namespace
}  // namespace gw
