#include "tools/data/import/sensor_yaml.h"

#include <yaml-cpp/yaml.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

namespace gw::importer {
namespace {

// More than the rounding of six decimals.
constexpr double kRoundingDeviation = 1e-5;
constexpr double kLargestDeviation = 0.1;

}  // namespace

Error SensorYaml::BadData(const std::string& key, const std::string& what) const {
  const YAML::Node value = node_->IsMap() ? (*node_)[key] : YAML::Node();
  const int line = (value.IsDefined() && value.Mark().line >= 0 ? value : *node_).Mark().line + 1;
  return {ErrorCode::kBadData,
          file_.string() + ":" + std::to_string(std::max(line, 1)) + ": " + key + ": " + what};
}

Result<SensorYaml> SensorYaml::Read(const std::filesystem::path& file, const std::string& what) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) {
    return Error{ErrorCode::kNotFound, file.string() + ": not there; it should hold " + what};
  }
  std::ifstream stream(file);
  std::stringstream text;
  text << stream.rdbuf();
  if (!stream) return Error{ErrorCode::kIo, file.string() + ": cannot be read"};
  std::string content = text.str();
  if (content.starts_with("%YAML")) content.front() = '#';
  std::replace(content.begin(), content.end(), '\t', ' ');
  try {
    YAML::Node root = YAML::Load(content);
    if (!root.IsMap()) {
      return Error{ErrorCode::kBadData,
                   file.string() + ":1: is no YAML map; it should hold " + what};
    }
    return SensorYaml(file, std::make_shared<const YAML::Node>(std::move(root)));
  } catch (const YAML::Exception& e) {
    return Error{ErrorCode::kBadData, file.string() + ":" + std::to_string(e.mark.line + 1) + ": " +
                                          e.msg + "; correct the file"};
  }
}

bool SensorYaml::Has(const std::string& key) const {
  return (*node_)[key].IsDefined();
}

Result<double> SensorYaml::Number(const std::string& key) const {
  const YAML::Node value = (*node_)[key];
  if (!value.IsDefined()) return BadData(key, "is missing");
  try {
    const auto number = value.as<double>();
    if (std::isfinite(number)) return number;
  } catch (const YAML::Exception&) {
    // Same answer as for a number that is not finite.
  }
  return BadData(key, "must be a finite number");
}

Result<std::string> SensorYaml::Text(const std::string& key) const {
  const YAML::Node value = (*node_)[key];
  if (!value.IsDefined() || !value.IsScalar()) return BadData(key, "is missing or no text");
  return value.Scalar();
}

Result<std::vector<double>> SensorYaml::Numbers(const std::string& key, size_t count) const {
  YAML::Node value = (*node_)[key];
  if (!value.IsDefined()) return BadData(key, "is missing");
  if (value.IsMap()) {
    const YAML::Node data = value["data"];
    if (!data.IsDefined()) return BadData(key, "has no member `data`");
    value.reset(data);
  }
  try {
    const auto numbers = value.as<std::vector<double>>();
    const bool finite = std::all_of(numbers.begin(), numbers.end(),
                                    [](double number) { return std::isfinite(number); });
    if (finite && (count == 0 || numbers.size() == count)) return numbers;
  } catch (const YAML::Exception&) {
    // Same answer as for a wrong length.
  }
  return BadData(key, count == 0
                          ? "must be a list of finite numbers"
                          : "must be a list of " + std::to_string(count) + " finite numbers");
}

Result<SE3> SensorYaml::Pose(const std::string& key, std::vector<std::string>& warnings) const {
  const Result<std::vector<double>> data = Numbers(key, 16);
  if (!data) return data.error();
  const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> matrix(data->data());
  if (matrix.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
    return BadData(key, "the last row must be 0 0 0 1");
  }
  const std::optional<NearestRotation> nearest = FindNearestRotation(matrix.topLeftCorner<3, 3>());
  if (!nearest) return BadData(key, "the upper left 3x3 part is no rotation; correct the file");
  if (nearest->deviation > kRoundingDeviation) {
    std::ostringstream warning;
    warning << file_.string() << ": " << key << ": rotation is off orthonormal by "
            << nearest->deviation << "; replaced by the nearest rotation";
    warnings.push_back(warning.str());
  }
  return SE3(nearest->q, matrix.topRightCorner<3, 1>());
}

Result<SensorYaml> SensorYaml::Section(const std::string& key) const {
  YAML::Node value = (*node_)[key];
  if (!value.IsDefined() || !value.IsMap()) return BadData(key, "this section is missing");
  return SensorYaml(file_, std::make_shared<const YAML::Node>(std::move(value)));
}

Result<std::vector<SensorYaml>> SensorYaml::List(const std::string& key) const {
  const YAML::Node value = (*node_)[key];
  if (!value.IsDefined() || !value.IsSequence()) return BadData(key, "this list is missing");
  std::vector<SensorYaml> list;
  for (const auto& element : value) {
    if (!element.IsMap()) return BadData(key, "an element is no map");
    list.push_back(SensorYaml(file_, std::make_shared<const YAML::Node>(element)));
  }
  return list;
}

std::optional<NearestRotation> FindNearestRotation(const Eigen::Matrix3d& matrix) {
  const double deviation =
      (matrix.transpose() * matrix - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(deviation < kLargestDeviation) || matrix.determinant() < 0) return std::nullopt;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d R = svd.matrixU() * svd.matrixV().transpose();
  return NearestRotation{Eigen::Quaterniond(R), deviation};
}

SE3 PoseOfBodyAtCamera() {
  return SE3(Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), Eigen::Vector3d::Zero());
}

}  // namespace gw::importer
