#include "common/process/log_line.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace gw::process {
namespace {

class LogLineTest : public ::testing::Test {
 protected:
  std::vector<std::string> lines_;
  LogLine log_{DurationUs{1'000'000}, [this](const std::string& line) { lines_.push_back(line); }};
};

TEST_F(LogLineTest, IsKeyValueWithTheJournalsPriority) {
  log_.Write(Utime{0}, Severity::kWarning, "camera.lost",
             {{"count", "3"}, {"action", "check the \"USB\" cable"}, {"empty", ""}});
  EXPECT_THAT(lines_,
              ::testing::ElementsAre("<4>event=camera.lost count=3 "
                                     "action=\"check the \\\"USB\\\" cable\" empty=\"\"\n"));
}

TEST_F(LogLineTest, StaysOneLineWhateverTheValueHolds) {
  log_.Write(Utime{0}, Severity::kError, "bad", {{"text", "two\nlines\r\t"}});
  EXPECT_EQ(std::count(lines_[0].begin(), lines_[0].end(), '\n'), 1);
}

TEST_F(LogLineTest, OneEventIsWrittenOncePerIntervalAndSaysHowManyWereNot) {
  for (int i = 0; i < 100; ++i) log_.Write(Utime{i * 10'000}, Severity::kInfo, "a");
  log_.Write(Utime{500'000}, Severity::kInfo, "b");  // others are not held back
  log_.Write(Utime{1'000'000}, Severity::kInfo, "a");
  log_.Write(Utime{2'000'000}, Severity::kInfo, "a");
  EXPECT_THAT(lines_, ::testing::ElementsAre("<6>event=a\n", "<6>event=b\n",
                                             "<6>event=a suppressed=99\n", "<6>event=a\n"));
}

}  // namespace
}  // namespace gw::process
