#include "tools/data/bag/ros1_bag.h"

#include <fmt/format.h>

#include <map>
#include <optional>
#include <string_view>

#include "tools/data/bag/chunks.h"

namespace gw::bag {
namespace {

constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
// Values of the field `op` that are read; the others are parts of the index.
constexpr uint8_t kMessage = 2, kBagHeader = 3, kChunk = 5, kConnection = 7;
// The recorder's own chunks have 768 kB and one message more; this bounds what damage may claim.
constexpr uint64_t kLargestChunk = uint64_t{1} << 31;

struct Record {
  std::map<std::string, Bytes, std::less<>> fields;
  Bytes data;
  size_t data_position = 0;  // in what the record was read from
  bool cut = false;          // the input ends within data

  template <typename T>
  std::optional<T> Number(std::string_view name) const {
    const auto field = fields.find(name);
    if (field == fields.end() || field->second.size() != sizeof(T)) return std::nullopt;
    return ByteCursor(field->second).Read<T>();
  }
  std::string Text(std::string_view name) const {
    const auto field = fields.find(name);
    return field == fields.end() ? std::string() : std::string(TextOf(field->second));
  }
};

std::map<std::string, Bytes, std::less<>> ReadFields(Bytes header) {
  std::map<std::string, Bytes, std::less<>> fields;
  ByteCursor cursor(header);
  while (cursor.left() > 0) {
    const Bytes field = cursor.Block();
    const size_t equals = TextOf(field).find('=');
    if (!cursor.ok() || equals == std::string_view::npos) return fields;
    fields.emplace(TextOf(field).substr(0, equals), field.subspan(equals + 1));
  }
  return fields;
}

// The next record, or nothing where the input ends or holds no record.
std::optional<Record> ReadRecord(ByteCursor& cursor) {
  Record record;
  record.fields = ReadFields(cursor.Block());
  const auto size = cursor.Read<uint32_t>();
  if (!cursor.ok() || record.fields.empty()) return std::nullopt;
  record.data_position = cursor.position();
  record.cut = size > cursor.left();
  record.data = cursor.Take(record.cut ? cursor.left() : size);
  return record;
}

class Ros1Bag : public BagFile {
 public:
  explicit Ros1Bag(Bytes bytes)
      : size_(bytes.size()), chunks_(bytes.subspan(kMagic.size()), kLargestChunk) {
    ReadRecords(chunks_.Block(0), 0);
    if (!indexed_) {
      warnings_.emplace_back(
          "was not closed (the recorder was killed, or the file is cut off): it has no index; read "
          "from its begin as far as it goes");
    }
  }

  Result<Bytes> Read(const MessageRef& message) override {
    return chunks_.Block(message.block).subspan(message.offset, message.size);
  }

 private:
  // All records of the file (block 0) or of a chunk.
  void ReadRecords(Bytes bytes, uint64_t block) {
    ByteCursor cursor(bytes);
    while (cursor.left() > 0) {
      const size_t at = cursor.position();
      const std::optional<Record> record = ReadRecord(cursor);
      if (!record) {
        return Damaged(at, block, "holds no record there");
      }
      const uint8_t op = record->Number<uint8_t>("op").value_or(0);
      if (op == kChunk && block == 0) {
        ReadChunk(*record);
      } else if (record->cut) {
        return Damaged(at, block, "ends within a record");
      } else if (op == kMessage) {
        ReadMessage(*record, block);
      } else if (op == kConnection) {
        ReadConnection(*record);
      } else if (op == kBagHeader && block == 0) {
        const uint64_t index = record->Number<uint64_t>("index_pos").value_or(0);
        indexed_ = index > 0 && index <= size_;
      }
    }
  }

  void Damaged(size_t at, uint64_t block, const char* what) {
    warnings_.push_back(fmt::format("{} {} at byte {}; {} messages are before it",
                                    block == 0 ? "the file" : "a chunk", what,
                                    block == 0 ? at + kMagic.size() : at, messages_.size()));
  }

  void ReadConnection(const Record& record) {
    const std::optional<uint32_t> id = record.Number<uint32_t>("conn");
    if (!id || connections_.contains(*id)) return;
    const auto fields = ReadFields(record.data);
    Topic topic;
    topic.name = record.Text("topic");
    if (const auto type = fields.find("type"); type != fields.end()) {
      topic.type = TextOf(type->second);
    }
    topic.serialization = Serialization::kRos1;
    connections_[*id] = static_cast<uint32_t>(topics_.size());
    topics_.push_back(topic);
  }

  void ReadMessage(const Record& record, uint64_t block) {
    const auto connection = connections_.find(record.Number<uint32_t>("conn").value_or(UINT32_MAX));
    const std::optional<uint64_t> time = record.Number<uint64_t>("time");
    if (connection == connections_.end() || !time) return;
    const uint64_t seconds = *time & 0xffffffffu;
    AddMessage({connection->second, 0,
                static_cast<int64_t>(seconds * 1'000'000'000u + (*time >> 32)), block,
                record.data_position, record.data.size()});
  }

  void ReadChunk(const Record& record) {
    const uint64_t position = kMagic.size() + record.data_position;
    const auto [bytes, problem] = chunks_.Add(
        position,
        {record.data, record.Text("compression"), record.Number<uint32_t>("size").value_or(0)});
    if (!problem.empty()) {
      warnings_.push_back(
          fmt::format("the chunk at byte {} {}; what is before was read", position, problem));
    }
    if (record.cut) {
      warnings_.push_back(fmt::format("the file ends within the chunk at byte {}", position));
    }
    ReadRecords(bytes, position);
  }

  uint64_t size_;                             // of the file
  std::map<uint32_t, uint32_t> connections_;  // their number in the file, our topic
  Chunks chunks_;
  bool indexed_ = false;
};

}  // namespace

std::unique_ptr<BagFile> ReadRos1Bag(Bytes bytes) {
  return std::make_unique<Ros1Bag>(bytes);
}

bool IsRos1Bag(Bytes bytes) {
  return TextOf(bytes).starts_with(kMagic);
}

}  // namespace gw::bag
