// An evaluation for people (table, plot) and for scripts (JSON).
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "tools/lab/eval/evaluate.h"

namespace gw::eval {

// Everything that one run of gw-eval found out.
struct EvalReport {
  std::string ref_name;
  std::string est_name;
  EvalOptions options;
  Evaluation frames;
  std::optional<int64_t> images;        // that should have a pose
  std::optional<double> coverage;       // share of them that have one
  std::optional<Evaluation> keyframes;  // final keyframes, against the same reference

  // R(F/KF): APE RMSE of the frames over that of the keyframes; above 1 means that the poses
  // published live are worse than the map that came out.
  std::optional<double> FrameToKeyframeRatio() const;
};

const char* AlignmentName(Alignment alignment);

std::string RenderTable(const EvalReport& report);
std::string RenderJson(const EvalReport& report);  // absent values are null
// Top view, side view, and both errors over time; stretches without estimate are shaded.
std::string RenderPlot(const EvalReport& report, const Trajectory& ref, const Trajectory& est);

}  // namespace gw::eval
