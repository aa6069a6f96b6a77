// Calibration files of the data sets: YAML as OpenCV 2 writes it ("%YAML:1.0" on the first line,
// !!opencv-matrix tags, tabs), which a strict parser refuses.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/core/result.h"
#include "common/core/se3.h"
#include "tools/data/import/recording.h"

namespace YAML {
class Node;
}

namespace gw::importer {

// One node with the file it came from.
class SensorYaml {
 public:
  // Error: kNotFound, kIo, or kBadData with the line of the syntax error.
  static Result<SensorYaml> Read(const std::filesystem::path& file, const std::string& what);

  bool Has(const std::string& key) const;
  // Error: kBadData when missing or of another type; names file and key.
  Result<double> Number(const std::string& key) const;
  Result<std::string> Text(const std::string& key) const;
  // A list of finite numbers: the value itself, or its member `data`. count 0: any length.
  Result<std::vector<double>> Numbers(const std::string& key, size_t count) const;
  // A 4x4 matrix, row by row. A rotation that is not orthonormal is replaced by the nearest one,
  // with a warning when that changes it by more than rounding; error beyond repair.
  Result<SE3> Pose(const std::string& key, std::vector<std::string>& warnings) const;
  // A member that is itself a map, and the elements of a member that is a list of maps.
  Result<SensorYaml> Section(const std::string& key) const;
  Result<std::vector<SensorYaml>> List(const std::string& key) const;

  Error BadData(const std::string& key, const std::string& what) const;

 private:
  SensorYaml(std::filesystem::path file, std::shared_ptr<const YAML::Node> node)
      : file_(std::move(file)), node_(std::move(node)) {}

  std::filesystem::path file_;
  std::shared_ptr<const YAML::Node> node_;  // yaml-cpp's nodes share their tree by design
};

// The rotation nearest to the upper left 3x3 part (polar decomposition), and how far the part is
// from it (largest element of R^T R - 1). Empty when it is no rotation at all (over 0.1, or
// mirrored).
struct NearestRotation {
  Eigen::Quaterniond q;
  double deviation;
};
std::optional<NearestRotation> FindNearestRotation(const Eigen::Matrix3d& matrix);

// Body (x forward, y left, z up) whose origin is the optical centre (x right, y down, z forward).
SE3 PoseOfBodyAtCamera();

}  // namespace gw::importer
