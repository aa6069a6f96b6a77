#include "tools/data/bag/bag.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <fstream>
#include <utility>

#include "tools/data/bag/mapped_file.h"
#include "tools/data/bag/mcap.h"
#include "tools/data/bag/ros1_bag.h"
#include "tools/data/bag/sqlite_bag.h"

namespace gw::bag {
namespace {

namespace fs = std::filesystem;

// A reader of mapped bytes, with the bytes.
class OwningFile : public BagFile {
 public:
  OwningFile(std::unique_ptr<MappedFile> map, std::unique_ptr<BagFile> file)
      : map_(std::move(map)), file_(std::move(file)) {
    topics_ = file_->topics();
    messages_ = file_->messages();
    warnings_ = file_->warnings();
  }
  Result<Bytes> Read(const MessageRef& message) override { return file_->Read(message); }

 private:
  std::unique_ptr<MappedFile> map_;
  std::unique_ptr<BagFile> file_;
};

Error BadData(const fs::path& file, const std::string& what) {
  return {ErrorCode::kBadData, file.string() + ": " + what};
}

struct Opened {
  std::unique_ptr<BagFile> file;
  const char* container;
};

Result<Opened> OpenFile(const fs::path& path, bool compressed_messages) {
  Result<std::unique_ptr<MappedFile>> map = MappedFile::Open(path);
  if (!map) return map.error();
  const Bytes bytes = (*map)->bytes();
  if (bytes.empty()) return BadData(path, "is empty");
  if (IsRos1Bag(bytes)) {
    return Opened{std::make_unique<OwningFile>(*std::move(map), ReadRos1Bag(bytes)), "ROS 1 bag"};
  }
  if (IsMcap(bytes)) {
    return Opened{std::make_unique<OwningFile>(*std::move(map), ReadMcap(bytes)), "MCAP"};
  }
  if (IsSqlite(bytes)) {
    Result<std::unique_ptr<BagFile>> file = ReadSqliteBag(path, compressed_messages);
    if (!file) return BadData(path, file.error().message);
    return Opened{*std::move(file), "rosbag2 SQLite3"};
  }
  if (TextOf(bytes).starts_with("#ROSBAG V1")) {
    return BadData(path, "is a bag of the old format 1; `rosbag migrate` makes it a 2.0");
  }
  if (bytes.size() > 3 && TextOf(bytes).starts_with("\x28\xb5\x2f\xfd")) {
    return BadData(path, "is compressed as a whole; `zstd -d` unpacks it");
  }
  return BadData(path, "is neither a ROS 1 bag nor MCAP nor a database of rosbag2");
}

// What a folder of rosbag2 consists of.
struct Folder {
  std::vector<fs::path> files;
  bool compressed_messages = false;
};

bool IsBagName(const fs::path& file) {
  for (const char* extension : {".db3", ".mcap", ".bag", ".zstd"}) {
    if (file.extension() == extension) return true;
  }
  return false;
}

// Files that are there but not in the metadata are used too: the metadata is written last.
Result<Folder> ReadFolder(const fs::path& path, std::vector<std::string>& warnings) {
  Folder folder;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(path, error)) {
    if (IsBagName(entry.path())) folder.files.push_back(entry.path());
  }
  std::sort(folder.files.begin(), folder.files.end(), [](const fs::path& a, const fs::path& b) {
    // name_2 comes before name_10.
    return std::pair(a.string().size(), a) < std::pair(b.string().size(), b);
  });
  if (folder.files.empty()) {
    return Error{ErrorCode::kNotFound,
                 path.string() +
                     ": holds no .db3, .mcap or .bag file; name the file or the folder "
                     "that `ros2 bag record` wrote"};
  }
  const fs::path metadata = path / "metadata.yaml";
  if (!fs::exists(metadata, error)) {
    if (folder.files.front().extension() != ".bag") {
      warnings.emplace_back("metadata.yaml is not there (the recorder was killed?); not needed");
    }
    return folder;
  }
  try {
    std::ifstream in(metadata);
    const YAML::Node root = YAML::Load(in)["rosbag2_bagfile_information"];
    folder.compressed_messages =
        root["compression_mode"] && root["compression_mode"].as<std::string>() == "MESSAGE";
    for (const YAML::Node& name : root["relative_file_paths"]) {
      const fs::path file = path / fs::path(name.as<std::string>()).filename();
      if (!fs::exists(file, error)) {
        warnings.push_back("metadata.yaml names " + file.filename().string() +
                           ", which is not there; read without it");
      }
    }
  } catch (const YAML::Exception& e) {
    warnings.push_back(std::string("metadata.yaml cannot be read (") + e.what() +
                       "); read without it");
  }
  return folder;
}

}  // namespace

void BagFile::AddMessage(const MessageRef& message) {
  Topic& topic = topics_[message.topic];
  if (topic.messages++ == 0) topic.first_ns = topic.last_ns = message.log_ns;
  topic.first_ns = std::min(topic.first_ns, message.log_ns);
  topic.last_ns = std::max(topic.last_ns, message.log_ns);
  messages_.push_back(message);
}

std::string ShortType(const std::string& type) {
  const size_t middle = type.find("/msg/");
  return middle == std::string::npos ? type : type.substr(0, middle) + type.substr(middle + 4);
}

Result<Done> Bag::Add(const fs::path& path, bool compressed_messages) {
  Result<Opened> opened = OpenFile(path, compressed_messages);
  if (!opened) return opened.error();
  container_ = opened->container;
  BagFile& file = *opened->file;
  std::vector<uint32_t> ours;  // our topic for each of the file
  for (const Topic& topic : file.topics()) {
    const auto same = std::find_if(topics_.begin(), topics_.end(), [&](const Topic& other) {
      return other.name == topic.name && other.type == topic.type &&
             other.serialization == topic.serialization;
    });
    ours.push_back(static_cast<uint32_t>(same - topics_.begin()));
    if (same == topics_.end()) {
      topics_.push_back(topic);
    } else if (topic.messages > 0) {
      same->first_ns =
          same->messages > 0 ? std::min(same->first_ns, topic.first_ns) : topic.first_ns;
      same->last_ns = same->messages > 0 ? std::max(same->last_ns, topic.last_ns) : topic.last_ns;
      same->messages += topic.messages;
    }
  }
  for (MessageRef message : file.messages()) {
    message.topic = ours[message.topic];
    message.file = static_cast<uint32_t>(files_.size());
    messages_.push_back(message);
  }
  for (const std::string& warning : file.warnings()) {
    warnings_.push_back(path.filename().string() + ": " + warning);
  }
  files_.push_back(std::move(opened->file));
  return Done{};
}

Result<std::unique_ptr<Bag>> Bag::Open(const fs::path& source) {
  auto bag = std::make_unique<Bag>();
  std::error_code error;
  if (!fs::exists(source, error)) {
    return Error{ErrorCode::kNotFound, source.string() + ": not there"};
  }
  if (!fs::is_directory(source, error)) {
    const Result<Done> added = bag->Add(source, false);
    if (!added) return added.error();
    return bag;
  }
  const Result<Folder> folder = ReadFolder(source, bag->warnings_);
  if (!folder) return folder.error();
  for (const fs::path& file : folder->files) {
    const Result<Done> added = bag->Add(file, folder->compressed_messages);
    if (added) continue;
    if (folder->files.size() == 1) return added.error();
    bag->warnings_.push_back(added.error().message + "; read without it");
  }
  if (bag->files_.empty()) return BadData(source, "none of its files can be read");
  return bag;
}

Result<Bytes> Bag::Read(const MessageRef& message) {
  return files_[message.file]->Read(message);
}

}  // namespace gw::bag
