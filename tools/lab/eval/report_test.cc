#include "tools/lab/eval/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/data/files/json.h"
#include "tools/lab/eval/test_trajectories.h"

namespace gw::eval {
namespace {

using testing::HasSubstr;

EvalReport SmallReport() {
  EvalReport report;
  report.ref_name = "gt.tum";
  report.est_name = "a \"b\".tum";
  report.options.alignment = Alignment::kNone;
  const Trajectory ref = {At(0, 0, 0), At(1, 1, 0), At(2, 2, 0)};
  const Trajectory est = {At(0, 0, 0.2), At(1, 1, 0.2), At(2, 2, 0.2)};
  report.frames = *Evaluate(ref, est, report.options);
  report.keyframes = *Evaluate(ref, {At(0, 0, 0.1), At(2, 2, 0.1)}, report.options);
  report.images = 4;
  report.coverage = 0.75;
  return report;
}

TEST(Report, TableShowsWhatWasMeasured) {
  const std::string table = RenderTable(SmallReport());
  EXPECT_THAT(table, HasSubstr("APE translation (m)            0.2000     0.2000     0.2000"));
  EXPECT_THAT(table, HasSubstr("75.0 % of 4 images"));
  EXPECT_THAT(table, HasSubstr("R(F/KF)                     2.000"));
}

TEST(Report, JsonHoldsTheSameAndEscapesNames) {
  const auto json = tools::Json::parse(RenderJson(SmallReport()));
  EXPECT_EQ(json["estimate"], "a \"b\".tum");
  EXPECT_EQ(json["ape"]["translation_m"]["count"], 3);
  EXPECT_NEAR(json["ape"]["translation_m"]["rmse"].get<double>(), 0.2, 1e-12);
  EXPECT_EQ(json["coverage"], 0.75);
  EXPECT_NEAR(json["frame_to_keyframe_ratio"].get<double>(), 2, 1e-12);
}

TEST(Report, AbsentValuesAreNull) {
  EvalReport report;
  report.options.alignment = Alignment::kNone;
  report.frames = *Evaluate({At(1, 0, 0)}, {At(1, 3, 4)}, report.options);
  const auto json = tools::Json::parse(RenderJson(report));
  EXPECT_TRUE(json.at("coverage").is_null());
  EXPECT_TRUE(json.at("drift").at("final_percent").is_null());
  EXPECT_TRUE(json.at("frame_to_keyframe_ratio").is_null());
  EXPECT_THAT(RenderTable(report), HasSubstr("RPE 1 s translation (m)             -"));
}

TEST(Report, PlotHasFourPanelsAndShadesGaps) {
  const Trajectory ref = Eight(100, 0.1);
  Trajectory est = ref;
  est.erase(est.begin() + 30, est.begin() + 60);
  EvalReport report;
  report.frames = *Evaluate(ref, est, report.options);
  const std::string svg = RenderPlot(report, ref, est);
  for (const char* text : {"top view", "side view", "absolute position error",
                           "absolute rotation error", "no estimate"}) {
    EXPECT_THAT(svg, HasSubstr(text));
  }
  EXPECT_EQ(svg, RenderPlot(report, ref, est));
}

}  // namespace
}  // namespace gw::eval
