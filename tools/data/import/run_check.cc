#include "tools/data/import/run_check.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "tools/data/files/format.h"
#include "tools/data/files/json.h"
#include "tools/data/files/shell_word.h"

namespace gw::importer {
Result<tools::Json> RunCheck(const std::string& log, const std::string& config) {
  std::error_code error;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::string program = (self.parent_path() / "gw-check").string();
  if (error || !std::filesystem::exists(program, error)) {
    return Error{ErrorCode::kNotFound, program + " is not there: the log was not checked"};
  }
  const std::string command = tools::ShellWord(program) + " " + tools::ShellWord(log) +
                              " --config " + tools::ShellWord(config) + " --no-vision --json 2>&1";
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  if (!pipe) return Error{ErrorCode::kIo, program + ": cannot be started"};
  std::string said;
  char buffer[4096];
  while (std::fgets(buffer, sizeof buffer, pipe.get()) != nullptr) said += buffer;
  // Its JSON is its last line; before it may stand what it says to people.
  const size_t begin = said.rfind("{\"program\"");
  const tools::Json json = begin == std::string::npos
                               ? tools::Json()
                               : tools::Json::parse(said.substr(begin), nullptr, false);
  if (!json.is_object() || !json.contains("findings")) {
    return Error{ErrorCode::kIo, "the log was not checked; gw-check said: " + said};
  }
  return json["findings"];
}

std::string CheckText(const tools::Json& findings, const std::string& log,
                      const std::string& config) {
  const auto errors =
      std::count_if(findings.begin(), findings.end(),
                    [](const tools::Json& finding) { return finding["severity"] == "error"; });
  std::string text = tools::Format(
      "checked, without following the images (gw-check %s --config %s does): %d errors, %d "
      "warnings\n",
      log, config, errors, static_cast<int64_t>(findings.size()) - errors);
  for (const tools::Json& finding : findings) {
    text += tools::Format("  %s [%s] %s\n      %s\n",
                          finding["severity"] == "error" ? "ERROR" : "warning",
                          finding["id"].get<std::string>(), finding["text"].get<std::string>(),
                          finding["fix"].get<std::string>());
  }
  return text;
}

}  // namespace gw::importer
