#include "tools/lab/eval/trajectory.h"

#include <array>
#include <charconv>
#include <cmath>
#include <sstream>

#include "common/process/event_log.h"
#include "common/wire/channels.h"
#include "common/wire/wire.h"
#include "tools/data/files/text_file.h"

namespace gw::eval {
namespace {

constexpr double kQuaternionNormTolerance = 1e-2;
constexpr double kMaxSeconds = 9e12;  // what fits into Utime

Error BadLine(const std::string& name, int line, const std::string& what) {
  return {ErrorCode::kBadData, name + ":" + std::to_string(line) + ": " + what};
}

template <typename Number>
bool ParseNumber(const std::string& text, Number* value) {
  const char* end = text.data() + text.size();
  const char* begin = text.data() + (text.size() > 1 && text[0] == '+' ? 1 : 0);
  const auto [parsed_to, error] = std::from_chars(begin, end, *value);
  return error == std::errc() && parsed_to == end;
}

Result<TimedPose> ParsePose(const std::string& line, const std::string& name, int number) {
  std::istringstream words(line);
  std::string word;
  std::array<double, 8> v{};
  size_t count = 0;
  while (words >> word) {
    if (count == v.size()) return BadLine(name, number, "more than 8 columns: t x y z qx qy qz qw");
    if (!ParseNumber(word, &v[count]) || !std::isfinite(v[count])) {
      return BadLine(name, number, "'" + word + "' is not a finite number");
    }
    ++count;
  }
  if (count < v.size()) {
    return BadLine(name, number,
                   "has " + std::to_string(count) + " of 8 columns: t x y z qx qy qz qw");
  }
  if (std::abs(v[0]) > kMaxSeconds) {
    return BadLine(name, number, "time is not in seconds");
  }
  const Eigen::Quaterniond q(v[7], v[4], v[5], v[6]);
  if (!(std::abs(q.norm() - 1.0) <= kQuaternionNormTolerance)) {
    return BadLine(name, number,
                   q.norm() == 0 ? "quaternion (columns 5 to 8) is 0 0 0 0: no attitude, which is "
                                   "needed; leave the line out"
                                 : "quaternion (columns 5 to 8) is not a unit quaternion");
  }
  return TimedPose{UtimeFromSeconds(v[0]), SE3(q, {v[1], v[2], v[3]})};
}

}  // namespace

Result<Trajectory> ParseTum(const std::string& text, const std::string& name) {
  Trajectory out;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (number == 1 && line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);  // byte-order mark
    line.resize(std::min(line.size(), line.find('#')));
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    const Result<TimedPose> pose = ParsePose(line, name, number);
    if (!pose) return pose.error();
    if (!out.empty() && pose->utime <= out.back().utime) {
      return BadLine(name, number,
                     pose->utime == out.back().utime
                         ? "time repeats that of the pose before (to 1 us); did it lose digits "
                           "when it was written?"
                         : "time does not increase (to 1 us); sort the file by time");
    }
    out.push_back(*pose);
  }
  return out;
}

Result<Trajectory> ReadTum(const std::string& path) {
  const Result<std::string> text = tools::ReadTextFile(path);
  if (!text) return text.error();
  return ParseTum(*text, path);
}

Result<Trajectory> ReadGroundTruthLog(const std::string& path) {
  auto log = process::EventLogReader::Open(path);
  if (!log) return log.error();
  Trajectory out;
  while (const auto event = log->Next()) {
    if (event->channel != wire::kGroundTruth) continue;
    const std::string where = path + ": event " + std::to_string(event->number) + ": ";
    const auto truth = wire::Decode<GroundTruth>(event->data);
    if (!truth) return Error{ErrorCode::kBadData, where + truth.error().message};
    if (!out.empty() && truth->utime <= out.back().utime) {
      return Error{ErrorCode::kBadData, where + "time of the ground truth does not increase"};
    }
    out.push_back({truth->utime, truth->T_GB});
  }
  if (log->error()) return *log->error();
  if (out.empty()) {
    return Error{ErrorCode::kBadData, path + ": holds no " + wire::kGroundTruth +
                                          " message; name a TUM file with the reference"};
  }
  return out;
}

Result<Trajectory> ReadReference(const std::string& path) {
  return path.ends_with(".lcm") ? ReadGroundTruthLog(path) : ReadTum(path);
}

Result<std::vector<Utime>> ReadFrameTimes(const std::string& path) {
  const Result<std::string> text = tools::ReadTextFile(path);
  if (!text) return text.error();
  std::istringstream lines(*text);
  std::string line;
  if (!std::getline(lines, line) || line.substr(0, line.find(',')) != "utime") {
    return BadLine(path, 1, "the first column must be called utime");
  }
  std::vector<Utime> out;
  for (int number = 2; std::getline(lines, line); ++number) {
    if (line.empty()) continue;
    Utime utime;
    if (!ParseNumber(line.substr(0, line.find(',')), &utime.us)) {
      return BadLine(path, number, "utime is not an integer (us)");
    }
    out.push_back(utime);
  }
  return out;
}

}  // namespace gw::eval
