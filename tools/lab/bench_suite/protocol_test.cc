#include "tools/lab/bench_suite/protocol.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/lab/bench_suite/report.h"

namespace gw::bench {
namespace {

using testing::HasSubstr;
using testing::Not;

CellResult OneRun(const std::string& input, const std::string& variant, int seed,
                  std::optional<double> ape, int64_t lost = 0) {
  CellResult r;
  r.input = input;
  r.variant = variant;
  r.seed = seed;
  r.log = input + ".lcm";
  r.log_hash = "abc";
  r.slam_hash = "def";
  r.origin = {"cfg_" + variant, "0.1.0", false};
  measure::Measures m;
  m.images = 100;
  m.lost = lost;
  m.ape_live_m = ape;
  m.ape_dr_m = 0.5;
  r.measures = m;
  return r;
}

CellResult Crash(const std::string& input, const std::string& variant) {
  CellResult r = OneRun(input, variant, 0, std::nullopt);
  r.measures.reset();
  r.failure = "gw-slam: exit 1: no";
  return r;
}

TEST(Protocol, ARunFailsByItsErrorItsTrackingOrACrash) {
  EXPECT_FALSE(RunFailed(OneRun("a", "full", 0, 10.0, 50)));
  EXPECT_TRUE(RunFailed(OneRun("a", "full", 0, 10.001)));
  EXPECT_TRUE(RunFailed(OneRun("a", "full", 0, 0.1, 51)));
  EXPECT_TRUE(RunFailed(OneRun("a", "full", 0, std::nullopt)));
  EXPECT_TRUE(RunFailed(Crash("a", "full")));
}

TEST(Protocol, OneBadRunFailsTheSequence) {
  const std::vector<CellResult> results = {OneRun("a", "full", 0, 0.1), OneRun("a", "full", 1, 0.3),
                                           OneRun("b", "full", 0, 0.1), OneRun("b", "full", 1, 11)};
  const auto sequences = Sequences(results);
  ASSERT_EQ(sequences.size(), 2u);
  EXPECT_FALSE(sequences[0].failed());
  EXPECT_TRUE(sequences[1].failed());
  const auto ape = [](const measure::Measures& m) { return m.ape_live_m; };
  EXPECT_DOUBLE_EQ(*sequences[0].Mean(ape), 0.2);
  EXPECT_DOUBLE_EQ(*sequences[0].Min(ape), 0.1);
  EXPECT_DOUBLE_EQ(*sequences[0].Max(ape), 0.3);
}

TEST(Protocol, CompletenessCountsBeforeAccuracy) {
  const std::vector<CellResult> results = {
      OneRun("a", "none", 0, 0.01), OneRun("a", "da", 0, 0.3), OneRun("a", "full", 0, 0.2),
      OneRun("b", "none", 0, 20),   OneRun("b", "da", 0, 0.3), OneRun("b", "full", 0, 0.2)};
  const auto ranked = Rank(Sequences(results), {});
  ASSERT_EQ(ranked.size(), 4u);
  EXPECT_EQ(ranked[0].variant, "full");
  EXPECT_EQ(ranked[1].variant, "da");
  EXPECT_EQ(ranked[2].variant, kDrAlone);
  EXPECT_DOUBLE_EQ(*ranked[2].mean_ape_m, 0.5);
  EXPECT_EQ(ranked[2].total, 2);
  EXPECT_EQ(ranked[3].variant, "none");
  EXPECT_EQ(ranked[3].finished, 1);
  EXPECT_DOUBLE_EQ(*ranked[3].mean_ape_m, 0.01);
}

TEST(Protocol, AMethodThatFinishesNothingHasNoError) {
  const std::vector<CellResult> results = {Crash("a", "none")};
  const auto ranked = Rank(Sequences(results), {});
  ASSERT_EQ(ranked.size(), 1u);
  EXPECT_EQ(ranked[0].finished, 0);
  EXPECT_FALSE(ranked[0].mean_ape_m);
}

TEST(Protocol, PublishedRowsAreRankedAndStarred) {
  const std::vector<CellResult> results = {OneRun("a", "full", 0, 0.3)};
  const std::vector<PublishedRow> published = {{"P", std::nullopt, 0.01, "p (2024)"},
                                               {"Q", 1.0, 0.2, "q (2025)"},
                                               {"R", 0.8, std::nullopt, "q (2025)"}};
  const auto ranked = Rank(Sequences(results), published);
  std::vector<std::string> order;
  for (const Ranked& r : ranked) order.push_back(r.variant);
  EXPECT_THAT(order, testing::ElementsAre("Q*", "full", kDrAlone, "R*", "P*"));
  BenchReport report;
  report.suite.name = "with literature";
  report.suite.published = published;
  report.results = results;
  const std::string table = RenderMarkdown(report);
  for (const char* text : {"| Q* | 100 % | 0.20 |", "| R* | 80 % | - |", "| P* | - | 0.01 |",
                           "* p (2024): P\n", "* q (2025): Q, R\n", "not run here"}) {
    EXPECT_THAT(table, HasSubstr(text));
  }
  EXPECT_THAT(DrawRanking(report).svg, HasSubstr("R*"));
}

TEST(BenchReport, ManyVariantsStandBelowEachOther) {
  BenchReport report;
  report.suite.name = "many";
  for (int i = 0; i < 13; ++i) report.results.push_back(OneRun("a", "v" + std::to_string(i), 0, i));
  const std::string table = RenderMarkdown(report);
  for (const char* text : {"| variant | a |\n", "| DR alone | 0.500 |\n", "| v7 | 7.000 |\n"}) {
    EXPECT_THAT(table, HasSubstr(text));
  }
}

TEST(BenchReport, SaysWhereTheNumbersComeFromAndWhatFailed) {
  BenchReport report;
  report.suite.name = "two";
  report.suite.runs = 1;
  report.results = {OneRun("a", "full", 0, 0.25), OneRun("a", "none", 0, 3.0, 80),
                    Crash("b", "full")};
  report.results[0].origin.dr_synthetic = true;
  const std::string table = RenderMarkdown(report);
  for (const char* text :
       {"| full | 1 / 2 | 0.2500 |", "| a | 0.500 | 0.250 | 3.000 **failed**, tracked 20 % |",
        "a.lcm | abc | **synthetic** | full cfg_full, none cfg_none", "binary def",
        "* b, full, seed 0: gw-slam: exit 1: no"}) {
    EXPECT_THAT(table, HasSubstr(text));
  }
  const std::string csv = RenderCsv(report);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 4);
  const size_t columns = std::count(csv.begin(), csv.begin() + csv.find('\n'), ',');
  size_t begin = 0;
  while (begin < csv.size()) {
    const size_t end = csv.find('\n', begin);
    EXPECT_EQ(std::count(csv.begin() + begin, csv.begin() + end, ','), columns);
    begin = end + 1;
  }
  const std::string plot = DrawRanking(report).svg;
  for (const char* text : {">50 %<", ">0.250<", "cfg_full", "a.lcm", "0.1.0"}) {
    EXPECT_THAT(plot, HasSubstr(text));
  }
  EXPECT_THAT(plot, Not(HasSubstr("nan")));
  EXPECT_THAT(DrawInputs(report).svg, HasSubstr(">3.000 failed<"));
}

}  // namespace
}  // namespace gw::bench
