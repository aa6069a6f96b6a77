#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "common/config/loader.h"
#include "tools/data/files/format.h"
#include "tools/data/files/text_file.h"
#include "tools/lab/calibrate/camera_calibration.h"
#include "tools/lab/calibrate/commands.h"
#include "tools/lab/calibrate/commented_config.h"

namespace gw::calibrate {
namespace {

using tools::Format;
namespace fs = std::filesystem;

constexpr double kDegrees = 180 / M_PI;

bool IsImage(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const char* known : {".png", ".jpg", ".jpeg", ".bmp", ".pgm", ".tif", ".tiff"}) {
    if (extension == known) return true;
  }
  return false;
}

Result<std::vector<fs::path>> ImagesIn(const std::string& folder) {
  std::error_code error;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (IsImage(entry.path())) files.push_back(entry.path());
  }
  if (error) return Error{ErrorCode::kNotFound, folder + ": " + error.message()};
  std::sort(files.begin(), files.end());
  if (files.empty()) return Error{ErrorCode::kNotFound, folder + ": holds no image"};
  return files;
}

struct Sightings {
  int width = 0, height = 0;
  size_t images = 0;
  std::vector<BoardView> views;  // with the board in the left eye
};

// The board in one image; the size must be that of the others.
Result<std::vector<BoardCorner>> Look(const fs::path& file, BoardFinder& finder, Sightings* out) {
  cv::Mat grey;
  try {
    grey = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
  } catch (const cv::Exception&) {
    grey.release();
  }
  if (grey.empty()) return Error{ErrorCode::kBadData, file.string() + ": cannot be read"};
  if (out->width == 0) {
    out->width = grey.cols;
    out->height = grey.rows;
  }
  if (grey.cols != out->width || grey.rows != out->height) {
    return Error{ErrorCode::kBadData,
                 Format("%s: is %d x %d, the first image %d x %d", file.string(), grey.cols,
                        grey.rows, out->width, out->height)};
  }
  return finder.Find(grey);
}

Result<Sightings> FindBoards(const CameraOptions& options, const Board& board) {
  const auto files = ImagesIn(options.images);
  if (!files) return files.error();
  BoardFinder finder(board);
  Sightings out;
  for (const fs::path& file : *files) {
    auto left = Look(file, finder, &out);
    if (!left) return left.error();
    ++out.images;
    BoardView view{file.filename().string(), *std::move(left), {}};
    const fs::path partner = fs::path(options.right_images) / file.filename();
    std::error_code ignored;
    if (!options.right_images.empty() && fs::exists(partner, ignored)) {
      auto right = Look(partner, finder, &out);
      if (!right) return right.error();
      view.right = *std::move(right);
    }
    if (!view.left.empty()) out.views.push_back(std::move(view));
  }
  const bool paired = std::any_of(out.views.begin(), out.views.end(),
                                  [](const BoardView& view) { return !view.right.empty(); });
  if (!options.right_images.empty() && !paired) {
    return Error{ErrorCode::kNotFound, options.right_images +
                                           ": no image of the name of one of the left eye's shows "
                                           "the board with it"};
  }
  return out;
}

std::string LensText(const char* name, LensModel model, const LensEstimate& eye) {
  std::string text = Format("%s: corners are off by %.3f px\n", name, eye.rms_px);
  const auto names = LensParameterNames(model);
  for (int i = 0; i < NumLensParameters(model); ++i) {
    const auto k = static_cast<size_t>(i);
    text += Format("  %-3s %12.5f +- %.5f\n", names[k], eye.values[k], eye.sigmas[k]);
  }
  return text;
}

std::string ReportText(const CameraEstimate& found, size_t images) {
  std::string text = Format("%d x %d px, board used in %d of %d images\n", found.width,
                            found.height, found.views, images);
  for (const std::string& name : found.left_out) {
    text += "left out, does not fit the others: " + name + "\n";
  }
  text += LensText(found.right ? "left" : "camera", found.model, found.left);
  if (!found.right) return text;
  text += LensText("right", found.model, *found.right);
  const Eigen::Vector3d p = found.T_C0C1.translation();
  const Eigen::Vector3d r = LogSO3(found.T_C0C1.rotation()) * kDegrees;
  const Vector6d& s = found.sigmas_C0C1;
  text += Format("right eye in the left: %.5f %.5f %.5f +- %.5f %.5f %.5f m\n", p.x(), p.y(), p.z(),
                 s[0], s[1], s[2]);
  text += Format("  turned by %.4f %.4f %.4f +- %.4f %.4f %.4f deg\n", r.x(), r.y(), r.z(),
                 s[3] * kDegrees, s[4] * kDegrees, s[5] * kDegrees);
  return text;
}

PinholeIntrinsics PinholeOf(const LensEstimate& eye) {
  const auto& v = eye.values;
  return {v[0], v[1], v[2], v[3], {v[4], v[5], v[6], v[7], v[8]}};
}

Result<Done> WriteConfig(const CameraOptions& options, const CameraEstimate& found,
                         const std::string& report) {
  Result<RobotConfig> config = LoadRobotConfig(options.config);
  if (!config) return config.error();
  CameraCalibration& camera = config->calibration.camera;
  camera.width = found.width;
  camera.height = found.height;
  camera.left = PinholeOf(found.left);
  if (found.right) {
    camera.right = PinholeOf(*found.right);
    camera.T_C0C1 = found.T_C0C1;
  }
  return WriteCommented(options.config_out, "gw-calibrate camera " + options.images, report,
                        *config);
}

std::string AslText(const CameraEstimate& found, const LensEstimate& eye, const SE3& T_C0C,
                    const std::string& report) {
  std::string text = "%YAML:1.0\n# Written by gw-calibrate camera, which found:\n";
  size_t begin = 0;
  for (size_t end = report.find('\n'); end != std::string::npos; end = report.find('\n', begin)) {
    text += "#   " + report.substr(begin, end - begin) + "\n";
    begin = end + 1;
  }
  const bool radtan = found.model == LensModel::kRadtan;
  const auto& v = eye.values;
  const Eigen::Matrix3d R = T_C0C.rotation().toRotationMatrix();
  const Eigen::Vector3d& p = T_C0C.translation();
  text +=
      "sensor_type: camera\n# In the left camera; multiply by its pose in the body.\nT_BS:\n"
      "  cols: 4\n  rows: 4\n  data: [";
  for (int row = 0; row < 3; ++row) {
    text += Format("%.9g, %.9g, %.9g, %.9g,\n         ", R(row, 0), R(row, 1), R(row, 2), p[row]);
  }
  text += Format(
      "0, 0, 0, 1]\nresolution: [%d, %d]\ncamera_model: pinhole\n"
      "intrinsics: [%.9g, %.9g, %.9g, %.9g] # fu, fv, cu, cv\n",
      found.width, found.height, v[0], v[1], v[2], v[3]);
  text += std::string("distortion_model: ") + (radtan ? "radial-tangential" : "equidistant") + "\n";
  text += Format("distortion_coefficients: [%.9g, %.9g, %.9g, %.9g", v[4], v[5], v[6], v[7]);
  return text + (radtan ? Format(", %.9g]\n", v[8]) : std::string("]\n"));
}

Result<Done> WriteAsl(const CameraOptions& options, const CameraEstimate& found,
                      const std::string& report) {
  const auto write = [&](const char* eye, const LensEstimate& lens, const SE3& T_C0C) {
    const fs::path folder = fs::path(options.asl_out) / eye;
    std::error_code ignored;
    fs::create_directories(folder, ignored);
    return tools::WriteTextFile((folder / "sensor.yaml").string(),
                                AslText(found, lens, T_C0C, report));
  };
  Result<Done> written = write("cam0", found.left, SE3());
  if (written && found.right) written = write("cam1", *found.right, found.T_C0C1);
  return written;
}

}  // namespace

Result<Done> RunCamera(const CameraOptions& options) {
  const Result<Board> board = ParseBoard(options.board);
  if (!board) return board.error();
  const LensModel model =
      options.model == "equidistant" ? LensModel::kEquidistant : LensModel::kRadtan;
  if (model == LensModel::kEquidistant && !options.config_out.empty()) {
    return Error{ErrorCode::kInvalidArgument,
                 "--model equidistant: a robot's configuration holds radtan lenses alone; write "
                 "--asl-out, with which gw-import euroc undistorts the images, or CameraInfo of a "
                 "bag"};
  }
  const Result<Sightings> seen = FindBoards(options, *board);
  if (!seen) return seen.error();
  const Result<CameraEstimate> found =
      CalibrateCamera(*board, model, seen->width, seen->height, seen->views);
  if (!found) return Error{found.error().code, options.images + ": " + found.error().message};
  const std::string report = ReportText(*found, seen->images);
  std::fputs(report.c_str(), stdout);
  Result<Done> written = Done{};
  if (!options.config_out.empty()) written = WriteConfig(options, *found, report);
  if (written && !options.asl_out.empty()) written = WriteAsl(options, *found, report);
  if (!written) return written;
  const std::vector<std::string> wanting = JudgeCamera(*found);
  for (const std::string& sentence : wanting) std::printf("wanting: %s\n", sentence.c_str());
  std::printf(wanting.empty() ? "good\n" : "usable, but see above\n");
  return Done{};
}

}  // namespace gw::calibrate
