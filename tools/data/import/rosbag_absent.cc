// Stands in for rosbag.cc in builds without Debian's rosbag storage library.
#include "tools/data/import/rosbag.h"

namespace gw::importer {

bool HasRosbagSupport() {
  return false;
}

Result<Recording> ReadRosbag(const std::filesystem::path& file, const RosbagOptions&) {
  return Error{ErrorCode::kInvalidArgument,
               file.string() +
                   ": this build has no ROS bag support; install librosbag-storage-dev "
                   "and build again, or convert the bag to its data set's folder format"};
}

}  // namespace gw::importer
