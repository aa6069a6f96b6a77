// Result<T>: a value, or an Error that says what went wrong, where, and what to do about it.
// For start-up and input/output. In the hot path outcomes are data (a status, a counter), not
// errors.
#pragma once

#include <string>
#include <utility>
#include <variant>

#include "common/core/check.h"

namespace gw {

// What kind of failure; programs map it to their exit code (see common/core/exit_code.h).
enum class ErrorCode {
  kInvalidArgument,  // a caller's value is out of range
  kBadConfig,        // configuration or calibration is wrong: exit 78
  kNotFound,         // a file or device is not there
  kBadData,          // a file or message does not hold what it should
  kIo,               // reading or writing failed (permissions, full disk)
};

struct Error {
  ErrorCode code = ErrorCode::kInvalidArgument;
  std::string message;  // one sentence: what, where (file:line), and what to do
};

template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::move(value)) {}      // NOLINT: implicit by design
  Result(Error error) : state_(std::move(error)) {}  // NOLINT: implicit by design

  bool ok() const { return std::holds_alternative<T>(state_); }
  explicit operator bool() const { return ok(); }

  // Precondition: ok().
  const T& value() const& {
    GW_CHECK(ok());
    return std::get<T>(state_);
  }
  T& value() & {
    GW_CHECK(ok());
    return std::get<T>(state_);
  }
  T&& value() && {
    GW_CHECK(ok());
    return std::get<T>(std::move(state_));
  }
  const T& operator*() const& { return value(); }
  T& operator*() & { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  const T* operator->() const { return &value(); }
  T* operator->() { return &value(); }

  // Precondition: !ok().
  const Error& error() const {
    GW_CHECK(!ok());
    return std::get<Error>(state_);
  }

 private:
  std::variant<T, Error> state_;
};

// The result of an action without a value: Result<Done> Save(...) { ...; return Done{}; }
struct Done {};

}  // namespace gw
