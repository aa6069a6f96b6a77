#include "common/cli/command.h"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "common/core/exit_code.h"
#include "common/core/version.h"

namespace gw::cli {

Option* Option::Required(bool required) {
  option_->required(required);
  return this;
}

Option* Option::Needs(Option* other) {
  option_->needs(other->option_);
  return this;
}

Option* Option::Excludes(Option* other) {
  option_->excludes(other->option_);
  return this;
}

template <Number T>
Option* Option::InRange(T lowest, T highest) {
  option_->check(CLI::Range(lowest, highest));
  return this;
}
template Option* Option::InRange(int, int);
template Option* Option::InRange(int64_t, int64_t);
template Option* Option::InRange(double, double);

Option* Option::Positive() {
  option_->check(CLI::PositiveNumber);
  return this;
}

Option* Option::NotNegative() {
  option_->check(CLI::NonNegativeNumber);
  return this;
}

Option* Option::ExistingFolder() {
  option_->check(CLI::ExistingDirectory);
  return this;
}

Option* Option::OneOf(const std::vector<std::string>& values) {
  option_->check(CLI::IsMember(values));
  return this;
}

Option* Option::Separator(char between) {
  option_->delimiter(between);
  return this;
}

Option* Option::NumValues(int number) {
  option_->expected(number);
  return this;
}

Option* Option::ShowDefault() {
  option_->capture_default_str();
  return this;
}

Command::Command(const std::string& description, const std::string& name)
    : program_(std::make_unique<CLI::App>(description, name)), app_(program_.get()) {
  app_->set_version_flag("--version", Version());
}

Command::Command(CLI::App* subcommand) : app_(subcommand) {}

Command::~Command() = default;

Option* Command::Keep(CLI::Option* option) {
  return options_.emplace_back(std::make_unique<Option>(option)).get();
}

template <Value T>
Option* Command::AddOption(const std::string& name, T& value, const std::string& help) {
  return Keep(app_->add_option(name, value, help));
}
template Option* Command::AddOption(const std::string&, int&, const std::string&);
template Option* Command::AddOption(const std::string&, int64_t&, const std::string&);
template Option* Command::AddOption(const std::string&, std::optional<int>&, const std::string&);
template Option* Command::AddOption(const std::string&, std::optional<int64_t>&,
                                    const std::string&);
template Option* Command::AddOption(const std::string&, std::optional<double>&, const std::string&);
template Option* Command::AddOption(const std::string&, uint64_t&, const std::string&);
template Option* Command::AddOption(const std::string&, double&, const std::string&);
template Option* Command::AddOption(const std::string&, std::string&, const std::string&);
template Option* Command::AddOption(const std::string&, std::vector<std::string>&,
                                    const std::string&);
template Option* Command::AddOption(const std::string&, std::vector<double>&, const std::string&);

Option* Command::AddText(const std::string& name,
                         const std::function<void(const std::string&)>& take,
                         const std::string& help) {
  return Keep(app_->add_option_function<std::string>(name, take, help));
}

Option* Command::AddFlag(const std::string& name, bool& value, const std::string& help) {
  return Keep(app_->add_flag(name, value, help));
}

Option* Command::AddChoiceOf(const std::string& name, const std::vector<std::string>& words,
                             const std::function<void(size_t)>& choose, const std::string& help) {
  const auto chosen = [words, choose](const std::string& word) {
    choose(static_cast<size_t>(std::find(words.begin(), words.end(), word) - words.begin()));
  };
  // As a transformation it also puts the word as it is in the list.
  return Keep(app_->add_option_function<std::string>(name, chosen, help)
                  ->transform(CLI::IsMember(words, CLI::ignore_case)));
}

Command* Command::AddCommand(const std::string& name, const std::string& help) {
  commands_.emplace_back(new Command(app_->add_subcommand(name, help)));
  return commands_.back().get();
}

void Command::WhenGiven(const std::function<void()>& action) {
  app_->callback(action);
}

void Command::Footer(const std::string& text) {
  app_->footer(text);
}

void Command::RequireCommands(int least, int most) {
  app_->require_subcommand(static_cast<size_t>(least), static_cast<size_t>(most));
}

void Command::RequireOptions(int number) {
  app_->require_option(number);
}

std::optional<int> Command::Parse(int argc, char** argv) {
  try {
    app_->parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app_->exit(error) == 0 ? kExitOk : kExitUsage;
  }
  return std::nullopt;
}

bool Command::given() const {
  return app_->parsed();
}

int Command::Missing(const std::string& name) const {
  app_->exit(CLI::RequiredError(name));
  return kExitUsage;
}

}  // namespace gw::cli
