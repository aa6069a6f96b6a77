// Lists `timestamp filename`, as TUM RGB-D and OpenLORIS have them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/data/import/image_file.h"
#include "tools/data/import/text_table.h"

namespace gw::importer {

struct ListedImage {
  Utime utime;
  std::filesystem::path file;
  std::string listed_at;  // "FILE:LINE"
};

// The file that a row names behind its time. The name may hold blanks and commas, may have been
// written on Windows with back-slashes, and may be followed by more columns: the first reading of
// the line that is a file in the folder counts.
std::filesystem::path ListedFile(const std::filesystem::path& folder, const TextRow& row);

// Images with their depth images, listed together: lines `t image t depth` or `t depth t image`.
// The depth is the one of 16 bits in the first line that can be read, else the one whose name says
// depth.
Result<std::vector<FrameFiles>> ReadAssociations(const std::filesystem::path& source,
                                                 const std::string& name,
                                                 std::vector<std::string>& warnings);

// In time order, each time once.
Result<std::vector<ListedImage>> ReadImageList(const std::filesystem::path& source,
                                               const std::string& name,
                                               std::vector<std::string>& warnings);

// Grey and depth images whose times differ by less than 20 ms, each grey image with the
// nearest depth image. Error:
// kBadData when there is no pair.
Result<std::vector<FrameFiles>> PairWithDepth(const std::vector<ListedImage>& grey,
                                              const std::vector<ListedImage>& depth,
                                              std::vector<std::string>& warnings);

// Left and right images of one exposure, as PairEyes pairs them. Error: kBadData when there is no
// pair.
Result<std::vector<FrameFiles>> PairStereo(const std::vector<ListedImage>& left,
                                           const std::vector<ListedImage>& right,
                                           std::vector<std::string>& warnings);

}  // namespace gw::importer
