// Recordings of ROS 1 and ROS 2 as files: topics, and messages as bytes. What the bytes mean is not
// known here.
//
// Containers: ROS 1 bags (format 2.0), MCAP, SQLite3 databases of rosbag2; a folder of rosbag2 with
// its metadata.yaml. They are read from the begin to the end without their index, so that a bag
// whose recorder was killed gives all that reached the disk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/core/result.h"
#include "tools/data/bag/byte_cursor.h"

namespace gw::bag {

enum class Serialization {
  kRos1,   // fields in order, no padding
  kCdr,    // OMG CDR with its 4 bytes of encapsulation in front
  kOther,  // protobuf, JSON, ...: not decoded here
};

struct Topic {
  std::string name;  // as recorded, with its slash
  std::string type;  // "sensor_msgs/Image", also where ROS 2 says "sensor_msgs/msg/Image"
  Serialization serialization = Serialization::kOther;
  int64_t messages = 0;
  int64_t first_ns = 0, last_ns = 0;  // receive times, since 1970

  bool operator==(const Topic&) const = default;
};

// Where a message is.
struct MessageRef {
  uint32_t topic = 0;   // index in topics()
  uint32_t file = 0;    // of a recording in several files
  int64_t log_ns = 0;   // when the recorder received it, ns since 1970
  uint64_t block = 0;   // position of the chunk in the file; row of a database
  uint64_t offset = 0;  // in the decompressed chunk
  uint64_t size = 0;    // bytes
};

// One file. Implementations: ros1_bag.h, mcap.h, sqlite_bag.h.
class BagFile {
 public:
  virtual ~BagFile() = default;
  const std::vector<Topic>& topics() const { return topics_; }
  const std::vector<MessageRef>& messages() const { return messages_; }
  // What is damaged or missing, one sentence each, without the file's name.
  const std::vector<std::string>& warnings() const { return warnings_; }

  // Bytes of a message, valid until the next call. Error: kBadData.
  virtual Result<Bytes> Read(const MessageRef& message) = 0;

 protected:
  // Counts the message for its topic.
  void AddMessage(const MessageRef& message);

  std::vector<Topic> topics_;
  std::vector<MessageRef> messages_;
  std::vector<std::string> warnings_;
};

// A recording, also of several files. Topics of one name and type are one.
class Bag {
 public:
  // source: a file, or a folder of rosbag2. Error: kNotFound; kBadData with what it is instead.
  static Result<std::unique_ptr<Bag>> Open(const std::filesystem::path& source);

  const std::vector<Topic>& topics() const { return topics_; }
  // In the order of the files.
  const std::vector<MessageRef>& messages() const { return messages_; }
  const std::vector<std::string>& warnings() const { return warnings_; }
  const std::string& container() const { return container_; }  // "ROS 1 bag", "MCAP", ...

  // Bytes of a message, valid until the next call. Error: kBadData.
  Result<Bytes> Read(const MessageRef& message);

 private:
  Result<Done> Add(const std::filesystem::path& file, bool compressed_messages);

  std::vector<std::unique_ptr<BagFile>> files_;
  std::vector<Topic> topics_;
  std::vector<MessageRef> messages_;
  std::vector<std::string> warnings_;
  std::string container_;
};

// "sensor_msgs/Image" of "sensor_msgs/msg/Image".
std::string ShortType(const std::string& type);

}  // namespace gw::bag
