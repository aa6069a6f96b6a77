#include "tools/data/import/image_list.h"

#include <algorithm>

#include "tools/data/import/streams.h"
#include "tools/data/import/text_table.h"

namespace gw::importer {
namespace {

std::vector<Utime> Times(const std::vector<ListedImage>& images) {
  std::vector<Utime> times;
  for (const ListedImage& image : images) times.push_back(image.utime);
  return times;
}

// The file of a list; names that were written on Windows have back-slashes.
std::filesystem::path ImagePath(const std::filesystem::path& source, std::string name) {
  std::error_code ignored;
  if (!std::filesystem::exists(source / name, ignored)) {
    std::replace(name.begin(), name.end(), '\\', '/');
  }
  return source / name;
}

enum class Second { kRight, kDepth };

Result<std::vector<FrameFiles>> Pair(const std::vector<ListedImage>& first,
                                     const std::vector<ListedImage>& second, Second kind,
                                     std::vector<std::string>& warnings) {
  const bool depth = kind == Second::kDepth;
  const DurationUs limit = depth ? Milliseconds(20) : Milliseconds(2);
  const std::string partner = std::string(depth ? "depth" : "right") + " image within " +
                              std::to_string(limit.us / 1000) + " ms";
  std::vector<FrameFiles> files;
  for (const auto& [i, j] : AssociateNearest(Times(first), Times(second), limit)) {
    files.push_back({first[i].utime, first[i].file, depth ? "" : second[j].file,
                     depth ? second[j].file : "", first[i].listed_at});
  }
  if (files.empty()) {
    return Error{ErrorCode::kBadData, first.front().listed_at + ": no image has a " + partner +
                                          "; are both lists of the same recording?"};
  }
  if (files.size() < first.size()) {
    warnings.push_back(std::to_string(first.size() - files.size()) + " images have no " + partner +
                       "; left out");
  }
  return files;
}

}  // namespace

Result<std::vector<ListedImage>> ReadImageList(const std::filesystem::path& source,
                                               const std::string& name,
                                               std::vector<std::string>& warnings) {
  const Result<TextTable> table =
      TextTable::Read(source / name, "lines `timestamp filename` of images");
  if (!table) return table.error();
  std::vector<ListedImage> images;
  for (const TextRow& row : table->rows()) {
    const Result<Utime> utime = row.Seconds(0);
    if (!utime) return utime.error();
    if (row.size() < 2) return row.BadData("the file name is missing; is the file cut off here?");
    images.push_back({*utime, ImagePath(source, row.RestOfLine(1)), row.place()});
  }
  const Result<Done> ordered = MakeOrdered(images, name, warnings);
  if (!ordered) return ordered.error();
  return images;
}

Result<std::vector<FrameFiles>> PairWithDepth(const std::vector<ListedImage>& grey,
                                              const std::vector<ListedImage>& depth,
                                              std::vector<std::string>& warnings) {
  return Pair(grey, depth, Second::kDepth, warnings);
}

Result<std::vector<FrameFiles>> PairStereo(const std::vector<ListedImage>& left,
                                           const std::vector<ListedImage>& right,
                                           std::vector<std::string>& warnings) {
  return Pair(left, right, Second::kRight, warnings);
}

}  // namespace gw::importer
