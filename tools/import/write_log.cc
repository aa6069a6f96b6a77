#include "tools/import/write_log.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <tuple>
#include <vector>

#include "common/config/loader.h"
#include "common/config/writer.h"
#include "common/process/event_log.h"
#include "lcmtypes/wire/channels.h"
#include "lcmtypes/wire/wire.h"

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

// The log under its temporary name; removed unless it was finished.
class PartialLog {
 public:
  explicit PartialLog(const std::filesystem::path& file)
      : file_(file), partial_(file.string() + ".partial") {}
  ~PartialLog() {
    if (!finished_) {
      writer_.reset();
      std::error_code ignored;
      std::filesystem::remove(partial_, ignored);
    }
  }
  PartialLog(const PartialLog&) = delete;
  PartialLog& operator=(const PartialLog&) = delete;

  Result<Done> Open() {
    Result<process::EventLogWriter> writer = process::EventLogWriter::Create(partial_.string());
    if (!writer) return writer.error();
    writer_ = std::make_unique<process::EventLogWriter>(*std::move(writer));
    return Done{};
  }
  template <typename Message>
  Result<Done> Append(const char* channel, const Message& message) {
    ++summary_.messages[channel];
    return writer_->Append(message.utime, channel, wire::Encode(message));
  }
  int64_t next_seq(const char* channel) const {
    const auto found = summary_.messages.find(channel);
    return found == summary_.messages.end() ? 1 : found->second + 1;
  }
  Result<LogSummary> Finish(Utime begin, Utime end) {
    summary_.begin = begin;
    summary_.end = end;
    summary_.bytes = writer_->bytes_written();
    const Result<Done> closed = writer_->Close();
    if (!closed) return closed.error();
    std::error_code error;
    std::filesystem::rename(partial_, file_, error);
    if (error) {
      return Error{ErrorCode::kIo, file_.string() + ": cannot be replaced: " + error.message()};
    }
    finished_ = true;
    return summary_;
  }

 private:
  std::filesystem::path file_, partial_;
  std::unique_ptr<process::EventLogWriter> writer_;
  LogSummary summary_;
  bool finished_ = false;
};

Result<Done> AppendNotes(const Recording& recording, Utime utime, PartialLog& log) {
  std::vector<std::pair<std::string, std::string>> notes = recording.notes;
  for (const std::string& warning : recording.warnings) notes.emplace_back("warning", warning);
  for (const auto& [key, text] : notes) {
    wire::Note note;
    note.utime = utime;
    note.seq = log.next_seq(wire::kNote);
    note.key = key;
    note.text = text;
    const Result<Done> written = log.Append(wire::kNote, note);
    if (!written) return written.error();
  }
  return Done{};
}

template <typename Sample>
Result<Done> AppendSample(const char* channel, Sample sample, PartialLog& log) {
  sample.seq = log.next_seq(channel);
  return log.Append(channel, sample);
}

Result<Done> AppendFrame(const FrameSource& frames, size_t index, PartialLog& log) {
  const Result<FramePixels> pixels = frames.Load(index);
  if (!pixels) return pixels.error();
  CameraFrame frame;
  frame.utime = frames.utime(index);
  frame.left = pixels->left.view();
  frame.right = pixels->right.view();
  frame.depth = pixels->depth.view();
  return AppendSample(wire::kCamera, frame, log);
}

}  // namespace

Result<LogSummary> WriteLog(const Recording& recording, const std::filesystem::path& file,
                            const Progress& progress) {
  const std::vector<Item> items = Schedule(recording);
  if (items.empty()) {
    return Error{ErrorCode::kBadData, recording.name + ": holds nothing to import"};
  }
  PartialLog log(file);
  const Result<Done> opened = log.Open();
  if (!opened) return opened.error();
  const Result<Done> noted = AppendNotes(recording, items.front().utime, log);
  if (!noted) return noted.error();
  const auto append = [&](const Item& item) -> Result<Done> {
    switch (item.rank) {
      case Rank::kImu:
        return AppendSample(wire::kImu, recording.imu[item.index], log);
      case Rank::kWheel:
        return AppendSample(wire::kWheel, recording.wheel[item.index], log);
      case Rank::kDr:
        return AppendSample(wire::kDr, recording.dr[item.index], log);
      case Rank::kCamera:
        progress(item.index, recording.frames->size());
        return AppendFrame(*recording.frames, item.index, log);
      case Rank::kGroundTruth:
        return AppendSample(wire::kGroundTruth, recording.ground_truth[item.index], log);
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
    const Eigen::Vector3d& p = T.translation();
    const Eigen::Quaterniond& q = T.rotation();
    char line[250];
    std::snprintf(line, sizeof line, "%.6f %.9f %.9f %.9f %.12f %.12f %.12f %.12f\n",
                  truth.utime.seconds(), p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w());
    text += line;
  }
  return text;
}

Result<Done> WriteTextFile(const std::filesystem::path& file, const std::string& text) {
  const std::string partial = file.string() + ".partial";
  std::ofstream stream(partial);
  stream << text;
  stream.close();
  std::error_code error;
  if (stream) std::filesystem::rename(partial, file, error);
  if (stream && !error) return Done{};
  std::error_code ignored;
  std::filesystem::remove(partial, ignored);
  return Error{ErrorCode::kIo,
               file.string() + ": cannot be written; check the folder and the free space"};
}

}  // namespace gw::importer
