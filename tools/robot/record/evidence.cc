#include "tools/robot/record/evidence.h"

#include <algorithm>
#include <fstream>
#include <system_error>
#include <vector>

namespace gw::record {
namespace {

namespace fs = std::filesystem;

const char* Name(HealthState state) {
  switch (state) {
    case HealthState::kStarting:
      return "STARTING";
    case HealthState::kOk:
      return "OK";
    case HealthState::kDegraded:
      return "DEGRADED";
    case HealthState::kFailed:
      return "FAILED";
    case HealthState::kInvalid:
      break;
  }
  return "INVALID";
}

bool IsBad(HealthState state) {
  return state == HealthState::kDegraded || state == HealthState::kFailed;
}

int64_t SizeOf(const fs::path& folder) {
  int64_t bytes = 0;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    std::error_code ignored;
    const auto size = it->file_size(ignored);
    if (!ignored) bytes += static_cast<int64_t>(size);
  }
  return bytes;
}

// A second name for the same file where the disk allows it: costs nothing, and outlives the first.
std::error_code LinkOrCopy(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::create_hard_link(from, to, error);
  if (!error) return error;
  fs::copy_file(from, to, error);
  return error;
}

}  // namespace

std::optional<std::string> FaultWatch::Observe(const Health& health, Utime now) {
  Process& process = processes_[health.process];
  const HealthState before = process.state;
  process = {health.state, now, false};
  const bool worse = IsBad(health.state) && (!IsBad(before) || health.state > before);
  // The first report tells how things are, not that they changed.
  if (!worse || before == HealthState::kInvalid) return std::nullopt;
  std::string text = health.process + ": " + Name(before) + " to " + Name(health.state) + ": " +
                     health.message + "\n";
  for (const auto& [name, count] : health.counters) {
    text += "  " + name + " " + std::to_string(count) + "\n";
  }
  return text;
}

std::optional<std::string> FaultWatch::CheckSilence(Utime now) {
  for (auto& [name, process] : processes_) {
    if (process.silent || now - process.last < kSilent) continue;
    process.silent = true;
    return name + ": no HEALTH for " + std::to_string((now - process.last).us / 1000) + " ms\n";
  }
  return std::nullopt;
}

bool EvidenceKeeper::Begin(const std::string& fault, Utime now) {
  if (begun_) {
    fault_ += fault;
    return false;
  }
  if (last_ && now - *last_ < kQuiet) return false;
  begun_ = now;
  last_ = now;
  fault_ = fault;
  return true;
}

Result<std::optional<fs::path>> EvidenceKeeper::KeepIfDue(SegmentLog& log, const std::string& note,
                                                          Utime now) {
  if (!begun_ || now - *begun_ < kAfter) return std::optional<fs::path>();
  const Utime begun = *begun_;
  begun_.reset();
  const fs::path folder = folder_ / (FileStamp(begun) + "-" + fault_.substr(0, fault_.find(':')));
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return Error{ErrorCode::kIo, folder.string() + ": " + error.message()};
  if (const auto closed = log.Close(); !closed) return closed.error();
  std::string failed;
  for (const fs::path& file : log.FilesSince(begun - kBefore)) {
    if (const auto bad = LinkOrCopy(file, folder / file.filename())) failed = bad.message();
  }
  for (const auto& [name, content] :
       {std::pair{"robot.yaml", config_}, std::pair{"fault.txt", fault_ + note}}) {
    std::ofstream file(folder / name);
    file << content;
    file.close();
    if (!file) failed = std::string(name) + " cannot be written";
  }
  DeleteOldest();
  if (!failed.empty()) return Error{ErrorCode::kIo, folder.string() + ": " + failed};
  return std::optional<fs::path>(folder);
}

void EvidenceKeeper::DeleteOldest() {
  std::vector<fs::path> folders;
  std::error_code error;
  for (fs::directory_iterator it(folder_, error), end; !error && it != end; it.increment(error)) {
    if (it->is_directory()) folders.push_back(it->path());
  }
  std::sort(folders.begin(), folders.end());
  int64_t bytes = 0;
  for (const fs::path& folder : folders) bytes += SizeOf(folder);
  for (size_t i = 0; i + 1 < folders.size() && bytes > max_bytes_; ++i) {
    bytes -= SizeOf(folders[i]);
    fs::remove_all(folders[i], error);
  }
}

}  // namespace gw::record
