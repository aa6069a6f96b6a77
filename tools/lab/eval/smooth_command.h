// gw-eval smooth: a smooth way through a noisy trajectory, at a higher rate.
#pragma once

#include <string>

#include "common/cli/command.h"
#include "common/core/result.h"

namespace gw::eval {

struct SmoothArguments {
  std::string in, out;
  std::string gyro;    // log; empty: none
  std::string config;  // of its robot
  double rate_hz = 100;
  double spacing_s = 0;  // 0: by cross-validation
};

// The subcommand with its options.
cli::Command* AddSmoothCommand(cli::Command* app, SmoothArguments* args);

// Prints the leave-one-out residual for every spacing that was tried; writes the smooth trajectory.
Result<Done> RunSmooth(const SmoothArguments& args);

}  // namespace gw::eval
