// The command line of a program: its options, flags and subcommands, and how it ends when they are
// wrong. CLI11 does the work; its headers are kept out of this one, because they take longer to
// compile than most programs.
#pragma once

#include <concepts>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace gw::cli {

template <typename T>
concept Number = std::same_as<T, int> || std::same_as<T, int64_t> || std::same_as<T, double>;

// What an option can be read into.
template <typename T>
concept Value = Number<T> || std::same_as<T, std::optional<int>> ||
    std::same_as<T, std::optional<int64_t>> || std::same_as<T, std::optional<double>> ||
    std::same_as<T, uint64_t> || std::same_as<T, std::string> ||
    std::same_as<T, std::vector<std::string>> || std::same_as<T, std::vector<double>>;

// Anything else that text is assigned to.
template <typename T>
concept TakesText = !Value<T> && std::is_assignable_v<T&, const std::string&>;

// An option or flag of a command. Each function adds a rule that Parse checks, or changes how the
// option is read or shown, and returns the option, so that they can be chained.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  Option* Required(bool required = true);
  Option* Needs(Option* other);
  Option* Excludes(Option* other);
  template <Number T>
  Option* InRange(T lowest, T highest);
  Option* Positive();
  Option* NotNegative();
  Option* ExistingFolder();
  Option* OneOf(const std::vector<std::string>& values);
  Option* Separator(char between);  // of several values in one word
  Option* NumValues(int number);
  Option* ShowDefault();  // the value as it is now, in the help

 private:
  CLI::Option* option_;
};

// A program, or one of its subcommands. The pointers that it returns are valid as long as the
// program is, and the variables that are given to it must live until Parse has returned. An option
// is called "--name"; any other name, such as "LOG", is that of an argument by position.
class Command {
 public:
  explicit Command(const std::string& description, const std::string& name = "");
  ~Command();
  Command(const Command&) = delete;
  Command& operator=(const Command&) = delete;

  template <Value T>
  Option* AddOption(const std::string& name, T& value, const std::string& help);
  // The same for what takes text, such as a path.
  template <TakesText T>
  Option* AddOption(const std::string& name, T& value, const std::string& help) {
    return AddText(
        name, [&value](const std::string& text) { value = text; }, help);
  }
  Option* AddFlag(const std::string& name, bool& value, const std::string& help);
  // An option that is one of these words, in capitals or not.
  template <typename E>
  Option* AddChoice(const std::string& name, E& value,
                    const std::vector<std::pair<std::string, E>>& choices,
                    const std::string& help) {
    std::vector<std::string> words;
    for (const auto& choice : choices) words.push_back(choice.first);
    return AddChoiceOf(
        name, words, [&value, choices](size_t i) { value = choices[i].second; }, help);
  }
  Command* AddCommand(const std::string& name, const std::string& help);
  // Called by Parse when this subcommand was given.
  void WhenGiven(const std::function<void()>& action);

  void Footer(const std::string& text);
  void RequireCommands(int least, int most);
  void RequireOptions(int number);

  // Empty: go on. Else the code to exit with: help or version was asked for and is printed, or the
  // command line is wrong, which is said on stderr. `--version` is the project's.
  std::optional<int> Parse(int argc, char** argv);
  // After Parse: this subcommand was given.
  bool given() const;
  // After Parse: something is missing that is not always required. Says so as Parse does, and
  // returns the code to exit with.
  int Missing(const std::string& name) const;

 private:
  explicit Command(CLI::App* subcommand);
  Option* Keep(CLI::Option* option);
  Option* AddText(const std::string& name, const std::function<void(const std::string&)>& take,
                  const std::string& help);
  Option* AddChoiceOf(const std::string& name, const std::vector<std::string>& words,
                      const std::function<void(size_t)>& choose, const std::string& help);

  std::unique_ptr<CLI::App> program_;  // null: a subcommand
  CLI::App* app_;
  std::vector<std::unique_ptr<Option>> options_;
  std::vector<std::unique_ptr<Command>> commands_;
};

}  // namespace gw::cli
