#include "tools/data/import/image_list.h"

#include "tools/data/import/streams.h"
#include "tools/data/import/text_table.h"

namespace gw::importer {
namespace {

std::vector<Utime> Times(const std::vector<ListedImage>& images) {
  std::vector<Utime> times;
  for (const ListedImage& image : images) times.push_back(image.utime);
  return times;
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
    images.push_back(
        {*utime, source / row.text(1), table->file().string() + ":" + std::to_string(row.line())});
  }
  MakeOrdered(images, name, warnings);
  return images;
}

Result<std::vector<FrameFiles>> PairWithDepth(const std::vector<ListedImage>& grey,
                                              const std::vector<ListedImage>& depth,
                                              std::vector<std::string>& warnings) {
  std::vector<FrameFiles> files;
  for (const auto& [i, j] : AssociateNearest(Times(grey), Times(depth), Milliseconds(20))) {
    files.push_back({grey[i].utime, grey[i].file, {}, depth[j].file, grey[i].listed_at});
  }
  if (files.empty()) {
    return Error{ErrorCode::kBadData, grey.front().listed_at +
                                          ": no image has a depth image within 20 ms; are both "
                                          "lists of the same recording?"};
  }
  if (files.size() < grey.size()) {
    warnings.push_back(std::to_string(grey.size() - files.size()) +
                       " images have no depth image within 20 ms; left out");
  }
  return files;
}

}  // namespace gw::importer
