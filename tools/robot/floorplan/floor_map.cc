#include "tools/robot/floorplan/floor_map.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace gw::floorplan {
namespace {

Result<cv::Mat> LoadGreyImage(const std::string& path) {
  if (!std::filesystem::exists(path)) {
    return Error{ErrorCode::kNotFound, path + ": cannot open the image of the map"};
  }
  cv::Mat image;
  try {
    image = cv::imread(path, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {
    image.release();  // larger than OpenCV takes
  }
  if (image.empty() || image.type() != CV_8U) {
    return Error{ErrorCode::kBadData,
                 path + ": not an 8-bit grey image (PGM, PNG), or one that is cut off"};
  }
  return image;
}

template <typename T>
T Require(const YAML::Node& root, const char* key) {
  const YAML::Node node = root[key];
  if (!node) throw YAML::Exception(root.Mark(), std::string("`") + key + "` is missing");
  return node.as<T>();
}

}  // namespace

Eigen::Vector2i FloorMap::CellOf(const Eigen::Vector2d& p) const {
  const Eigen::Vector2d cell = (p - origin) / resolution;
  return {static_cast<int>(std::floor(cell.x())), static_cast<int>(std::floor(cell.y()))};
}

Result<FloorMap> LoadFloorMap(const std::string& yaml_path) {
  if (!std::filesystem::exists(yaml_path)) {
    return Error{ErrorCode::kNotFound, yaml_path + ": no such map, give a map_server map.yaml"};
  }
  FloorMap map;
  double occupied_thresh = 0;
  bool negate = false;
  std::string image_path;
  try {
    const YAML::Node root = YAML::LoadFile(yaml_path);
    map.resolution = Require<double>(root, "resolution");
    const auto origin = Require<std::vector<double>>(root, "origin");
    occupied_thresh = Require<double>(root, "occupied_thresh");
    negate = Require<int>(root, "negate") != 0;
    const std::filesystem::path image = Require<std::string>(root, "image");
    image_path = (std::filesystem::path(yaml_path).parent_path() / image).string();
    if (!(map.resolution > 1e-3 && map.resolution < 10)) {
      throw YAML::Exception(root["resolution"].Mark(), "`resolution` must be 0.001 to 10 m");
    }
    if (origin.size() != 3 || !std::isfinite(origin[0]) || !std::isfinite(origin[1]) ||
        std::abs(origin[2]) > 1e-9) {
      throw YAML::Exception(root["origin"].Mark(),
                            "`origin` must be [x, y, 0]: turned maps are not supported");
    }
    map.origin = {origin[0], origin[1]};
  } catch (const YAML::Exception& e) {
    return Error{ErrorCode::kBadConfig,
                 yaml_path + ":" + std::to_string(std::max(0, e.mark.line) + 1) + ": " + e.msg};
  }
  const auto image = LoadGreyImage(image_path);
  if (!image) return image.error();
  map.width = image->cols;
  map.height = image->rows;
  map.occupied.resize(image->total());
  bool any = false;
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const double value = image->at<uint8_t>(map.height - 1 - y, x) / 255.0;
      const bool occupied = (negate ? value : 1.0 - value) > occupied_thresh;
      map.occupied[map.index(x, y)] = occupied ? 1 : 0;
      any = any || occupied;
    }
  }
  if (!any) {
    return Error{ErrorCode::kBadData, image_path +
                                          ": no cell is darker than occupied_thresh, a "
                                          "map without walls cannot be simulated"};
  }
  return map;
}

std::vector<float> DistanceToOccupied(const FloorMap& map, double limit) {
  cv::Mat free(map.height, map.width, CV_8U);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      free.at<uint8_t>(y, x) = map.occupied[map.index(x, y)] != 0 ? 0 : 255;
    }
  }
  cv::Mat distance;
  cv::distanceTransform(free, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  std::vector<float> out(map.occupied.size());
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      // The transform measures to the centre of the occupied cell.
      const double d = std::max(0.0, distance.at<float>(y, x) - 0.5) * map.resolution;
      out[map.index(x, y)] = static_cast<float>(std::min(d, limit));
    }
  }
  return out;
}

double DistanceAt(const FloorMap& map, const std::vector<float>& distance,
                  const Eigen::Vector2d& p) {
  const Eigen::Vector2d at = (p - map.origin) / map.resolution - Eigen::Vector2d(0.5, 0.5);
  const int x = static_cast<int>(std::floor(at.x()));
  const int y = static_cast<int>(std::floor(at.y()));
  const double fx = at.x() - x, fy = at.y() - y;
  const auto value = [&](int ix, int iy) {
    ix = std::clamp(ix, 0, map.width - 1);
    iy = std::clamp(iy, 0, map.height - 1);
    return static_cast<double>(distance[map.index(ix, iy)]);
  };
  return (1 - fy) * ((1 - fx) * value(x, y) + fx * value(x + 1, y)) +
         fy * ((1 - fx) * value(x, y + 1) + fx * value(x + 1, y + 1));
}

std::vector<uint8_t> ReachableCells(const FloorMap& map, const Eigen::Vector2d& from) {
  std::vector<uint8_t> reachable(map.occupied.size(), 0);
  const Eigen::Vector2i start = map.CellOf(from);
  if (!map.InMap(start.x(), start.y()) || map.Occupied(start.x(), start.y())) return reachable;
  std::vector<Eigen::Vector2i> open = {start};
  reachable[map.index(start.x(), start.y())] = 1;
  while (!open.empty()) {
    const Eigen::Vector2i cell = open.back();
    open.pop_back();
    for (const auto& step : {Eigen::Vector2i(1, 0), Eigen::Vector2i(-1, 0), Eigen::Vector2i(0, 1),
                             Eigen::Vector2i(0, -1)}) {
      const Eigen::Vector2i next = cell + step;
      if (!map.InMap(next.x(), next.y()) || map.Occupied(next.x(), next.y())) continue;
      uint8_t& mark = reachable[map.index(next.x(), next.y())];
      if (mark != 0) continue;
      mark = 1;
      open.push_back(next);
    }
  }
  return reachable;
}

}  // namespace gw::floorplan
