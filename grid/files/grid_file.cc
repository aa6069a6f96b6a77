#include "grid/files/grid_file.h"

#include <zlib.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "grid/files/whole_file.h"

namespace gw::grid {
namespace {

constexpr float kSteps = 32;           // of the log-odds, per 1
constexpr float kSharpnessSteps = 25;  // likewise

class Writer {
 public:
  template <typename T>
  void Put(T value) {
    for (size_t i = 0; i < sizeof(T); ++i) {
      bytes.push_back(static_cast<uint8_t>(static_cast<uint64_t>(value) >> (8 * i)));
    }
  }
  void Real(double value) { Put(std::bit_cast<uint64_t>(value)); }

  std::vector<uint8_t> bytes;
};

class Reader {
 public:
  explicit Reader(std::span<const uint8_t> bytes) : rest_(bytes) {}

  // 0 when the bytes end before; ok() then is false.
  template <typename T>
  T Get() {
    if (rest_.size() < sizeof(T)) {
      ok_ = false;
      rest_ = {};
      return {};
    }
    uint64_t value = 0;
    for (size_t i = 0; i < sizeof(T); ++i) value |= uint64_t{rest_[i]} << (8 * i);
    rest_ = rest_.subspan(sizeof(T));
    return static_cast<T>(value);
  }
  double Real() {
    const double value = std::bit_cast<double>(Get<uint64_t>());
    if (!std::isfinite(value)) ok_ = false;
    return ok_ ? value : 0;
  }
  bool ok() const { return ok_; }
  size_t left() const { return rest_.size(); }

 private:
  std::span<const uint8_t> rest_;
  bool ok_ = true;
};

constexpr size_t kHeader = kGridMagic.size() + 8;

Error Bad(const char* what) {
  return {ErrorCode::kBadData, std::string("grid: ") + what};
}

void ReadTile(Reader* in, CellTiles* cells) {
  const auto x = in->Get<int32_t>();
  const auto y = in->Get<int32_t>();
  CellTiles::Tile tile;
  for (Cell& cell : tile) {
    cell.log_odds = static_cast<float>(in->Get<int8_t>()) / kSteps;
    cell.sharpness = static_cast<float>(in->Get<uint8_t>()) / kSharpnessSteps;
  }
  // Farther away than anyone drives, and far from where indices overflow.
  constexpr int32_t kFar = 1 << 20;
  if (in->ok() && std::abs(x) < kFar && std::abs(y) < kFar) cells->Make({x, y}) = tile;
}

Result<GridFile> DecodeContent(const std::vector<uint8_t>& content) {
  Reader in(content);
  GridFile out;
  out.cell_m = in.Real();
  if (!(out.cell_m > 1e-3 && out.cell_m < 10)) return Bad("the size of its cells is impossible");
  const auto num_grids = in.Get<uint32_t>();
  for (uint32_t i = 0; i < num_grids && in.ok(); ++i) {
    GridMap::SavedGrid saved;
    saved.keyframe.value = in.Get<int64_t>();
    saved.keyframe_utime.us = in.Get<int64_t>();
    const double x = in.Real(), y = in.Real(), yaw = in.Real();
    saved.grid.T_KL = Pose2({x, y}, yaw);
    const auto num_tiles = in.Get<uint32_t>();
    for (uint32_t k = 0; k < num_tiles && in.ok(); ++k) ReadTile(&in, &saved.grid.cells);
    out.grids.push_back(std::move(saved));
  }
  if (!in.ok() || in.left() != 0) return Bad("its content does not have the length it claims");
  return out;
}

}  // namespace

std::vector<uint8_t> EncodeGrid(const GridFile& grid) {
  Writer content;
  content.Real(grid.cell_m);
  content.Put(static_cast<uint32_t>(grid.grids.size()));
  for (const GridMap::SavedGrid& saved : grid.grids) {
    content.Put(saved.keyframe.value);
    content.Put(saved.keyframe_utime.us);
    content.Real(saved.grid.T_KL.translation().x());
    content.Real(saved.grid.T_KL.translation().y());
    content.Real(saved.grid.T_KL.yaw());
    content.Put(static_cast<uint32_t>(saved.grid.cells.tiles().size()));
    for (const auto& [index, tile] : saved.grid.cells.tiles()) {
      content.Put(index.x);
      content.Put(index.y);
      for (const Cell& cell : tile) {
        content.Put(static_cast<int8_t>(std::lround(cell.log_odds * kSteps)));
        content.Put(static_cast<uint8_t>(std::lround(cell.sharpness * kSharpnessSteps)));
      }
    }
  }
  uLongf size = compressBound(content.bytes.size());
  std::vector<uint8_t> compressed(size);
  // Cannot fail with a buffer of that bound; what it made is checked on reading.
  compress2(compressed.data(), &size, content.bytes.data(), content.bytes.size(), 6);
  compressed.resize(size);

  Writer out;
  out.bytes.assign(kGridMagic.begin(), kGridMagic.end());
  out.Put(static_cast<uint32_t>(content.bytes.size()));
  out.Put(static_cast<uint32_t>(crc32(0, compressed.data(), static_cast<uInt>(size))));
  out.bytes.insert(out.bytes.end(), compressed.begin(), compressed.end());
  return std::move(out.bytes);
}

Result<GridFile> DecodeGrid(const std::vector<uint8_t>& bytes) {
  if (bytes.size() < kHeader ||
      std::memcmp(bytes.data(), kGridMagic.data(), kGridMagic.size()) != 0) {
    return Bad("not a file of grids, or of another version");
  }
  Reader header(std::span<const uint8_t>(bytes).subspan(kGridMagic.size(), 8));
  const auto length = header.Get<uint32_t>();
  const auto checksum = header.Get<uint32_t>();
  const auto compressed = std::span<const uint8_t>(bytes).subspan(kHeader);
  if (crc32(0, compressed.data(), static_cast<uInt>(compressed.size())) != checksum) {
    return Bad("damaged: its checksum is wrong");
  }
  if (length > kMaxGridBytes) return Bad("larger than any map");
  std::vector<uint8_t> content(length);
  uLongf size = length;
  if (uncompress(content.data(), &size, compressed.data(), compressed.size()) != Z_OK ||
      size != length) {
    return Bad("damaged: it cannot be decompressed");
  }
  return DecodeContent(content);
}

Result<Done> SaveGrid(const std::string& directory, const GridFile& grid) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error) return Error{ErrorCode::kIo, directory + ": " + error.message()};
  return WriteWholeFile(directory + "/" + kGridFileName, EncodeGrid(grid));
}

Result<GridFile> LoadGrid(const std::string& directory) {
  const std::string path = directory + "/" + kGridFileName;
  const auto bytes = ReadWholeFile(path);
  if (!bytes) return bytes.error();
  auto grid = DecodeGrid(*bytes);
  if (!grid) return Error{grid.error().code, path + ": " + grid.error().message};
  return grid;
}

}  // namespace gw::grid
