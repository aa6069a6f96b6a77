// Lists `timestamp filename`, as TUM RGB-D and OpenLORIS have them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/data/import/image_file.h"

namespace gw::importer {

struct ListedImage {
  Utime utime;
  std::filesystem::path file;
  std::string listed_at;  // "FILE:LINE"
};

// In time order, each time once. The rest of a line is the name: it may hold blanks.
Result<std::vector<ListedImage>> ReadImageList(const std::filesystem::path& source,
                                               const std::string& name,
                                               std::vector<std::string>& warnings);

// Grey and depth images whose times differ by less than 20 ms, each grey image with the
// nearest depth image. Error:
// kBadData when there is no pair.
Result<std::vector<FrameFiles>> PairWithDepth(const std::vector<ListedImage>& grey,
                                              const std::vector<ListedImage>& depth,
                                              std::vector<std::string>& warnings);

// Left and right images of one exposure: stamps within 2 ms, which is above the jitter of stamps
// and below the shortest frame period. Error: kBadData when there is no pair.
Result<std::vector<FrameFiles>> PairStereo(const std::vector<ListedImage>& left,
                                           const std::vector<ListedImage>& right,
                                           std::vector<std::string>& warnings);

}  // namespace gw::importer
