// gw-calibrate-stereo: refines the right eye of a stereo camera from a recording in which it moves.
#include <chrono>
#include <cstdio>
#include <fstream>
#include <string>

#include "common/cli/command.h"
#include "common/config/loader.h"
#include "common/config/writer.h"
#include "common/core/exit_code.h"
#include "common/process/event_log.h"
#include "common/wire/channels.h"
#include "common/wire/wire.h"
#include "tools/robot/calibrate/refine_stereo.h"
#include "tools/robot/calibrate/stereo_tracks.h"

namespace gw::tools {
namespace {

int Fail(const Error& error) {
  std::fprintf(stderr, "gw-calibrate-stereo: %s\n", error.message.c_str());
  return ExitCodeFor(error);
}

Result<std::vector<PairTracks>> ReadTracks(const std::string& path,
                                           const CameraCalibration& camera) {
  auto log = process::EventLogReader::Open(path);
  if (!log) return log.error();
  StereoTracker tracker;
  std::vector<PairTracks> pairs;
  int images = 0, refused = 0;
  auto said = std::chrono::steady_clock::now();
  while (const auto event = log->Next()) {
    if (event->channel != wire::kCamera) continue;
    const auto decoded = wire::Decode<wire::DecodedCamera>(event->data);
    if (!decoded || decoded->frame.right.empty() || decoded->frame.left.width != camera.width ||
        decoded->frame.left.height != camera.height) {
      ++refused;
      continue;
    }
    ++images;
    if (auto tracks = tracker.Push(decoded->frame.left, decoded->frame.right)) {
      pairs.push_back(*std::move(tracks));
    }
    const auto now = std::chrono::steady_clock::now();
    if (now - said > std::chrono::seconds(2)) {
      said = now;
      std::fprintf(stderr, "gw-calibrate-stereo: %d images\n", images);
    }
  }
  if (log->error()) return *log->error();
  if (images == 0) {
    return Error{ErrorCode::kBadData, path + ": no stereo pair of " + std::to_string(camera.width) +
                                          " x " + std::to_string(camera.height) +
                                          " px as the configuration says; see gw-log info"};
  }
  if (refused > 0) {
    std::fprintf(stderr, "gw-calibrate-stereo: %d messages are no such stereo pair, left out\n",
                 refused);
  }
  return pairs;
}

void Print(const StereoRefinement& r) {
  std::printf("%d tracks through %d pairs of images\n", r.num_tracks, r.num_pairs);
  std::printf("residual                 %.3f px, was %.3f px\n", r.rms_after_px, r.rms_before_px);
  std::printf(
      "disparity at infinity    was off by %+.2f px at the left edge, %+.2f +- %.2f in the "
      "middle, %+.2f at the right edge\n",
      r.shift_left_px, r.shift_centre_px, r.sigma_shift_px, r.shift_right_px);
}

int Run(const std::string& log, const std::string& config_in, const std::string& config_out) {
  Result<RobotConfig> config = LoadRobotConfig(config_in);
  if (!config) return Fail(config.error());
  CameraCalibration& camera = config->calibration.camera;
  if (camera.kind != CameraKind::kStereo) {
    return Fail({ErrorCode::kBadConfig,
                 config_in + ": calibration.camera.kind is not stereo: nothing to calibrate here"});
  }
  const Result<std::vector<PairTracks>> pairs = ReadTracks(log, camera);
  if (!pairs) return Fail(pairs.error());
  const Result<StereoRefinement> refined = RefineStereo(camera, *pairs);
  if (!refined) return Fail({refined.error().code, log + ": " + refined.error().message});
  camera = refined->camera;
  std::ofstream file(config_out);
  file << WriteRobotConfig(*config, ConfigText::kShort);
  file.close();
  if (!file) {
    return Fail({ErrorCode::kIo, config_out + ": cannot be written; check folder and free space"});
  }
  Print(*refined);
  return kExitOk;
}

}  // namespace
}  // namespace gw::tools

int main(int argc, char** argv) {
  std::string log, config_in, config_out;
  gw::cli::Command app(
      "Refines the calibration of a stereo camera's right eye from a log in which the camera "
      "moves\n"
      "past textured things at several distances. The left eye and the baseline stay as given.\n"
      "Exit: 0 ok, 1 the log cannot be read or does not determine it, 2 usage, 78 bad "
      "configuration.");
  app.AddOption("log", log, "LCM event log with stereo CAMERA messages")->Required();
  app.AddOption("--config", config_in, "robot YAML with the calibration to start from")->Required();
  app.AddOption("--config-out", config_out, "robot YAML to write")->Required();
  if (const auto exit = app.Parse(argc, argv)) return *exit;
  return gw::tools::Run(log, config_in, config_out);
}
