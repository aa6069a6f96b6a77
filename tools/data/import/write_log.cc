#include "tools/data/import/write_log.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "common/config/loader.h"
#include "common/config/writer.h"
#include "common/wire/channels.h"
#include "common/wire/wire.h"
#include "tools/data/files/faults.h"
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

// Frames that cannot be read are faults of the recording, or left out and counted.
class FrameWriter {
 public:
  FrameWriter(const FrameSource& frames, bool skip_broken, CountingLog& log)
      : frames_(frames), skip_broken_(skip_broken), log_(log) {}

  Result<Done> Append(size_t index) {
    const Result<FramePixels> pixels = frames_.Load(index);
    if (!pixels) {
      ++broken_;
      faults_.Add(pixels.error());
      return Done{};
    }
    CameraFrame frame;
    frame.utime = frames_.utime(index);
    frame.left = pixels->left.view();
    frame.right = pixels->right.view();
    frame.depth = pixels->depth.view();
    return log_.Append(wire::kCamera, frame);
  }

  // The verdict on all frames together.
  Result<Done> Verdict() {
    if (broken_ == 0) return Done{};
    if (!skip_broken_) {
      faults_.Add({ErrorCode::kBadData, std::to_string(broken_) + " of " +
                                            std::to_string(frames_.size()) +
                                            " frames cannot be read; restore them, or leave such "
                                            "frames out with --skip-missing"});
    }
    if (!skip_broken_ || broken_ == frames_.size()) return faults_.error();
    return Done{};
  }
  size_t broken() const { return broken_; }

 private:
  const FrameSource& frames_;
  bool skip_broken_;
  CountingLog& log_;
  tools::Faults faults_;
  size_t broken_ = 0;
};

}  // namespace

Result<LogSummary> WriteLog(const Recording& recording, const std::filesystem::path& file,
                            bool skip_broken, const Progress& progress) {
  const std::vector<Item> items = Schedule(recording);
  if (items.empty()) {
    return Error{ErrorCode::kBadData, recording.name + ": holds nothing to import"};
  }
  Result<tools::SafeLogWriter> writer = tools::SafeLogWriter::Create(file.string());
  if (!writer) return writer.error();
  CountingLog log(*std::move(writer));
  const Result<Done> noted = AppendNotes(recording, items.front().utime, log);
  if (!noted) return noted.error();
  std::optional<FrameWriter> frames;
  if (recording.frames) frames.emplace(*recording.frames, skip_broken, log);
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
        return frames->Append(item.index);
      case Rank::kGroundTruth:
        return log.Append(wire::kGroundTruth, recording.ground_truth[item.index]);
    }
    GW_CHECK(false);
  };
  for (const Item& item : items) {
    const Result<Done> written = append(item);
    if (!written) return written.error();
  }
  const size_t broken = frames ? frames->broken() : 0;
  Result<Done> whole = frames ? frames->Verdict() : Done{};
  if (whole && broken > 0) {
    wire::Note note;
    note.utime = items.back().utime;
    note.key = "skipped";
    note.text = std::to_string(broken) + " frames whose images cannot be read";
    whole = log.Append(wire::kNote, note);
  }
  if (!whole) return whole.error();
  Result<LogSummary> summary = log.Finish(items.front().utime, items.back().utime);
  if (summary) summary->broken_frames = static_cast<int64_t>(broken);
  return summary;
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
