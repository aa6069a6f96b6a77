// gw-config: checks, prints and explains robot configurations.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>

#include "common/config/loader.h"
#include "common/config/reference.h"
#include "common/config/writer.h"
#include "common/core/exit_code.h"
#include "common/core/version.h"

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
  CLI::App app(
      "Checks, prints and explains robot configurations.\n"
      "Exit: 0 ok, 1 file not readable, 2 usage, 78 bad configuration.");
  app.set_version_flag("--version", gw::Version());
  app.add_option("--check", check, "report every mistake of this YAML file");
  app.add_option("--effective", effective, "print this file with every default filled in");
  app.add_option("--short", brief, "print this file without what equals the default");
  app.add_flag("--doc", doc, "print the reference of all keys (Markdown)");
  app.require_option(1);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? gw::kExitOk : gw::kExitUsage;
  }
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
