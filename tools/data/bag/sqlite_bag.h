// SQLite3 databases of rosbag2 (tables `topics` and `messages`).
#pragma once

#include <filesystem>
#include <memory>

#include "tools/data/bag/bag.h"

namespace gw::bag {

// compressed_messages: each message is a zstd frame (metadata.yaml, compression_mode MESSAGE).
// Error: kBadData when it is no database of rosbag2.
Result<std::unique_ptr<BagFile>> ReadSqliteBag(const std::filesystem::path& file,
                                               bool compressed_messages);

bool IsSqlite(Bytes bytes);

}  // namespace gw::bag
