// Exit codes of every program of the project. Documented in docs/programs.md.
#pragma once

#include "common/core/result.h"

namespace gw {

inline constexpr int kExitOk = 0;
inline constexpr int kExitFailed = 1;  // the work could not be done (I/O, bad data)
inline constexpr int kExitUsage = 2;   // the command line is wrong
inline constexpr int kExitBadConfig =
    78;  // configuration or calibration is wrong (sysexits EX_CONFIG)

inline int ExitCodeFor(const Error& error) {
  switch (error.code) {
    case ErrorCode::kBadConfig:
      return kExitBadConfig;
    case ErrorCode::kInvalidArgument:
      return kExitUsage;
    default:
      return kExitFailed;
  }
}

}  // namespace gw
