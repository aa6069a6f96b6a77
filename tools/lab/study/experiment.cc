#include "tools/lab/study/experiment.h"

#include <filesystem>
#include <utility>

#include "common/config/loader.h"
#include "common/config/writer.h"
#include "tools/data/files/hash_file.h"
#include "tools/data/files/text_file.h"
#include "tools/lab/plot/html_report.h"
#include "tools/lab/slam/variant.h"

namespace gw::study {

Result<Experiment> LoadExperiment(const std::string& log, const std::string& config) {
  Experiment out;
  out.path = log;
  out.name = std::filesystem::path(log).filename().string();
  auto robot = LoadRobotConfig(config);
  if (!robot) return robot.error();
  out.config = *std::move(robot);
  const auto hash = tools::HashFile(log);
  if (!hash) return hash.error();
  out.hash = tools::HashText(*hash);
  auto truth = eval::ReadGroundTruthLog(log);
  if (!truth) return truth.error();
  out.truth = *std::move(truth);
  return out;
}

Result<RobotConfig> ConfigFor(const Experiment& experiment, const std::string& variant) {
  RobotConfig config = experiment.config;
  const auto applied = tools::ApplyVariant(variant, &config.frontend);
  if (!applied) return applied.error();
  return config;
}

std::string ConfigHashText(const RobotConfig& config) {
  return tools::HashText(ConfigHash(config));
}

Result<tools::SlamSession> RunSession(
    const Experiment& experiment, const RobotConfig& config, const tools::LogRunOptions& options,
    const std::function<void(const tools::SlamSession&)>& after_event) {
  auto session = tools::SlamSession::Create(config);
  if (!session) return session.error();
  auto log = process::EventLogReader::Open(experiment.path);
  if (!log) return log.error();
  const auto done = tools::RunLog(*log, options, &*session, [&](const process::LogEvent&) {
    if (after_event) after_event(*session);
  });
  if (!done) return done.error();
  if (session->frames().empty()) {
    return Error{ErrorCode::kBadData,
                 experiment.path + ": no image in the span that can be used; see gw-log info"};
  }
  return session;
}

Result<measure::SlamRun> Run(Experiment* experiment, const std::string& variant,
                             const tools::LogRunOptions& options) {
  const auto config = ConfigFor(*experiment, variant);
  if (!config) return config.error();
  const auto session = RunSession(*experiment, *config, options);
  if (!session) return session.error();
  experiment->dr_synthetic |= session->dr_synthetic();
  return measure::RunOf(*session);
}

eval::Trajectory KeyframePoses(const backend::Map& map, const RectifiedCamera& camera) {
  const SE3 T_CB = camera.T_BC.inverse();
  eval::Trajectory out;
  for (const auto& [id, keyframe] : map.keyframes()) {
    out.push_back({keyframe.frame.utime, keyframe.frame.T_WC * T_CB});
  }
  return out;
}

std::string Describe(const Experiment& experiment) {
  return "log " + experiment.name + " (hash " + experiment.hash + ")" +
         (experiment.dr_synthetic ? ", synthetic dead reckoning" : "");
}

Result<Done> WriteStudy(const std::string& folder, const std::string& name,
                        const StudyFiles& files) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return Error{ErrorCode::kIo, folder + ": cannot be made: " + error.message()};
  const auto report = plot::RenderHtml("gw-study " + name, {files.drawing}, files.markdown);
  if (!report) return report.error();
  const std::pair<const char*, const std::string*> all[] = {{".md", &files.markdown},
                                                            {".csv", &files.csv},
                                                            {".svg", &files.drawing.svg},
                                                            {".html", &*report}};
  const std::string base = folder + "/" + name;
  for (const auto& [extension, text] : all) {
    const auto written = tools::WriteTextFile(base + extension, *text);
    if (!written) return written.error();
  }
  return Done{};
}

}  // namespace gw::study
