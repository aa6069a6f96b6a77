// gw-report: watches a run on the bus and writes it down as an HTML page.
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <fstream>
#include <string>

#include "common/camera/camera_model.h"
#include "common/cli/command.h"
#include "common/config/loader.h"
#include "common/contract/tracking_names.h"
#include "common/core/exit_code.h"
#include "common/core/format.h"
#include "common/process/bus.h"
#include "common/process/loop.h"
#include "tools/data/files/json.h"
#include "tools/sim/demo/report.h"
#include "tools/sim/demo/run_recorder.h"
#include "tools/view/report/report_page.h"

namespace gw::demo {
namespace {

struct Arguments {
  std::string lcm_url, config, map, out, record;
};

// What the navigator said last of its stops, shortened.
std::string NewestStop(const tools::Monitor& monitor) {
  for (auto note = monitor.notes().rbegin(); note != monitor.notes().rend(); ++note) {
    if (note->key.starts_with("navigate.")) return note->key.substr(9) + " " + note->text;
  }
  return "";
}

std::string ProgressLine(const tools::Monitor& monitor, ErrorNow* error) {
  if (monitor.frames().empty()) return "waiting for the first pose";
  const FramePose& pose = monitor.frames().back().pose;
  const Utime begin = monitor.frames().front().pose.utime;
  std::string line = FormatFixed((pose.utime - begin).seconds(), 0) + " s  " +
                     StatusName(pose.status) + "  Q " + FormatFixed(pose.q, 2) + "  alpha " +
                     FormatDouble(std::stod(FormatFixed(pose.alpha, 2)));
  if (const auto metres = error->Of(monitor)) line += "  error " + FormatFixed(*metres, 3) + " m";
  const std::string stop = NewestStop(monitor);
  return stop.empty() ? line : line + "  " + stop;
}

// A line that is overwritten in place on a terminal, every tenth a line of its own elsewhere.
class Terminal {
 public:
  void Show(const std::string& line) {
    if (in_place_) {
      std::fprintf(stderr, "\r%-100.100s", line.c_str());
    } else if (shown_++ % 10 == 0) {
      std::fprintf(stderr, "%s\n", line.c_str());
    }
  }
  void End() const {
    if (in_place_) std::fprintf(stderr, "\n");
  }

 private:
  bool in_place_ = isatty(STDERR_FILENO) != 0;
  int shown_ = 0;
};

Result<std::optional<floorplan::FloorMap>> LoadMap(const Arguments& args) {
  if (args.map.empty()) return std::optional<floorplan::FloorMap>();
  auto map = floorplan::LoadFloorMap(args.map);
  if (!map) return map.error();
  return std::optional(*std::move(map));
}

Result<foxglove::TranslatorOptions> ViewOptions(const Arguments& args, const RobotConfig& config) {
  foxglove::TranslatorOptions options;
  const auto camera = MakeCameraGeometry(config.calibration);
  if (!camera) return camera.error();
  options.camera = *camera;
  auto map = LoadMap(args);
  if (!map) return map.error();
  if (*map) {
    options.floor = foxglove::FloorCells{(*map)->width, (*map)->height, (*map)->resolution,
                                         (*map)->origin, std::move((*map)->occupied)};
  }
  return options;
}

Result<Done> WriteReport(const Arguments& args, const RobotConfig& config,
                         const tools::Monitor& monitor, const ImageSamples& images,
                         RunRecorder& recorder) {
  ReportInput input;
  input.title = config.robot.name;
  input.monitor = &monitor;
  input.images = &images;
  input.orb = config.frontend.orb;
  auto map = LoadMap(args);
  if (!map) return map.error();
  input.map = *std::move(map);
  const std::string page = view::ReportTemplate();
  const auto html =
      page.empty() ? RenderPlainReport(input) : RenderReport(input, page, recorder.Messages());
  if (!html) return html.error();
  std::ofstream file(args.out, std::ios::binary);
  file << *html;
  file.close();
  if (!file) return Error{ErrorCode::kIo, args.out + ": cannot be written"};
  std::printf("%s\n", args.out.c_str());
  return Done{};
}

Result<Done> Run(const Arguments& args) {
  const auto config = LoadRobotConfig(args.config);
  if (!config) return config.error();
  auto loop = process::Loop::Create(Milliseconds(1000));
  if (!loop) return loop.error();
  auto bus =
      process::LiveBus::Create(args.lcm_url.empty() ? config->process.lcm_url : args.lcm_url);
  if (!bus) return bus.error();
  tools::Monitor monitor;
  ImageSamples images;
  auto options = ViewOptions(args, *config);
  if (!options) return options.error();
  RunRecorder recorder(*std::move(options));
  if (const auto done = tools::Monitor::Attach(**bus, monitor); !done) return done.error();
  if (const auto done = ImageSamples::Attach(**bus, images); !done) return done.error();
  if (const auto done = RunRecorder::Attach(**bus, recorder); !done) return done.error();
  loop->Watch((*bus)->fd());
  Terminal terminal;
  ErrorNow error;
  while (true) {
    const auto ready = loop->Wait();
    if (!ready) return ready.error();
    if (const auto pumped = (*bus)->Pump(0); !pumped) return pumped.error();
    if (ready->stop) break;
    if (ready->tick) terminal.Show(ProgressLine(monitor, &error));
  }
  terminal.End();
  if (!args.record.empty()) {
    if (const auto done = monitor.Write(args.record); !done) return done.error();
  }
  return WriteReport(args, *config, monitor, images, recorder);
}

}  // namespace
}  // namespace gw::demo

int main(int argc, char** argv) {
  gw::demo::Arguments args;
  gw::cli::Command app(
      "Watches a run on the bus, with a line of progress; at SIGINT or SIGTERM writes it down as "
      "one "
      "HTML page and prints where.\nExit: 0 ok, 1 failed, 2 usage, 78 bad configuration.");
  app.AddOption("--config", args.config, "robot YAML")->Required();
  app.AddOption("--out", args.out, "HTML file to write")->Required();
  app.AddOption("--map", args.map, "map.yaml of map_server to draw below; needs GROUND_TRUTH");
  app.AddOption("--record", args.record, "folder for what gw-monitor --out writes");
  app.AddOption("--lcm-url", args.lcm_url, "bus, instead of that of the configuration");
  if (const auto exit = app.Parse(argc, argv)) return *exit;
  const auto done = gw::demo::Run(args);
  if (done) return gw::kExitOk;
  std::fprintf(stderr, "gw-report: %s\n", done.error().message.c_str());
  return gw::ExitCodeFor(done.error());
}
