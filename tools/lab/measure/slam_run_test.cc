#include "tools/lab/measure/slam_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "tools/data/files/text_file.h"

namespace gw::measure {
namespace {

using testing::HasSubstr;

constexpr char kFramesHead[] =
    "utime,status,n_det,n_trk,n_inliers,q,alpha,dr_share,map_revision,latency_us,"
    "x,y,z,qx,qy,qz,qw,reason\n";

std::string CovarianceHead() {
  std::string head = "utime";
  for (const char* name : {",c", ",m"}) {
    if (name[1] == 'm') head += ",motion_us";
    for (int i = 0; i < 6; ++i) {
      for (int j = i; j < 6; ++j) head += name + std::to_string(10 * i + j + 100).substr(1);
    }
  }
  return head + "\n";
}

// With the covariance of a motion in the second line only.
std::string CovarianceLine(int64_t utime) {
  std::string line = std::to_string(utime);
  for (int k = 0; k < 21; ++k) line += "," + std::to_string(k) + "e-3";
  const bool motion = utime > 1000000;
  line += motion ? ",33333" : ",0";
  for (int k = 0; k < 21; ++k) line += motion ? "," + std::to_string(k) + "e-4" : ",0";
  return line + "\n";
}

class RunFolder : public testing::Test {
 protected:
  RunFolder() {
    folder_ = testing::TempDir() + "gw_measure_run";
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    Write("report.json",
          "{\n \"version\": \"1.2.3\", \"config_hash\": \"00ff\",\n"
          " \"dr_synthetic\": true\n}\n");
    Write("frames.csv",
          std::string(kFramesHead) +
              "1000000,tracking,700,100,90,0.9,0.2,0.01,5,0,1,2,3,0,0,0,1,none\n"
              "1033333,dr_only,0,0,0,0,1000,1,5,0,1.5,2,3,0,0,0,1,too_few_features\n");
    Write("covariance.csv", CovarianceHead() + CovarianceLine(1000000) + CovarianceLine(1033333));
    Write("trajectory_final.tum", "1.000000 9 2 3 0 0 0 1\n1.033333 10 2 3 0 0 0 1\n");
    Write("dr.tum", "1.033333 7 0 0 0 0 0 1\n");
    Write("timing.csv", "utime,tracking_us\n1000000,1500\n1033333,2500\n");
  }
  void Write(const std::string& name, const std::string& text) {
    ASSERT_TRUE(tools::WriteTextFile(folder_ + "/" + name, text).ok());
  }
  Result<StoredRun> Read() { return ReadRun(folder_, folder_ + "/timing.csv"); }

  std::string folder_;
};

TEST_F(RunFolder, IsReadBack) {
  const auto stored = Read();
  ASSERT_TRUE(stored.ok()) << stored.error().message;
  EXPECT_EQ(stored->origin.version, "1.2.3");
  EXPECT_EQ(stored->origin.config_hash, "00ff");
  EXPECT_TRUE(stored->origin.dr_synthetic);
  const SlamRun& run = stored->run;
  ASSERT_EQ(run.frames.size(), 2u);
  EXPECT_EQ(run.frames[0].status, TrackingStatus::kTracking);
  EXPECT_EQ(run.frames[1].status, TrackingStatus::kDrOnly);
  EXPECT_EQ(run.frames[0].num_detected, 700);
  EXPECT_EQ(run.frames[0].num_tracked, 100);
  EXPECT_DOUBLE_EQ(run.frames[0].q, 0.9);
  EXPECT_DOUBLE_EQ(run.frames[1].T_WB.translation().x(), 1.5);
  EXPECT_DOUBLE_EQ(run.frames[1].cov_T_WB(0, 5), 5e-3);
  EXPECT_DOUBLE_EQ(run.frames[1].cov_T_WB(5, 0), 5e-3);
  EXPECT_DOUBLE_EQ(run.frames[1].cov_T_WB(5, 5), 20e-3);
  EXPECT_EQ(run.frames[0].motion_us, 0);
  EXPECT_EQ(run.frames[1].motion_us, 33333);
  EXPECT_DOUBLE_EQ(run.frames[1].cov_motion(5, 0), 5e-4);
  EXPECT_DOUBLE_EQ(run.final_T_WB[0].translation().x(), 9);
  EXPECT_FALSE(run.T_OB[0]);
  ASSERT_TRUE(run.T_OB[1]);
  EXPECT_DOUBLE_EQ(*run.ms[1], 2.5);
  EXPECT_EQ(run.DeadReckoning().size(), 1u);
}

TEST_F(RunFolder, MistakesAreNamedWithFileAndLine) {
  Write("frames.csv", std::string(kFramesHead) + "1000000,flying,700\n");
  EXPECT_THAT(Read().error().message, HasSubstr("frames.csv:2: must have 18 columns"));
  Write("frames.csv", std::string(kFramesHead) +
                          "1000000,flying,700,100,90,0.9,0.2,0.01,5,0,1,2,3,0,0,0,1,none\n");
  EXPECT_THAT(Read().error().message, HasSubstr("frames.csv:2:"));
  std::filesystem::remove(folder_ + "/frames.csv");
  EXPECT_EQ(Read().error().code, ErrorCode::kNotFound);
}

TEST_F(RunFolder, FilesMustBelongTogether) {
  Write("covariance.csv", CovarianceHead() + CovarianceLine(1000000));
  EXPECT_THAT(Read().error().message, HasSubstr("covariance.csv:3"));
  Write("covariance.csv", CovarianceHead() + CovarianceLine(1000000) + CovarianceLine(1033334));
  EXPECT_THAT(Read().error().message, HasSubstr("covariance.csv:3"));
  Write("covariance.csv", CovarianceHead() + CovarianceLine(1000000) + CovarianceLine(1033333));
  Write("trajectory_final.tum", "1.000000 9 2 3 0 0 0 1\n");
  EXPECT_THAT(Read().error().message, HasSubstr("trajectory_final.tum: has no pose at 1033333"));
  Write("report.json", "{}");
  EXPECT_THAT(Read().error().message, HasSubstr("report.json"));
}

}  // namespace
}  // namespace gw::measure
