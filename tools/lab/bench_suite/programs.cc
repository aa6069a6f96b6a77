#include "tools/lab/bench_suite/programs.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>

#include <cerrno>
#include <filesystem>
#include <system_error>

#include "tools/data/files/text_file.h"

namespace gw::bench {
namespace {

std::string LastLine(const std::string& path) {
  const auto text = tools::ReadTextFile(path);
  if (!text) return "";
  const size_t end = text->find_last_not_of("\r\n");
  if (end == std::string::npos) return "";
  const size_t before = text->rfind('\n', end);
  const size_t begin = before == std::string::npos ? 0 : before + 1;
  return text->substr(begin, end + 1 - begin);
}

}  // namespace

Result<std::string> SiblingProgram(const std::string& name) {
  std::error_code error;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::string path = (self.parent_path() / name).string();
  if (error || !std::filesystem::exists(path)) {
    return Error{ErrorCode::kNotFound, path + ": is not there; build it: tools/dev build"};
  }
  return path;
}

Result<Done> RunProgram(const std::vector<std::string>& command, const std::string& output) {
  std::vector<char*> argv;
  for (const std::string& word : command) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, output.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  posix_spawn_file_actions_adddup2(&actions, 1, 2);
  pid_t child = 0;
  const int failed = posix_spawn(&child, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) {
    return Error{ErrorCode::kIo, command[0] + ": cannot be started (output to " + output +
                                     "): " + std::generic_category().message(failed)};
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return Error{ErrorCode::kIo, command[0] + ": cannot be waited for"};
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return Done{};
  const std::string how = WIFEXITED(status) ? "exit " + std::to_string(WEXITSTATUS(status))
                                            : "signal " + std::to_string(WTERMSIG(status));
  return Error{ErrorCode::kBadData, std::filesystem::path(command[0]).filename().string() + ": " +
                                        how + ": " + LastLine(output) + " (" + output + ")"};
}

}  // namespace gw::bench
