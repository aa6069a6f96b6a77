#include "tools/data/import/image_list.h"

#include <algorithm>

#include "tools/data/files/format.h"
#include "tools/data/import/streams.h"

namespace gw::importer {
namespace {

std::vector<Utime> Times(const std::vector<ListedImage>& images) {
  std::vector<Utime> times;
  times.reserve(images.size());
  for (const ListedImage& image : images) times.push_back(image.utime);
  return times;
}

enum class Second { kRight, kDepth };

// By how much the times of a pair may differ.
DurationUs LargestDifference(const std::vector<Utime>& first, Second kind) {
  return kind == Second::kDepth ? Milliseconds(20) : LargestEyeDifference(first);
}

Result<std::vector<FrameFiles>> Pair(const std::vector<ListedImage>& first,
                                     const std::vector<ListedImage>& second, Second kind,
                                     std::vector<std::string>& warnings) {
  const bool depth = kind == Second::kDepth;
  const std::vector<Utime> times = Times(first);
  const DurationUs limit = LargestDifference(times, kind);
  const std::string partner =
      tools::Format("%s image within %.4g ms", depth ? "depth" : "right", limit.seconds() * 1e3);
  std::vector<FrameFiles> files;
  for (const auto& [i, j] : depth ? AssociateNearest(times, Times(second), limit)
                                  : PairEyes(times, Times(second), warnings)) {
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

bool IsFile(const std::filesystem::path& file) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(file, ignored);
}

std::string WithSlashes(std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');
  return name;
}

// True when the first of two images that belong together is the depth.
bool FirstIsDepth(const std::vector<FrameFiles>& files) {
  for (const FrameFiles& frame : files) {
    if (LoadDepthImage(frame.left)) return true;
    if (LoadDepthImage(frame.depth)) return false;
  }
  return !files.empty() && files.front().left.string().find("depth") != std::string::npos;
}

}  // namespace

std::filesystem::path ListedFile(const std::filesystem::path& folder, const TextRow& row) {
  const std::string& rest = row.after_first();
  const std::string without_commas = rest.substr(0, rest.find_last_not_of(" ,") + 1);
  for (const std::string& name : {rest, without_commas, row.text(1)}) {
    for (const std::string& spelt : {name, WithSlashes(name)}) {
      if (IsFile(folder / spelt)) return folder / spelt;
    }
  }
  return folder / WithSlashes(rest);
}

Result<std::vector<FrameFiles>> ReadAssociations(const std::filesystem::path& source,
                                                 const std::string& name,
                                                 std::vector<std::string>& warnings) {
  const Result<TextTable> table =
      TextTable::Read(source / name, "lines `t color/t.png t depth/t.png`");
  if (!table) return table.error();
  std::vector<FrameFiles> files;
  const auto read = table->ForEach(warnings, [&](const TextRow& row) -> Result<Done> {
    const Result<Utime> utime = row.Seconds(0);
    if (!utime) return utime.error();
    if (row.size() < 4) return row.BadData("needs `t color/t.png t depth/t.png`");
    const Result<Utime> second = row.Seconds(2);
    if (!second) return second.error();
    files.push_back({*utime,
                     source / WithSlashes(row.text(1)),
                     {},
                     source / WithSlashes(row.text(3)),
                     row.place()});
    return Done{};
  });
  if (!read) return read.error();
  if (FirstIsDepth(files)) {
    for (FrameFiles& frame : files) std::swap(frame.left, frame.depth);
    warnings.push_back(name +
                       ": the first image of a line is the depth, the second the camera's; "
                       "the time is the depth's");
  }
  return files;
}

Result<std::vector<ListedImage>> ReadImageList(const std::filesystem::path& source,
                                               const std::string& name,
                                               std::vector<std::string>& warnings) {
  const Result<TextTable> table =
      TextTable::Read(source / name, "lines `timestamp filename` of images");
  if (!table) return table.error();
  std::vector<ListedImage> images;
  const auto read = table->ForEach(warnings, [&](const TextRow& row) -> Result<Done> {
    const Result<Utime> utime = row.Seconds(0);
    if (!utime) return utime.error();
    if (row.size() < 2) return row.BadData("the file name is missing; is the file cut off here?");
    images.push_back({*utime, ListedFile(source, row), row.place()});
    return Done{};
  });
  if (!read) return read.error();
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
