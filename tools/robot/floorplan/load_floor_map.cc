#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "tools/data/files/strict_yaml.h"
#include "tools/data/files/text_file.h"
#include "tools/robot/floorplan/floor_map.h"
#include "tools/robot/floorplan/map_image.h"

namespace gw::floorplan {
namespace {

// What map_server's documentation calls the mode (wiki.ros.org/map_server, section 1.3).
enum class Mode { kTrinary, kScale, kRaw };

constexpr uint8_t kSaversUnknown = 205;  // the grey that map savers write for unknown
constexpr double kRawOccupied = 100;     // per cent of occupancy; more is unknown

struct Description {
  std::string image;
  double resolution = 0;  // m
  std::vector<double> origin = {0, 0, 0};
  double occupied_thresh = 0;
  double free_thresh = 0.196;  // map_server's own
  bool negate = false;
  Mode mode = Mode::kTrinary;
};

enum class Cell : uint8_t { kFree, kUnknown, kOccupied };

void ReadNegate(tools::StrictMap& map, Description* out) {
  const YAML::Node node = map.Take("negate");
  if (!node.IsDefined()) return;
  const std::string text = node.IsScalar() ? node.Scalar() : "";
  if (text == "1" || text == "true") {
    out->negate = true;
  } else if (text != "0" && text != "false") {
    map.report()->Add(node, "negate: must be 0 or 1");
  }
}

Result<Description> ReadDescription(const std::string& yaml_path) {
  const auto text = tools::ReadTextFile(yaml_path);
  if (!text) {
    return Error{ErrorCode::kNotFound, yaml_path + ": no such map, give a map_server map.yaml"};
  }
  YAML::Node root;
  try {
    root = YAML::Load(*text);
  } catch (const YAML::Exception& e) {
    return Error{ErrorCode::kBadConfig,
                 yaml_path + ":" + std::to_string(std::max(0, e.mark.line) + 1) + ": " + e.msg};
  }
  Description out;
  tools::YamlReport report(yaml_path);
  tools::StrictMap map(root, "", &report);
  map.Text("image", &out.image, true);
  map.Number("resolution", &out.resolution, 0.001, 10, true);
  map.Numbers("origin", &out.origin, 3, true);
  map.Number("occupied_thresh", &out.occupied_thresh, 0, 1, true);
  map.Number("free_thresh", &out.free_thresh, 0, 1);
  ReadNegate(map, &out);
  map.Choice<Mode>("mode", &out.mode,
                   {{"trinary", Mode::kTrinary}, {"scale", Mode::kScale}, {"raw", Mode::kRaw}});
  if (report.empty() && out.free_thresh > out.occupied_thresh) {
    report.Add(map.Take("free_thresh"), "free_thresh: must not be above occupied_thresh");
  }
  if (report.empty() && out.mode == Mode::kRaw && out.negate) {
    report.Add(map.Take("negate"),
               "negate: must be 0 with `mode: raw`, which ROS 1 and ROS 2 read differently "
               "otherwise");
  }
  if (!report.empty()) return Error{ErrorCode::kBadConfig, report.Text()};
  return out;
}

// What the grey of a pixel says of its cell.
Cell CellOfGrey(const Description& map, uint8_t grey) {
  double occupancy = (map.negate ? grey : 255 - grey) / 255.0;
  if (map.mode == Mode::kRaw) {
    if (grey > kRawOccupied) return Cell::kUnknown;
    occupancy = grey / kRawOccupied;
  }
  if (occupancy > map.occupied_thresh) return Cell::kOccupied;
  if (map.mode != Mode::kRaw && !map.negate && grey == kSaversUnknown) return Cell::kUnknown;
  return occupancy < map.free_thresh ? Cell::kFree : Cell::kUnknown;
}

std::vector<Cell> CellsOf(const Description& map, const MapImage& image) {
  std::array<Cell, 256> of_grey;
  for (int grey = 0; grey < 256; ++grey) {
    of_grey[grey] = CellOfGrey(map, static_cast<uint8_t>(grey));
  }
  std::vector<Cell> cells(image.grey.size());
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const size_t pixel = static_cast<size_t>(image.height - 1 - y) * image.width + x;
      const bool opaque = image.opaque.empty() || image.opaque[pixel] != 0;
      cells[static_cast<size_t>(y) * image.width + x] =
          opaque ? of_grey[image.grey[pixel]] : Cell::kUnknown;
    }
  }
  return cells;
}

struct CellGrid {
  int width = 0, height = 0;
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();
  std::vector<Cell> cells;
};

// A map whose origin has a yaw lies turned about the corner of its first cell. The cell of the
// upright map has the worst of what nine points in it meet, so that no wall gets a gap; outside of
// the turned map everything is unknown.
CellGrid Upright(const CellGrid& in, double resolution, double yaw) {
  const double c = std::cos(yaw), s = std::sin(yaw);
  Eigen::Matrix2d R;
  R << c, -s, s, c;
  const Eigen::Vector2d x_side = R.col(0) * in.width, y_side = R.col(1) * in.height;
  const Eigen::Vector2d low = x_side.cwiseMin(0) + y_side.cwiseMin(0);  // cells from the corner
  const Eigen::Vector2d high = x_side.cwiseMax(0) + y_side.cwiseMax(0);
  constexpr double kRounding = 1e-6;  // cells: a turn by 90 degrees adds none
  CellGrid out;
  out.width = static_cast<int>(std::ceil(high.x() - low.x() - kRounding));
  out.height = static_cast<int>(std::ceil(high.y() - low.y() - kRounding));
  out.origin = in.origin + resolution * low;
  out.cells.assign(static_cast<size_t>(out.width) * out.height, Cell::kFree);
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      Cell& cell = out.cells[static_cast<size_t>(y) * out.width + x];
      for (int k = 0; k < 9; ++k) {
        const int column = k % 3, row = k / 3;
        const Eigen::Vector2d point =
            low + Eigen::Vector2d(x + (column + 0.5) / 3, y + (row + 0.5) / 3);
        const Eigen::Vector2d at = R.transpose() * point;
        const bool inside = at.x() >= 0 && at.y() >= 0 && at.x() < in.width && at.y() < in.height;
        const Cell there =
            inside ? in.cells[static_cast<size_t>(at.y()) * in.width + static_cast<size_t>(at.x())]
                   : Cell::kUnknown;
        cell = std::max(cell, there);
      }
    }
  }
  return out;
}

int64_t CountOf(const std::vector<Cell>& cells, Cell what) {
  return std::count(cells.begin(), cells.end(), what);
}

}  // namespace

Result<FloorMap> LoadFloorMap(const std::string& yaml_path) {
  const auto description = ReadDescription(yaml_path);
  if (!description) return description.error();
  const auto folder = std::filesystem::path(yaml_path).parent_path();
  const std::string image_path = (folder / description->image).string();
  const auto image = LoadMapImage(image_path);
  if (!image) return image.error();
  CellGrid grid{image->width,
                image->height,
                {description->origin[0], description->origin[1]},
                CellsOf(*description, *image)};
  if (CountOf(grid.cells, Cell::kOccupied) == 0) {
    return Error{ErrorCode::kBadData,
                 image_path +
                     ": no cell is occupied (darker than occupied_thresh, without `negate`), a map "
                     "without walls cannot be used"};
  }
  // A map of walls alone, as people draw them on one grey, does not tell free from unknown.
  const bool tells_free = CountOf(grid.cells, Cell::kFree) > 0;
  const double yaw = std::remainder(description->origin[2], 2 * std::numbers::pi);
  if (yaw != 0) grid = Upright(grid, description->resolution, yaw);
  FloorMap map;
  map.width = grid.width;
  map.height = grid.height;
  map.resolution = description->resolution;
  map.origin = grid.origin;
  map.occupied.resize(grid.cells.size());
  for (size_t i = 0; i < grid.cells.size(); ++i) {
    map.occupied[i] = grid.cells[i] == Cell::kOccupied ? 1 : 0;
  }
  if (!tells_free) return map;
  map.unknown.resize(grid.cells.size());
  for (size_t i = 0; i < grid.cells.size(); ++i) {
    map.unknown[i] = grid.cells[i] == Cell::kUnknown ? 1 : 0;
  }
  return map;
}

}  // namespace gw::floorplan
