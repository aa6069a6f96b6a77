#include "grid/files/map_server.h"

#include <filesystem>
#include <system_error>

#include "common/core/format.h"
#include "grid/files/whole_file.h"

namespace gw::grid {
namespace {

uint8_t GreyOf(CellState state) {
  switch (state) {
    case CellState::kFree:
      return 254;
    case CellState::kOccupied:
      return 0;
    case CellState::kUnknown:
      break;
  }
  return 205;
}

std::span<const uint8_t> BytesOf(const std::string& text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

}  // namespace

Result<Done> WriteMapServer(const std::string& directory, const FloorImage& image) {
  if (image.width == 0) {
    return Error{ErrorCode::kBadData, directory + ": no floor and no obstacle was seen yet"};
  }
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error) return Error{ErrorCode::kIo, directory + ": " + error.message()};

  std::string pgm =
      "P5\n" + std::to_string(image.width) + " " + std::to_string(image.height) + "\n255\n";
  for (int y = image.height - 1; y >= 0; --y) {
    for (int x = 0; x < image.width; ++x) {
      pgm.push_back(static_cast<char>(GreyOf(image.at(x, y))));
    }
  }
  const std::string yaml =
      "image: map.pgm\nmode: trinary\nresolution: " + FormatDouble(image.cell_m) + "\norigin: [" +
      FormatDouble(image.first_x * image.cell_m) + ", " +
      FormatDouble(image.first_y * image.cell_m) +
      ", 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";
  if (auto done = WriteWholeFile(directory + "/map.pgm", BytesOf(pgm)); !done) return done;
  return WriteWholeFile(directory + "/map.yaml", BytesOf(yaml));
}

}  // namespace gw::grid
