#include "tools/lab/check/check_log.h"

#include <algorithm>

#include "common/camera/camera_model.h"
#include "tools/data/files/format.h"
#include "tools/data/files/json.h"
#include "tools/lab/check/checks.h"

namespace gw::check {
namespace {

using tools::Format;

// Kinds of faults of the images with which nothing can be followed.
bool Hopeless(const Findings& findings) {
  return std::any_of(findings.begin(), findings.end(), [](const Finding& finding) {
    for (const char* id : {"image-size", "no-right-eye", "one-eye-twice", "eyes-swapped",
                           "no-depth", "depth-empty", "stamp-unit"}) {
      if (finding.id == id) return true;
    }
    return false;
  });
}

const char* SeverityName(Severity severity) {
  return severity == Severity::kError ? "error" : "warning";
}

std::string FactsText(const LogFacts& facts, const VisionRun* vision) {
  std::string text;
  for (const auto& [channel, stream] : facts.streams) {
    if (stream.times.size() < 2) continue;
    const double span = (stream.times.back() - stream.times.front()).seconds();
    text += Format("  %-8s %7d messages, %.1f s, %.1f Hz\n", channel, stream.times.size(), span,
                   span > 0 ? static_cast<double>(stream.times.size() - 1) / span : 0.0);
  }
  if (vision != nullptr) {
    text += Format("  vision   %7d images placed, %d without a pose after the first\n",
                   vision->poses.size() - static_cast<size_t>(vision->blind), vision->blind);
  }
  return text;
}

}  // namespace

Result<Report> CheckLog(const std::string& log, const RobotConfig& config, bool with_vision) {
  const Result<CameraGeometry> geometry = MakeCameraGeometry(config.calibration);
  if (!geometry) return geometry.error();
  const Result<LogFacts> facts = ReadLogFacts(log, *geometry);
  if (!facts) return facts.error();
  Report report;
  Findings& findings = report.findings;
  const auto append = [&](const Findings& more) {
    findings.insert(findings.end(), more.begin(), more.end());
  };
  append(CheckStreams(*facts, config));
  append(CheckInertial(*facts, config));
  MotionSources motion = MakeMotionSources(facts->imu, facts->wheels, nullptr, config.calibration);
  append(CheckImages(*facts, config, motion));
  std::optional<VisionRun> vision;
  if (with_vision && !facts->images.images.empty() && !Hopeless(findings)) {
    Result<VisionRun> run = RunVision(log, config);
    if (!run) return run.error();
    vision = *std::move(run);
    append(CheckBlindness(*vision));
    motion = MakeMotionSources(facts->imu, facts->wheels, &*vision, config.calibration);
  }
  append(CheckMotion(motion, config));
  std::stable_sort(findings.begin(), findings.end(),
                   [](const Finding& a, const Finding& b) { return a.severity < b.severity; });
  // Two checks may see one fault.
  findings.erase(std::unique(findings.begin(), findings.end(),
                             [](const Finding& a, const Finding& b) {
                               return a.id == b.id && a.severity == b.severity &&
                                      (a.id == "gyro-unit" || a.text == b.text);
                             }),
                 findings.end());
  report.facts = FactsText(*facts, vision ? &*vision : nullptr);
  return report;
}

std::string ReportText(const Report& report) {
  std::string text = report.facts;
  for (const Finding& finding : report.findings) {
    text += Format("%s [%s] %s\n      %s\n",
                   finding.severity == Severity::kError ? "ERROR  " : "warning", finding.id,
                   finding.text, finding.fix);
  }
  if (report.findings.empty()) text += "nothing found\n";
  return text;
}

std::string ReportLines(const Report& report) {
  std::string text;
  for (const Finding& finding : report.findings) {
    text += Format("%s\t%s\t%s\t%s\n", SeverityName(finding.severity), finding.id, finding.text,
                   finding.fix);
  }
  return text;
}

std::string ReportJson(const Report& report) {
  tools::Json list = tools::Json::array();
  for (const Finding& finding : report.findings) {
    list.push_back({{"severity", SeverityName(finding.severity)},
                    {"id", finding.id},
                    {"text", finding.text},
                    {"fix", finding.fix}});
  }
  return tools::JsonLine({{"program", "gw-check"}, {"findings", list}});
}

}  // namespace gw::check
