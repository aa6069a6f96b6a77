// gw-view: a running system, or a log, in a browser and in Foxglove's viewers.
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "common/camera/camera_model.h"
#include "common/cli/command.h"
#include "common/config/loader.h"
#include "common/core/exit_code.h"
#include "common/process/bus.h"
#include "tools/robot/floorplan/floor_map.h"
#include "tools/view/report/report_page.h"
#include "tools/view/viewer.h"

namespace gw::view {
namespace {

struct Arguments {
  std::string log, config, map, token_file, page;
  std::string url;
  std::string listen = "127.0.0.1:8765";
  std::vector<double> start;  // x, y, theta
  double speed = 1;
  std::vector<std::string> hosts;
  std::vector<std::string> origins = {"https://app.foxglove.dev"};
};

// A tenth of a second at 30 Hz: clients get at most ten images a second.
constexpr int kImagesThatWait = 3;

int Fail(const Error& error) {
  std::fprintf(stderr, "<3>gw-view: %s\n", error.message.c_str());
  return ExitCodeFor(error);
}

Result<foxglove::TranslatorOptions> LoadOptions(const Arguments& arguments,
                                                const std::optional<RobotConfig>& config) {
  foxglove::TranslatorOptions options;
  if (config) {
    const auto camera = MakeCameraGeometry(config->calibration);
    if (!camera) return camera.error();
    options.camera = *camera;
  }
  if (!arguments.map.empty()) {
    auto map = floorplan::LoadFloorMap(arguments.map);
    if (!map) return map.error();
    options.floor = foxglove::FloorCells{map->width, map->height, map->resolution, map->origin,
                                         std::move(map->occupied)};
  }
  if (!arguments.start.empty()) {
    const auto& s = arguments.start;
    options.T_GB_start =
        SE3(Eigen::Quaterniond(Eigen::AngleAxisd(s[2], Eigen::Vector3d::UnitZ())), {s[0], s[1], 0});
  }
  return options;
}

Result<ServerOptions> LoadServerOptions(const Arguments& arguments) {
  ServerOptions options;
  const size_t colon = arguments.listen.rfind(':');
  const std::string port = colon == std::string::npos ? "" : arguments.listen.substr(colon + 1);
  if (port.empty() || port.size() > 5 || port.find_first_not_of("0123456789") != port.npos ||
      std::stoi(port) > 65535) {
    return Error{ErrorCode::kInvalidArgument, "--listen: ADDRESS:PORT is wanted"};
  }
  options.address = HostName(arguments.listen);
  options.port = static_cast<uint16_t>(std::stoi(port));
  options.access.allowed_hosts = arguments.hosts;
  options.access.allowed_origins = arguments.origins;
  if (!arguments.token_file.empty()) {
    std::ifstream file(arguments.token_file);
    if (!(file >> options.access.token) || options.access.token.size() < 16) {
      return Error{ErrorCode::kBadConfig,
                   arguments.token_file + ": a token of at least 16 characters is wanted"};
    }
  }
  if (!IsLoopback(options.address) && options.access.token.empty()) {
    return Error{ErrorCode::kInvalidArgument,
                 "--listen " + arguments.listen +
                     ": others could look through the robot's camera; give --token-file too"};
  }
  options.name = arguments.log.empty() ? "live" : arguments.log;
  return options;
}

int Run(Arguments arguments) {
  auto server = LoadServerOptions(arguments);
  if (!server) {
    Fail(server.error());
    return server.error().code == ErrorCode::kInvalidArgument ? kExitUsage : kExitBadConfig;
  }
  if (!arguments.log.empty() && arguments.config.empty()) {
    const auto beside = std::filesystem::path(arguments.log).replace_extension(".yaml");
    if (std::filesystem::exists(beside)) arguments.config = beside.string();
  }
  std::optional<RobotConfig> config;
  if (!arguments.config.empty()) {
    auto loaded = LoadRobotConfig(arguments.config);
    if (!loaded) return Fail(loaded.error());
    config = std::move(*loaded);
  }
  auto options = LoadOptions(arguments, config);
  if (!options) return Fail(options.error());
  const std::string folder =
      arguments.page.empty() ? PageFolder("view", "index.html") : arguments.page;
  auto page = folder.empty() ? PageFiles::WithoutPage() : PageFiles::Load(folder);
  if (!page) return Fail(page.error());
  if (folder.empty()) {
    std::fprintf(stderr, "gw-view: the page was not built (npm was missing): data only\n");
  }

  std::unique_ptr<process::LiveBus> bus;
  std::optional<LogPlayer> player;
  if (arguments.log.empty()) {
    if (arguments.url.empty()) {
      arguments.url = config ? config->process.lcm_url : ProcessConfig().lcm_url;
    }
    auto created = process::LiveBus::Create(arguments.url);
    if (!created) return Fail(created.error());
    bus = std::move(*created);
    bus->HoldImages(kImagesThatWait);
    if (!bus->warning().empty()) std::fprintf(stderr, "gw-view: %s\n", bus->warning().c_str());
  } else {
    auto opened = LogPlayer::Open(arguments.log, *options, arguments.speed);
    if (!opened) return Fail(opened.error());
    player.emplace(std::move(*opened));
  }
  auto viewer = Viewer::Create(*server, std::move(*page), *options, bus.get(), std::move(player));
  if (!viewer) return Fail(viewer.error());
  const bool v6 = server->address.find(':') != std::string::npos;
  std::printf("http://%s%s%s:%d/\n", v6 ? "[" : "", server->address.c_str(), v6 ? "]" : "",
              (*viewer)->port());
  std::fflush(stdout);
  const auto ended = (*viewer)->Run();
  return ended ? kExitOk : Fail(ended.error());
}

int Main(int argc, char** argv) {
  Arguments arguments;
  cli::Command app(
      "Shows a running system, or a log, in a browser and in viewers that speak Foxglove's "
      "WebSocket "
      "protocol.\nListens on the bus and never publishes. Prints the address; ends with SIGINT.\n"
      "Exit: 0 ok, 1 failed, 2 usage, 78 bad configuration.");
  app.AddOption("LOG", arguments.log, "play this log instead of listening on the bus");
  app.AddOption("--config", arguments.config,
                "robot YAML: camera and bus; for a LOG the YAML beside it");
  app.AddOption("--lcm-url", arguments.url, "bus, instead of process.lcm_url of the configuration");
  app.AddOption("--listen", arguments.listen, "ADDRESS:PORT; port 0: any that is free")
      ->ShowDefault();
  app.AddOption("--token-file", arguments.token_file,
                "file with a token that clients have to give (?token=...); needed when --listen "
                "is not this machine alone");
  app.AddOption("--map", arguments.map, "floor map (map.yaml)");
  app.AddOption("--start", arguments.start,
                "X,Y,THETA of the robot's first pose in the floor map; m, rad")
      ->Separator(',')
      ->NumValues(3);
  app.AddOption("--speed", arguments.speed, "of a LOG")->ShowDefault();
  app.AddOption("--allow-host", arguments.hosts,
                "name by which a reverse proxy asks, beside localhost and addresses");
  app.AddOption("--allow-origin", arguments.origins, "web pages that may connect")->ShowDefault();
  app.AddOption("--page", arguments.page, "folder of the page, instead of the installed one");
  if (const auto exit = app.Parse(argc, argv)) return *exit;
  return Run(std::move(arguments));
}

}  // namespace
}  // namespace gw::view

int main(int argc, char** argv) {
  return gw::view::Main(argc, argv);
}
