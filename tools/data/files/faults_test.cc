#include "tools/data/files/faults.h"

#include <gtest/gtest.h>

namespace gw::tools {
namespace {

TEST(Faults, AllAreToldOnceInTheirOrder) {
  Faults faults;
  EXPECT_TRUE(faults.empty());
  EXPECT_TRUE(faults.Verdict());
  EXPECT_TRUE(faults.Passed(Result<int>(3)));
  EXPECT_FALSE(faults.Passed(Result<int>(Error{ErrorCode::kNotFound, "b.txt: not there"})));
  faults.Add({ErrorCode::kBadData, "a.txt:1: no\na.txt:2: number"});
  faults.Add({ErrorCode::kBadData, "b.txt: not there"});
  EXPECT_FALSE(faults.Verdict());
  EXPECT_EQ(faults.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(faults.error().message, "b.txt: not there\na.txt:1: no\na.txt:2: number");
}

TEST(Faults, TooManyAreCounted) {
  Faults faults;
  for (int i = 0; i < 1000; ++i) faults.Add({ErrorCode::kBadData, std::to_string(i)});
  EXPECT_EQ(faults.error().message.substr(0, 4), "0\n1\n");
  EXPECT_EQ(faults.error().message.substr(faults.error().message.rfind('\n')), "\nand 980 more");
}

}  // namespace
}  // namespace gw::tools
