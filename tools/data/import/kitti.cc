#include "tools/data/import/kitti.h"

#include "tools/data/files/faults.h"
#include "tools/data/files/format.h"
#include "tools/data/import/image_file.h"
#include "tools/data/import/sensor_yaml.h"
#include "tools/data/import/stereo_range.h"
#include "tools/data/import/text_table.h"
#include "tools/data/import/trajectory.h"

namespace gw::importer {
namespace {

std::string ImageName(size_t index) {
  return tools::Format("%06zu.png", index);
}

Result<Done> ReadCalibration(const std::filesystem::path& file, CameraCalibration& camera,
                             std::vector<std::string>& warnings) {
  const Result<TextTable> table =
      TextTable::Read(file, "the projection matrices `P0: ...` and `P1: ...`");
  if (!table) return table.error();
  std::vector<double> P0, P1;
  const auto read = table->ForEach(warnings, [&](const TextRow& row) -> Result<Done> {
    if (row.text(0) != "P0:" && row.text(0) != "P1:") return Done{};
    Result<std::vector<double>> P = row.Numbers(1, 12);
    if (!P) return P.error();
    if ((*P)[0] <= 0 || (*P)[5] <= 0) return row.BadData("the focal length must be positive");
    (row.text(0) == "P0:" ? P0 : P1) = *std::move(P);
    return Done{};
  });
  if (!read) return read.error();
  if (P0.empty() || P1.empty()) {
    return Error{ErrorCode::kBadData, file.string() +
                                          ": P0 or P1 is missing; a stereo recording "
                                          "needs both"};
  }
  const double baseline_m = (P0[3] - P1[3]) / P0[0];
  if (baseline_m <= 0) {
    return Error{ErrorCode::kBadData,
                 file.string() + ": P1 puts the right camera left of P0's; are they swapped?"};
  }
  camera.kind = CameraKind::kStereo;
  camera.left = {P0[0], P0[5], P0[2], P0[6], {}};
  camera.right = {P1[0], P1[5], P1[2], P1[6], {}};
  camera.T_C0C1 = SE3(Eigen::Quaterniond::Identity(), {baseline_m, 0, 0});
  return Done{};
}

Result<std::vector<StampedPose>> ReadPoses(const std::filesystem::path& file,
                                           const std::vector<Utime>& times,
                                           std::vector<std::string>& warnings) {
  const Result<TextTable> table = TextTable::Read(file, "camera poses, 3x4 a line");
  if (!table) return table.error();
  if (table->rows().size() != times.size()) {
    return Error{ErrorCode::kBadData, file.string() + ": holds " +
                                          std::to_string(table->rows().size()) +
                                          " poses, but times.txt " + std::to_string(times.size()) +
                                          " times; are they of the same sequence?"};
  }
  std::vector<StampedPose> T_GC;
  size_t index = 0;  // of the pose, which has the time of the image of this number
  const auto read = table->ForEach(warnings, [&](const TextRow& row) -> Result<Done> {
    const Utime utime = times[index++];
    const Result<std::vector<double>> v = row.Numbers(0, 12);
    if (!v) return v.error();
    const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> matrix(v->data());
    const auto rotation = FindNearestRotation(matrix.leftCols<3>());
    if (!rotation) return row.BadData("the left 3x3 part is no rotation; correct the line");
    T_GC.push_back({utime, SE3(rotation->q, matrix.rightCols<1>())});
    return Done{};
  });
  if (!read) return read.error();
  return T_GC;
}

// Times and images; the image of a line has the line's number.
Result<std::vector<Utime>> ReadFrames(const std::filesystem::path& source,
                                      const ReadOptions& options, Recording& recording) {
  const std::filesystem::path times_file = source / "times.txt";
  const Result<TextTable> table = TextTable::Read(times_file, "one time in seconds per image");
  if (!table) return table.error();
  std::vector<Utime> times;
  std::vector<FrameFiles> files;
  const auto read = table->ForEach(recording.warnings, [&](const TextRow& row) -> Result<Done> {
    const Result<Utime> utime = row.Seconds(0);
    if (!utime) return utime.error();
    if (!times.empty() && *utime <= times.back()) {
      return row.BadData("the time does not increase; images are named by line, so correct it");
    }
    const std::string name = ImageName(times.size());
    files.push_back(
        {*utime, source / "image_0" / name, source / "image_1" / name, {}, row.place()});
    times.push_back(*utime);
    return Done{};
  });
  if (!read) return read.error();
  Result<std::unique_ptr<FrameSource>> frames =
      MakeFileFrames(std::move(files), options, recording);
  if (!frames) return frames.error();
  recording.frames = *std::move(frames);
  return times;
}

Result<Done> ReadTruth(const std::filesystem::path& file, const std::vector<Utime>& times,
                       Recording& recording) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) {
    recording.warnings.emplace_back("poses.txt is not there: no ground truth in the log");
    return Done{};
  }
  Result<std::vector<StampedPose>> T_GC = ReadPoses(file, times, recording.warnings);
  if (!T_GC) return T_GC.error();
  const SE3& T_BC = recording.calibration.camera.T_BC;
  // The files' world is the first optical frame; turned so that z points up.
  for (StampedPose& pose : *T_GC) pose.T = T_BC * pose.T;
  recording.ground_truth = GroundTruthOfBody(*T_GC, T_BC);
  recording.notes.emplace_back(
      "ground_truth", "in the first body frame (x forward, y left, z up), not the first camera's");
  return Done{};
}

}  // namespace

Result<Recording> ReadKitti(const std::filesystem::path& source, const ReadOptions& options) {
  Recording recording;
  recording.format = "kitti";
  recording.name = FolderName(source);
  CameraCalibration& camera = recording.calibration.camera;
  tools::Faults faults;
  faults.Passed(ReadCalibration(source / "calib.txt", camera, recording.warnings));
  camera.T_BC = PoseOfBodyAtCamera();
  const Result<std::vector<Utime>> times = ReadFrames(source, options, recording);
  if (faults.Passed(times)) faults.Passed(ReadTruth(source / "poses.txt", *times, recording));
  if (!faults.empty()) return faults.error();
  SetStereoRange(camera);
  recording.notes.emplace_back("licence",
                               "CC BY-NC-SA 3.0, non-commercial; cite Geiger et al. 2012");
  return recording;
}

}  // namespace gw::importer
