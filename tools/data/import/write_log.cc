#include "tools/data/import/write_log.h"

#include <algorithm>
#include <vector>

#include "common/config/loader.h"
#include "common/config/writer.h"
#include "common/wire/channels.h"
#include "common/wire/wire.h"
#include "tools/data/files/format.h"
#include "tools/data/log/safe_log_writer.h"

namespace gw::importer {
namespace {

// In the order in which a consumer needs messages of one instant: what moved, then what was seen.
enum class Rank { kImu, kWheel, kDr, kCamera, kGroundTruth };

struct Item {
  Utime utime;
  Rank rank;
  size_t index;
  auto operator<=>(const Item&) const = default;
};

std::vector<Item> Schedule(const Recording& recording) {
  std::vector<Item> items;
  const auto add = [&](Rank rank, const auto& samples) {
    for (size_t i = 0; i < samples.size(); ++i) items.push_back({samples[i].utime, rank, i});
  };
  add(Rank::kImu, recording.imu);
  add(Rank::kWheel, recording.wheel);
  add(Rank::kDr, recording.dr);
  add(Rank::kGroundTruth, recording.ground_truth);
  for (size_t i = 0; recording.frames && i < recording.frames->size(); ++i) {
    items.push_back({recording.frames->utime(i), Rank::kCamera, i});
  }
  std::sort(items.begin(), items.end());
  return items;
}

// Counts the messages of each channel on their way into the log.
class CountingLog {
 public:
  explicit CountingLog(tools::SafeLogWriter writer) : writer_(std::move(writer)) {}

  template <typename Message>
  Result<Done> Append(const char* channel, Message message) {
    message.seq = ++summary_.messages[channel];
    return writer_.Append(message.utime, channel, wire::Encode(message));
  }
  Result<LogSummary> Finish(Utime begin, Utime end) {
    summary_.begin = begin;
    summary_.end = end;
    summary_.bytes = writer_.bytes_written();
    const Result<Done> committed = writer_.Commit();
    if (!committed) return committed.error();
    return summary_;
  }

 private:
  tools::SafeLogWriter writer_;
  LogSummary summary_;
};

Result<Done> AppendNotes(const Recording& recording, Utime utime, CountingLog& log) {
  std::vector<std::pair<std::string, std::string>> notes = recording.notes;
  for (const std::string& warning : recording.warnings) notes.emplace_back("warning", warning);
  for (const auto& [key, text] : notes) {
    wire::Note note;
    note.utime = utime;
    note.key = key;
    note.text = text;
    const Result<Done> written = log.Append(wire::kNote, note);
    if (!written) return written.error();
  }
  return Done{};
}

Result<Done> AppendFrame(const FrameSource& frames, size_t index, CountingLog& log) {
  const Result<FramePixels> pixels = frames.Load(index);
  if (!pixels) return pixels.error();
  CameraFrame frame;
  frame.utime = frames.utime(index);
  frame.left = pixels->left.view();
  frame.right = pixels->right.view();
  frame.depth = pixels->depth.view();
  return log.Append(wire::kCamera, frame);
}

}  // namespace

Result<LogSummary> WriteLog(const Recording& recording, const std::filesystem::path& file,
                            const Progress& progress) {
  const std::vector<Item> items = Schedule(recording);
  if (items.empty()) {
    return Error{ErrorCode::kBadData, recording.name + ": holds nothing to import"};
  }
  Result<tools::SafeLogWriter> writer = tools::SafeLogWriter::Create(file.string());
  if (!writer) return writer.error();
  CountingLog log(*std::move(writer));
  const Result<Done> noted = AppendNotes(recording, items.front().utime, log);
  if (!noted) return noted.error();
  const auto append = [&](const Item& item) -> Result<Done> {
    switch (item.rank) {
      case Rank::kImu:
        return log.Append(wire::kImu, recording.imu[item.index]);
      case Rank::kWheel:
        return log.Append(wire::kWheel, recording.wheel[item.index]);
      case Rank::kDr:
        return log.Append(wire::kDr, recording.dr[item.index]);
      case Rank::kCamera:
        progress(item.index, recording.frames->size());
        return AppendFrame(*recording.frames, item.index, log);
      case Rank::kGroundTruth:
        return log.Append(wire::kGroundTruth, recording.ground_truth[item.index]);
    }
    GW_CHECK(false);
  };
  for (const Item& item : items) {
    const Result<Done> written = append(item);
    if (!written) return written.error();
  }
  return log.Finish(items.front().utime, items.back().utime);
}

Result<RobotConfig> MakeRobotConfig(const Recording& recording) {
  RobotConfig config;
  config.robot.name = recording.name;
  config.calibration = recording.calibration;
  config.dr_ekf.source = recording.dr.empty() ? DrSource::kSensors : DrSource::kRecorded;
  // What is written must load: the same rules, before anything is written.
  return ParseRobotConfig(WriteRobotConfig(config, ConfigText::kShort),
                          "calibration of " + recording.name);
}

std::string GroundTruthText(const Recording& recording, TrajectoryFrame frame) {
  std::string text = "# t tx ty tz qx qy qz qw\n";
  for (const GroundTruth& truth : recording.ground_truth) {
    const SE3 T = frame == TrajectoryFrame::kBody ? truth.T_GB
                                                  : truth.T_GB * recording.calibration.camera.T_BC;
    text += tools::TumLine(truth.utime, T);
  }
  return text;
}

}  // namespace gw::importer
