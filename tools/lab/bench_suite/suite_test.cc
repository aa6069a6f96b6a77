#include "tools/lab/bench_suite/suite.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "common/config/departure.h"
#include "tools/data/files/text_file.h"

namespace gw::bench {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

Result<Suite> Load(const std::string& text) {
  const std::string path = testing::TempDir() + "gw_suite.yaml";
  EXPECT_TRUE(tools::WriteTextFile(path, text).ok());
  return LoadSuite(path, "/data");
}

TEST(Suite, EveryShippedSuiteLoadsAndItsScenariosAreThere) {
  const std::filesystem::path folder = std::string(GW_SOURCE_DIR) + "/config/suites";
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".yaml") continue;
    ++count;
    const auto suite = LoadSuite(entry.path().string(), "");
    ASSERT_TRUE(suite.ok()) << suite.error().message;
    EXPECT_EQ(suite->name, entry.path().stem().string());
    for (const SuiteInput& input : suite->inputs) {
      if (input.source != Source::kScenario) continue;
      EXPECT_TRUE(std::filesystem::exists(input.path)) << input.path;
    }
  }
  EXPECT_GE(count, 3);
}

TEST(Suite, EveryDepartureIsDocumentedAndMeasured) {
  const auto suite = LoadSuite(std::string(GW_SOURCE_DIR) + "/config/suites/departures.yaml", "");
  ASSERT_TRUE(suite.ok());
  const auto method = tools::ReadTextFile(std::string(GW_SOURCE_DIR) + "/docs/method.md");
  ASSERT_TRUE(method.ok());
  for (const NamedDeparture& d : kDepartures) {
    EXPECT_THAT(suite->variants, testing::Contains(std::string("paper:full+") + d.name));
    EXPECT_THAT(suite->variants, testing::Contains(std::string("full-") + d.name));
    EXPECT_THAT(*method, HasSubstr(std::string("| `") + d.name + "`"))
        << "docs/method.md, section 10";
  }
}

TEST(Suite, ReadsAllKindsOfInputs) {
  const auto suite = Load(
      "name: s\nruns: 3\nalign: yaw\nvariants: [none, 'fixed:10']\ninputs:\n"
      "- {name: a, log: l.lcm, config: ../r.yaml}\n"
      "- {name: b, scenario: x/y.yaml, options: [--seed, 2]}\n"
      "- {name: c, recording: tum_1, format: tum, fault: [--black, '1:2']}\n");
  ASSERT_TRUE(suite.ok()) << suite.error().message;
  EXPECT_EQ(suite->runs, 3);
  EXPECT_EQ(suite->alignment, eval::Alignment::kYaw);
  EXPECT_THAT(suite->variants, ElementsAre("none", "fixed:10"));
  ASSERT_EQ(suite->inputs.size(), 3u);
  EXPECT_EQ(suite->inputs[0].source, Source::kLog);
  EXPECT_EQ(suite->inputs[0].path, testing::TempDir() + "l.lcm");
  EXPECT_EQ(suite->inputs[1].source, Source::kScenario);
  EXPECT_EQ(suite->inputs[1].path, testing::TempDir() + "x/y.yaml");
  EXPECT_THAT(suite->inputs[1].options, ElementsAre("--seed", "2"));
  EXPECT_EQ(suite->inputs[2].source, Source::kImport);
  EXPECT_EQ(suite->inputs[2].path, "/data/tum_1");
  EXPECT_THAT(suite->inputs[2].fault, ElementsAre("--black", "1:2"));
}

TEST(Suite, ReadsSettingsOtherMethodsAndPublishedRows) {
  ASSERT_TRUE(tools::WriteTextFile(testing::TempDir() + "rows.yaml",
                                   "- {name: X, completeness_percent: 80, source: s, date: 2025}\n")
                  .ok());
  const auto suite = Load(
      "name: s\nvariants: [none]\npublished: rows.yaml\n"
      "methods: {orb: 'o/{sequence}.tum', vins: {path: '/v/{sequence}_{run}.tum', frame: body}}\n"
      "inputs:\n- {name: a, log: l.lcm, config: r.yaml, align: none, set: {frontend.matching: "
      "good}}\n");
  ASSERT_TRUE(suite.ok()) << suite.error().message;
  ASSERT_EQ(suite->methods.size(), 2u);
  EXPECT_EQ(suite->methods[0].pattern, testing::TempDir() + "o/{sequence}.tum");
  EXPECT_FALSE(suite->methods[0].of_body);
  EXPECT_TRUE(suite->methods[1].of_body);
  ASSERT_EQ(suite->published.size(), 1u);
  EXPECT_DOUBLE_EQ(*suite->published[0].completeness, 0.8);
  EXPECT_EQ(suite->published[0].source, "s (2025)");
  EXPECT_EQ(suite->inputs[0].alignment, eval::Alignment::kNone);
  EXPECT_THAT(suite->inputs[0].set, ElementsAre(testing::Pair("frontend.matching", "good")));

  ASSERT_TRUE(tools::WriteTextFile(testing::TempDir() + "rows.yaml", "- {name: X}\n").ok());
  const auto bad =
      Load("name: s\nvariants: [none]\npublished: rows.yaml\ninputs:\n- {name: a, scenario: s}\n");
  ASSERT_FALSE(bad.ok());
  EXPECT_THAT(bad.error().message, HasSubstr("rows.yaml:1: [0].source: missing"));
  const auto method =
      Load("name: s\nvariants: [none]\nmethods: {orb: o.tum}\ninputs:\n- {name: a, scenario: s}\n");
  EXPECT_THAT(method.error().message, HasSubstr("needs a path with {sequence}"));
}

TEST(Suite, AllMistakesAreReportedWithTheirLines) {
  const auto suite = Load(
      "name: s\nruns: 0\nvariants: [none, best, none]\ncolour: red\ninputs:\n"
      "- {name: a b, log: l.lcm}\n"
      "- {name: c, log: l.lcm, scenario: s.yaml}\n"
      "- {name: d, recording: r}\n"
      "- {name: d, scenario: s.yaml, format: tum, fault: black}\n");
  ASSERT_FALSE(suite.ok());
  EXPECT_EQ(suite.error().code, ErrorCode::kBadConfig);
  EXPECT_THAT(suite.error().message,
              AllOf(HasSubstr("gw_suite.yaml:2: runs"), HasSubstr("variant best: use none"),
                    HasSubstr("stands there twice"), HasSubstr(":4: colour: no such key"),
                    HasSubstr(":6: inputs[0].name"), HasSubstr(":6: inputs[0].config: missing"),
                    HasSubstr(":7: inputs[1]: needs exactly one"),
                    HasSubstr(":8: inputs[2].format: missing")));
  EXPECT_THAT(suite.error().message, AllOf(HasSubstr(":9: inputs[3].name: another input"),
                                           HasSubstr(":9: inputs[3].format: has no use here"),
                                           HasSubstr(":9: inputs[3].fault: must be a list")));
  EXPECT_EQ(Load("a: [").error().code, ErrorCode::kBadConfig);
  EXPECT_EQ(LoadSuite("/no/suite.yaml", "").error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace gw::bench
