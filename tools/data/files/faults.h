// Everything that is wrong with an input, so that a user sees all of it at once and not one fault
// for each attempt.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/core/result.h"

namespace gw::tools {

class Faults {
 public:
  void Add(const Error& error);
  // Takes over the error of a step, if it has one; true when the step went well.
  template <typename T>
  bool Passed(const Result<T>& step) {
    if (!step) Add(step.error());
    return step.ok();
  }

  bool empty() const { return !first_code_.has_value(); }
  // One fault a line, in the order in which they were added, each once; of more than kMostLines
  // the others are counted. Its code is that of the first. Precondition: not empty.
  Error error() const;
  // The same as a result: Done when there is none.
  Result<Done> Verdict() const;

  static constexpr size_t kMostLines = 20;

 private:
  std::optional<ErrorCode> first_code_;
  std::vector<std::string> lines_;
  size_t more_ = 0;
};

}  // namespace gw::tools
