// The local grids on disk, beside the map whose keyframes carry them: DIR/grid.gwg.
//
// Little-endian: kGridMagic, uint32 length of the content, uint32 crc32 of the compressed content,
// the content compressed by zlib. Content: float64 cell_m, uint32 number of grids; for each int64
// keyframe, int64 utime of its image (us), float64 x, y, yaw of T_KL, uint32 number of tiles; for
// each int32 x, y and 1024 times int8, log-odds in steps of 1/32, and uint8, sharpness in steps of
// 1/25.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/core/result.h"
#include "grid/core/grid_map.h"

namespace gw::grid {

inline constexpr std::string_view kGridMagic = "GWGRID1\n";  // the digit is the format's version
inline constexpr char kGridFileName[] = "grid.gwg";

struct GridFile {
  double cell_m = 0;
  std::vector<GridMap::SavedGrid> grids;
};

std::vector<uint8_t> EncodeGrid(const GridFile& grid);
// Error kBadData: what is wrong. No input makes it allocate more than kMaxGridBytes.
Result<GridFile> DecodeGrid(const std::vector<uint8_t>& bytes);
inline constexpr uint32_t kMaxGridBytes = 1u << 30;

// Errors: kIo; loading: kNotFound, kBadData with the path.
Result<Done> SaveGrid(const std::string& directory, const GridFile& grid);
Result<GridFile> LoadGrid(const std::string& directory);

}  // namespace gw::grid
