#include "tools/lab/eval/trajectory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "common/process/event_log.h"
#include "common/wire/channels.h"
#include "common/wire/wire.h"

namespace gw::eval {
namespace {

using testing::HasSubstr;

TEST(Tum, ReadsCommentsBlankLinesAndAnyWhitespace) {
  const auto t = ParseTum(
      "# ground truth\n\n1305031228.513250 1.5 -2 3e-1  0 0 0.6 0.8 # first\r\n"
      "\t1305031229.5 1 2 3 0 0 0 -1\n",
      "a.tum");
  ASSERT_TRUE(t.ok()) << t.error().message;
  ASSERT_EQ(t->size(), 2u);
  EXPECT_EQ((*t)[0].utime.us, 1305031228513250);
  EXPECT_EQ((*t)[0].T.translation(), Eigen::Vector3d(1.5, -2, 0.3));
  EXPECT_NEAR((*t)[0].T.rotation().z(), 0.6, 1e-15);
  EXPECT_NEAR((*t)[0].T.rotation().w(), 0.8, 1e-15);
}

TEST(Tum, FileWithoutPosesIsEmpty) {
  EXPECT_TRUE(ParseTum("", "a.tum")->empty());
  EXPECT_TRUE(ParseTum("# t x y z\n", "a.tum")->empty());
}

struct BadCase {
  const char* name;
  const char* line;  // comes second
  const char* message;
};
class TumRefuses : public testing::TestWithParam<BadCase> {};

TEST_P(TumRefuses, BadLineByNumber) {
  const auto t = ParseTum(std::string("1 0 0 0 0 0 0 1\n") + GetParam().line + "\n", "a.tum");
  ASSERT_FALSE(t.ok());
  EXPECT_EQ(t.error().code, ErrorCode::kBadData);
  EXPECT_THAT(t.error().message, HasSubstr(std::string("a.tum:2: ") + GetParam().message));
}

TEST(ParseTum, AByteOrderMarkIsNoPartOfTheFirstTime) {
  const auto trajectory = ParseTum(
      "\xEF\xBB\xBF"
      "1 0 0 0 0 0 0 1\r\n",
      "a.tum");
  ASSERT_TRUE(trajectory) << trajectory.error().message;
  EXPECT_EQ(trajectory->front().utime.us, 1000000);
}

INSTANTIATE_TEST_SUITE_P(
    Rules, TumRefuses,
    testing::Values(BadCase{"TooFew", "2 0 0 0 0 0 0", "has 7 of 8 columns"},
                    BadCase{"TooMany", "2 0 0 0 0 0 0 1 7", "more than 8 columns"},
                    BadCase{"Words", "2 0 zero 0 0 0 0 1", "'zero' is not a finite number"},
                    BadCase{"NaN", "2 0 nan 0 0 0 0 1", "'nan' is not a finite number"},
                    BadCase{"Infinity", "2 0 -inf 0 0 0 0 1", "'-inf' is not a finite number"},
                    BadCase{"Commas", "2,0,0,0,0,0,0,1", "'2,0,0,0,0,0,0,1' is not a finite"},
                    BadCase{"NotUnit", "2 0 0 0 0 0 0 1.1", "quaternion (columns 5 to 8) is not"},
                    BadCase{"ZeroQuaternion", "2 0 0 0 0 0 0 0",
                            "quaternion (columns 5 to 8) is 0 0 0 0"},
                    BadCase{"Repeated", "1.0000001 0 0 0 0 0 0 1", "time repeats that of"},
                    BadCase{"Backwards", "0.5 0 0 0 0 0 0 1", "time does not increase"},
                    BadCase{"Nanoseconds", "1e18 0 0 0 0 0 0 1", "time is not in seconds"}),
    [](const auto& test_case) { return test_case.param.name; });

TEST(Tum, MissingFileIsNamed) {
  const auto t = ReadTum("no/such.tum");
  ASSERT_FALSE(t.ok());
  EXPECT_EQ(t.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(t.error().message, HasSubstr("no/such.tum: cannot open"));
}

std::string WriteLog(const std::vector<GroundTruth>& truths) {
  const std::string path = testing::TempDir() + "eval_ground_truth.lcm";
  auto log = process::EventLogWriter::Create(path);
  EXPECT_TRUE(log.ok());
  for (const GroundTruth& truth : truths) {
    EXPECT_TRUE(log->Append(truth.utime, wire::kHealth, wire::Encode(Health{})).ok());
    EXPECT_TRUE(log->Append(truth.utime, wire::kGroundTruth, wire::Encode(truth)).ok());
  }
  EXPECT_TRUE(log->Close().ok());
  return path;
}

TEST(GroundTruthLog, GivesItsPosesInOrder) {
  const SE3 T(ExpSO3({0.1, 0.2, 0.3}), {1, 2, 3});
  const auto t = ReadReference(WriteLog({{{1000}, 1, SE3()}, {{2000}, 2, T}}));
  ASSERT_TRUE(t.ok()) << t.error().message;
  ASSERT_EQ(t->size(), 2u);
  EXPECT_EQ((*t)[1].utime.us, 2000);
  EXPECT_EQ((*t)[1].T.translation(), T.translation());
}

TEST(GroundTruthLog, RefusesTimesThatDoNotIncreaseAndLogsWithoutTruth) {
  const auto repeated = ReadReference(WriteLog({{{1000}, 1, SE3()}, {{1000}, 2, SE3()}}));
  EXPECT_THAT(repeated.error().message, HasSubstr("event 3: time of the ground truth does not"));
  EXPECT_THAT(ReadReference(WriteLog({})).error().message, HasSubstr("holds no GROUND_TRUTH"));
  EXPECT_EQ(ReadReference("no/such.lcm").error().code, ErrorCode::kNotFound);
}

TEST(FrameTimes, ReadsTheFirstColumn) {
  const std::string path = testing::TempDir() + "eval_frames.csv";
  std::ofstream(path) << "utime,status\n100,2\n200,2\n";
  const auto times = ReadFrameTimes(path);
  ASSERT_TRUE(times.ok()) << times.error().message;
  EXPECT_THAT(*times, testing::ElementsAre(Utime{100}, Utime{200}));
  std::ofstream(path) << "time,status\n100,2\n";
  EXPECT_THAT(ReadFrameTimes(path).error().message, HasSubstr(":1: the first column"));
  std::ofstream(path) << "utime,status\n1.5,2\n";
  EXPECT_THAT(ReadFrameTimes(path).error().message, HasSubstr(":2: utime is not an integer"));
}

}  // namespace
}  // namespace gw::eval
