#include "tools/data/import/trajectory.h"

#include <algorithm>
#include <cmath>

#include "tools/data/import/streams.h"
#include "tools/data/import/text_table.h"

namespace gw::importer {

namespace {

// A quaternion with fewer than two decimals: the attitude is only good to a degree or worse.
constexpr double kRoundedQuaternion = 0.01;

struct Parsed {
  std::vector<StampedPose> trajectory;
  SpoiltRows spoilt;
  size_t rows = 0;
};

// Error only for what is no trajectory at all: fields that are missing or no numbers.
Result<Parsed> Parse(const std::filesystem::path& file, const std::string& what,
                     std::vector<std::string>& warnings) {
  const Result<TextTable> table = TextTable::Read(file, what);
  if (!table) return table.error();
  Parsed parsed;
  parsed.rows = table->rows().size();
  size_t rounded = 0;
  const auto read = table->ForEach(warnings, [&](const TextRow& row) -> Result<Done> {
    if (parsed.spoilt.Skip(row, 0, 8)) return Done{};
    const Result<Utime> utime = row.Seconds(0);
    if (!utime) return utime.error();
    const Result<std::vector<double>> v = row.Numbers(1, 7);
    if (!v) return v.error();
    const double norm = Eigen::Map<const Eigen::Vector4d>(v->data() + 3).norm();
    const Result<SE3> pose = row.PoseXyzQxyzw(1);
    if (!pose) {
      parsed.spoilt.Add(row, norm == 0 ? "the quaternion is 0 0 0 0: no attitude"
                                       : "the quaternion has norm " + std::to_string(norm) +
                                             ", expected 1 (order qx qy qz qw)");
      return Done{};
    }
    if (std::abs(norm - 1) > kRoundedQuaternion) ++rounded;
    parsed.trajectory.push_back({*utime, *pose});
    return Done{};
  });
  if (!read) return read.error();
  if (rounded > 0) {
    warnings.push_back(file.filename().string() + ": " + std::to_string(rounded) + " of " +
                       std::to_string(parsed.rows) +
                       " quaternions are rounded (norm off by more than 1 %): attitudes are off by "
                       "degrees");
  }
  return parsed;
}

}  // namespace

Result<std::vector<StampedPose>> ReadTumTrajectory(const std::filesystem::path& file,
                                                   const std::string& what,
                                                   std::vector<std::string>& warnings) {
  Result<Parsed> parsed = Parse(file, what, warnings);
  if (!parsed) return parsed.error();
  Result<Done> good = parsed->spoilt.Report(parsed->rows, warnings);
  if (good) good = MakeOrdered(parsed->trajectory, file.filename().string(), warnings);
  if (!good) return good.error();
  return std::move(parsed->trajectory);
}

Result<std::vector<StampedPose>> ReadTrueTrajectory(const std::filesystem::path& file,
                                                    const std::string& what,
                                                    std::vector<std::string>& warnings) {
  Result<Parsed> parsed = Parse(file, what, warnings);
  if (!parsed) return parsed.error();
  Result<Done> good = parsed->spoilt.Report(parsed->rows, warnings);
  if (good) good = MakeOrdered(parsed->trajectory, file.filename().string(), warnings);
  if (good) return std::move(parsed->trajectory);
  warnings.push_back(good.error().message + ": no ground truth in the log");
  return std::vector<StampedPose>();
}

std::vector<GroundTruth> GroundTruthOfBody(const std::vector<StampedPose>& T_GS, const SE3& T_BS) {
  const SE3 T_SB = T_BS.inverse();
  std::vector<GroundTruth> out;
  for (const StampedPose& pose : T_GS) {
    GroundTruth truth;
    truth.utime = pose.utime;
    truth.T_GB = pose.T * T_SB;
    out.push_back(truth);
  }
  return out;
}

std::vector<WheelSample> WheelIncrements(const std::vector<StampedPose>& T_OB) {
  std::vector<WheelSample> out;
  for (size_t i = 1; i < T_OB.size(); ++i) {
    const SE3 T_BaBb = T_OB[i - 1].T.inverse() * T_OB[i].T;
    const Eigen::Vector3d x_b = T_BaBb.rotation() * Eigen::Vector3d::UnitX();
    WheelSample sample;
    sample.utime_begin = T_OB[i - 1].utime;
    sample.utime = T_OB[i].utime;
    sample.dx_m = T_BaBb.translation().x();
    sample.dy_m = T_BaBb.translation().y();
    sample.dyaw_rad = std::atan2(x_b.y(), x_b.x());
    out.push_back(sample);
  }
  return out;
}

SE3 PoseAt(const std::vector<StampedPose>& trajectory, Utime utime) {
  const auto after =
      std::lower_bound(trajectory.begin(), trajectory.end(), utime,
                       [](const StampedPose& pose, Utime t) { return pose.utime < t; });
  if (after == trajectory.end()) return trajectory.back().T;
  if (after == trajectory.begin() || after->utime == utime) return after->T;
  const auto before = std::prev(after);
  const double fraction =
      (utime - before->utime).seconds() / (after->utime - before->utime).seconds();
  return Interpolate(before->T, after->T, fraction);
}

}  // namespace gw::importer
