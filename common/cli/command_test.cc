#include "common/cli/command.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "common/core/exit_code.h"

namespace gw::cli {
namespace {

std::optional<int> Parse(Command& program, std::vector<std::string> words) {
  words.insert(words.begin(), "program");
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  return program.Parse(static_cast<int>(argv.size()), argv.data());
}

enum class Colour { kRed, kGreen };

struct Arguments {
  std::string in;
  int number = 5;
  bool fast = false, slow = false;
  std::vector<double> lengths;
  Colour colour = Colour::kRed;
  std::filesystem::path out;
};

// A program with one option of each kind, and the code with which it ends.
std::optional<int> ParseAll(const std::vector<std::string>& words, Arguments* a) {
  Command program("test");
  program.AddOption("IN", a->in, "file")->Required();
  program.AddOption("--number", a->number, "how many")->InRange(1, 9);
  Option* const fast = program.AddFlag("--fast", a->fast, "quick");
  program.AddFlag("--slow", a->slow, "not quick")->Excludes(fast);
  program.AddOption("--lengths", a->lengths, "m")->Separator(',')->NumValues(3);
  program.AddChoice<Colour>("--colour", a->colour,
                            {{"red", Colour::kRed}, {"green", Colour::kGreen}}, "of it");
  program.AddOption("--out", a->out, "folder");
  return Parse(program, words);
}

TEST(Command, ReadsEveryKindOfOption) {
  Arguments a;
  EXPECT_EQ(ParseAll({"x.lcm", "--number", "9", "--fast", "--lengths", "1,2,0.5", "--colour",
                      "Green", "--out", "x/y"},
                     &a),
            std::nullopt);
  EXPECT_EQ(a.in, "x.lcm");
  EXPECT_EQ(a.number, 9);
  EXPECT_TRUE(a.fast);
  EXPECT_FALSE(a.slow);
  EXPECT_EQ(a.lengths, (std::vector<double>{1, 2, 0.5}));
  EXPECT_EQ(a.colour, Colour::kGreen);
  EXPECT_EQ(a.out, "x/y");
}

TEST(Command, WhatIsWrongIsUsage) {
  const std::vector<std::vector<std::string>> wrong = {{},
                                                       {"x", "--number", "10"},
                                                       {"x", "--number", "one"},
                                                       {"x", "--fast", "--slow"},
                                                       {"x", "--lengths", "1,2"},
                                                       {"x", "--colour", "blue"},
                                                       {"x", "--unknown"}};
  for (const auto& words : wrong) {
    Arguments a;
    EXPECT_EQ(ParseAll(words, &a), kExitUsage)
        << words.size() << " " << (words.empty() ? "" : words.back());
  }
}

TEST(Command, HelpAndVersionEndWell) {
  for (const char* flag : {"--help", "--version"}) {
    Arguments a;
    EXPECT_EQ(ParseAll({flag}, &a), kExitOk);
  }
}

TEST(Command, OneOfTheSubcommandsIsGiven) {
  Command program("test");
  program.RequireCommands(1, 1);
  std::string log;
  bool called = false;
  Command* const info = program.AddCommand("info", "says");
  Command* const cut = program.AddCommand("cut", "cuts");
  info->AddOption("LOG", log, "log")->Required();
  info->WhenGiven([&called] { called = true; });
  EXPECT_EQ(Parse(program, {"info", "x.lcm"}), std::nullopt);
  EXPECT_TRUE(info->given());
  EXPECT_FALSE(cut->given());
  EXPECT_TRUE(called);
  EXPECT_EQ(log, "x.lcm");
  EXPECT_EQ(program.Missing("--out"), kExitUsage);
}

TEST(Command, WithoutItsSubcommandIsUsage) {
  Command program("test");
  program.RequireCommands(1, 1);
  program.AddCommand("info", "says");
  EXPECT_EQ(Parse(program, {}), kExitUsage);
}

}  // namespace
}  // namespace gw::cli
