#include "tools/lab/bench_suite/other_methods.h"

#include <cmath>
#include <filesystem>

#include "common/config/loader.h"
#include "common/process/event_log.h"
#include "common/wire/channels.h"
#include "common/wire/wire.h"
#include "tools/lab/eval/evaluate.h"

namespace gw::bench {
namespace {

std::string Replaced(std::string text, const std::string& what, const std::string& by) {
  for (size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size())) {
    text.replace(at, what.size(), by);
  }
  return text;
}

measure::Measures Score(const eval::Trajectory& estimate, const InputTruth& truth,
                        eval::Alignment alignment) {
  measure::Measures m;
  m.images = truth.images;
  const double silent = 1 - eval::Completeness(truth.T_GB, estimate);
  m.lost = std::llround(silent * static_cast<double>(truth.images));
  eval::EvalOptions options;
  options.alignment = alignment;
  const auto evaluation = eval::Evaluate(truth.T_GB, estimate, options);
  if (!evaluation) return m;
  m.ape_live_m = evaluation->ape_translation_m.rmse;
  if (evaluation->rpe_translation_m.count > 0) {
    m.rpe_m = evaluation->rpe_translation_m.rmse;
    m.rpe_deg = evaluation->rpe_rotation_deg.rmse;
  }
  return m;
}

}  // namespace

Result<InputTruth> ReadInputTruth(const std::string& path) {
  auto truth = eval::ReadGroundTruthLog(path);
  if (!truth) return truth.error();
  InputTruth out;
  out.T_GB = *std::move(truth);
  auto log = process::EventLogReader::Open(path);
  if (!log) return log.error();
  while (const auto event = log->Next()) out.images += event->channel == wire::kCamera ? 1 : 0;
  if (log->error()) return *log->error();
  return out;
}

Result<std::vector<CellResult>> ScoreOther(const OtherMethod& method, int runs,
                                           const PreparedInput& input, const InputTruth& truth,
                                           eval::Alignment alignment) {
  const auto config = LoadRobotConfig(input.config);
  if (!config) return config.error();
  const SE3 T_CB = method.of_body ? SE3() : config->calibration.camera.T_BC.inverse();
  const bool numbered = method.pattern.find("{run}") != std::string::npos;
  std::vector<CellResult> out;
  for (int run = 0; run < (numbered ? runs : 1); ++run) {
    CellResult& result = out.emplace_back();
    result.input = input.name;
    result.variant = method.name;
    result.seed = run;
    result.external = true;
    result.log = std::filesystem::path(input.log).filename().string();
    result.log_hash = input.log_hash;
    const std::string path =
        Replaced(Replaced(method.pattern, "{sequence}", input.name), "{run}", std::to_string(run));
    auto trajectory = eval::ReadTum(path);
    if (!trajectory) {
      result.failure = trajectory.error().message;
      continue;
    }
    for (eval::TimedPose& pose : *trajectory) pose.T = pose.T * T_CB;
    result.measures = Score(*trajectory, truth, alignment);
  }
  return out;
}

}  // namespace gw::bench
