// gw-config: checks, prints and explains robot configurations.
#include <cstdio>
#include <string>

#include "common/cli/command.h"
#include "common/config/loader.h"
#include "common/config/reference.h"
#include "common/config/writer.h"
#include "common/core/exit_code.h"

namespace {

int Fail(const gw::Error& error) {
  std::fprintf(stderr, "%s\n", error.message.c_str());
  return gw::ExitCodeFor(error);
}

}  // namespace

int main(int argc, char** argv) {
  std::string check;
  std::string effective;
  std::string brief;
  bool doc = false;
  gw::cli::Command app(
      "Checks, prints and explains robot configurations.\n"
      "Exit: 0 ok, 1 file not readable, 2 usage, 78 bad configuration.");
  app.AddOption("--check", check, "report every mistake of this YAML file");
  app.AddOption("--effective", effective, "print this file with every default filled in");
  app.AddOption("--short", brief, "print this file without what equals the default");
  app.AddFlag("--doc", doc, "print the reference of all keys (Markdown)");
  app.RequireOptions(1);
  if (const auto exit = app.Parse(argc, argv)) return *exit;
  if (doc) {
    std::fputs(gw::ConfigReference().c_str(), stdout);
    return gw::kExitOk;
  }
  const std::string& path = !check.empty() ? check : !effective.empty() ? effective : brief;
  const auto config = gw::LoadRobotConfig(path);
  if (!config) return Fail(config.error());
  if (!check.empty()) {
    std::printf("%s: ok, config hash %016llx\n", path.c_str(),
                static_cast<unsigned long long>(gw::ConfigHash(*config)));
  } else {
    const auto text = effective.empty() ? gw::ConfigText::kShort : gw::ConfigText::kEffective;
    std::fputs(gw::WriteRobotConfig(*config, text).c_str(), stdout);
  }
  return gw::kExitOk;
}
