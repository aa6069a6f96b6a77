#include "tools/lab/measure/slam_run.h"

#include <array>
#include <charconv>
#include <map>
#include <span>
#include <string_view>
#include <utility>

#include "common/contract/tracking_names.h"
#include "tools/data/files/json.h"
#include "tools/data/files/text_file.h"

namespace gw::measure {
namespace {

// Comma-separated text with a header line.
class CsvReader {
 public:
  static Result<CsvReader> Open(const std::string& path, std::string_view header_begin) {
    auto text = tools::ReadTextFile(path);
    if (!text) return text.error();
    CsvReader reader(path, *std::move(text));
    if (!reader.NextLine() || !reader.line_.starts_with(header_begin)) {
      return reader.Bad("the header must begin with " + std::string(header_begin));
    }
    return reader;
  }

  // The fields of the next line; false at the end.
  bool Next() {
    if (!NextLine()) return false;
    fields_.clear();
    size_t begin = 0;
    while (true) {
      const size_t end = line_.find(',', begin);
      fields_.push_back(line_.substr(begin, end - begin));
      if (end == std::string_view::npos) return true;
      begin = end + 1;
    }
  }
  size_t size() const { return fields_.size(); }
  std::string_view field(size_t i) const { return fields_[i]; }
  template <typename T>
  bool Number(size_t i, T* value) const {
    const std::string_view text = fields_[i];
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *value);
    return error == std::errc() && end == text.data() + text.size();
  }
  Error Bad(const std::string& what) const {
    return {ErrorCode::kBadData, path_ + ":" + std::to_string(number_) + ": " + what};
  }

 private:
  CsvReader(std::string path, std::string text) : path_(std::move(path)), text_(std::move(text)) {}

  bool NextLine() {
    ++number_;
    if (position_ >= text_.size()) return false;
    const size_t end = std::min(text_.find('\n', position_), text_.size());
    line_ = std::string_view(text_).substr(position_, end - position_);
    position_ = end + 1;
    return true;
  }

  std::string path_;
  std::string text_;
  size_t position_ = 0;
  int number_ = 0;
  std::string_view line_;
  std::vector<std::string_view> fields_;
};

std::optional<TrackingStatus> StatusFromName(std::string_view name) {
  for (int i = 0; i <= static_cast<int>(TrackingStatus::kLost); ++i) {
    const auto status = static_cast<TrackingStatus>(i);
    if (name == StatusName(status)) return status;
  }
  return std::nullopt;
}

Result<std::vector<FramePose>> ReadFrames(const std::string& path) {
  auto csv = CsvReader::Open(path, "utime,status,n_det,n_trk,n_inliers,q,alpha,dr_share,");
  if (!csv) return csv.error();
  std::vector<FramePose> frames;
  while (csv->Next()) {
    if (csv->size() != 18) return csv->Bad("must have 18 columns");
    FramePose f;
    const auto status = StatusFromName(csv->field(1));
    std::array<double, 7> pose{};
    bool good = status.has_value() && csv->Number(0, &f.utime.us) &&
                csv->Number(2, &f.num_detected) && csv->Number(3, &f.num_tracked) &&
                csv->Number(4, &f.num_inliers) && csv->Number(5, &f.q) &&
                csv->Number(6, &f.alpha) && csv->Number(7, &f.dr_share) &&
                csv->Number(8, &f.map_revision) && csv->Number(9, &f.latency_us);
    for (size_t i = 0; i < pose.size(); ++i) good = good && csv->Number(10 + i, &pose[i]);
    if (!good) return csv->Bad("is no line of frames.csv");
    f.status = *status;
    f.T_WB =
        SE3(Eigen::Quaterniond(pose[6], pose[3], pose[4], pose[5]), {pose[0], pose[1], pose[2]});
    frames.push_back(f);
  }
  return frames;
}

// 21 fields from `first`: an upper triangle. False: not numbers.
bool ReadTriangle(const CsvReader& csv, size_t first, Matrix6d* cov) {
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) {
      if (!csv.Number(first++, &(*cov)(i, j))) return false;
      (*cov)(j, i) = (*cov)(i, j);
    }
  }
  return true;
}

Result<Done> ReadCovariances(const std::string& path, std::vector<FramePose>* frames) {
  auto csv = CsvReader::Open(path, "utime,c00,c01,");
  if (!csv) return csv.error();
  size_t next = 0;
  while (csv->Next()) {
    int64_t utime = 0;
    if (next >= frames->size() || csv->size() != 44 || !csv->Number(0, &utime) ||
        utime != (*frames)[next].utime.us) {
      return csv->Bad("does not belong to frames.csv");
    }
    FramePose& frame = (*frames)[next++];
    if (!ReadTriangle(*csv, 1, &frame.cov_T_WB) || !csv->Number(22, &frame.motion_us) ||
        !ReadTriangle(*csv, 23, &frame.cov_motion)) {
      return csv->Bad("is no line of covariance.csv");
    }
  }
  if (next != frames->size()) return csv->Bad("a line for each line of frames.csv is missing");
  return Done{};
}

Result<std::map<Utime, double>> ReadTiming(const std::string& path) {
  std::map<Utime, double> ms;
  if (path.empty()) return ms;
  auto csv = CsvReader::Open(path, "utime,tracking_us");
  if (!csv) return csv.error();
  while (csv->Next()) {
    Utime utime;
    int64_t us = 0;
    if (csv->size() != 2 || !csv->Number(0, &utime.us) || !csv->Number(1, &us)) {
      return csv->Bad("is no line of the timing file");
    }
    ms[utime] = static_cast<double>(us) * 1e-3;
  }
  return ms;
}

Result<RunOrigin> ReadOrigin(const std::string& path) {
  const auto text = tools::ReadTextFile(path);
  if (!text) return text.error();
  try {
    const auto report = tools::Json::parse(*text);
    return RunOrigin{report.at("config_hash"), report.at("version"), report.at("dr_synthetic")};
  } catch (const tools::Json::exception& e) {
    return Error{ErrorCode::kBadData, path + ": is no report of gw-slam: " + e.what()};
  }
}

// TUM files hold whole microseconds, as frames.csv does.
std::map<Utime, SE3> ByTime(const eval::Trajectory& trajectory) {
  std::map<Utime, SE3> out;
  for (const eval::TimedPose& pose : trajectory) out[pose.utime] = pose.T;
  return out;
}

template <typename T>
std::optional<T> Find(const std::map<Utime, T>& map, Utime utime) {
  const auto it = map.find(utime);
  if (it == map.end()) return std::nullopt;
  return it->second;
}

}  // namespace

eval::Trajectory SlamRun::Live() const {
  eval::Trajectory out;
  for (const FramePose& f : frames) out.push_back({f.utime, f.T_WB});
  return out;
}

eval::Trajectory SlamRun::Final() const {
  eval::Trajectory out;
  for (size_t i = 0; i < frames.size(); ++i) out.push_back({frames[i].utime, final_T_WB[i]});
  return out;
}

eval::Trajectory SlamRun::DeadReckoning() const {
  eval::Trajectory out;
  for (size_t i = 0; i < frames.size(); ++i) {
    if (T_OB[i]) out.push_back({frames[i].utime, *T_OB[i]});
  }
  return out;
}

SlamRun RunOf(const tools::SlamSession& session) {
  SlamRun run;
  run.frames = session.frames();
  run.T_OB = session.dr_poses();
  run.ms.resize(run.frames.size());
  for (size_t i = 0; i < run.frames.size(); ++i) {
    run.final_T_WB.push_back(session.FinalPose(run.frames[i]));
    if (i < session.tracking_us().size()) {
      run.ms[i] = static_cast<double>(session.tracking_us()[i]) * 1e-3;
    }
  }
  return run;
}

Result<StoredRun> ReadRun(const std::string& folder, const std::string& timing) {
  StoredRun out;
  auto origin = ReadOrigin(folder + "/report.json");
  if (!origin) return origin.error();
  out.origin = *std::move(origin);
  auto frames = ReadFrames(folder + "/frames.csv");
  if (!frames) return frames.error();
  out.run.frames = *std::move(frames);
  const auto covariances = ReadCovariances(folder + "/covariance.csv", &out.run.frames);
  if (!covariances) return covariances.error();
  const auto final = eval::ReadTum(folder + "/trajectory_final.tum");
  if (!final) return final.error();
  const auto dr = eval::ReadTum(folder + "/dr.tum");
  if (!dr) return dr.error();
  const auto ms = ReadTiming(timing);
  if (!ms) return ms.error();
  const auto final_by_time = ByTime(*final);
  const auto dr_by_time = ByTime(*dr);
  for (const FramePose& f : out.run.frames) {
    const auto T_WB = Find(final_by_time, f.utime);
    if (!T_WB) {
      return Error{ErrorCode::kBadData, folder + "/trajectory_final.tum: has no pose at " +
                                            std::to_string(f.utime.us) + " us"};
    }
    out.run.final_T_WB.push_back(*T_WB);
    out.run.T_OB.push_back(Find(dr_by_time, f.utime));
    out.run.ms.push_back(Find(*ms, f.utime));
  }
  return out;
}

}  // namespace gw::measure
