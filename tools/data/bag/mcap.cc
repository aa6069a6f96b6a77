#include "tools/data/bag/mcap.h"

#include <fmt/format.h>
#include <zlib.h>

#include <map>
#include <set>
#include <string_view>

#include "tools/data/bag/chunks.h"

namespace gw::bag {
namespace {

constexpr std::string_view kMagic{"\x89MCAP0\r\n", 8};
// Opcodes that are read; the others are index and attachments.
constexpr uint8_t kFooter = 2, kSchema = 3, kChannel = 4, kMessage = 5, kChunk = 6, kDataEnd = 15;
constexpr uint64_t kLargestChunk = uint64_t{1} << 32;

class Mcap : public BagFile {
 public:
  explicit Mcap(Bytes bytes) : chunks_(bytes.subspan(kMagic.size()), kLargestChunk) {
    ReadRecords(chunks_.Block(0), 0);
    if (!closed_) {
      warnings_.push_back(
          fmt::format("was not closed (the recorder was killed, or the file is cut off); read from "
                      "its begin as far as it goes: {} messages",
                      messages_.size()));
    }
  }

  Result<Bytes> Read(const MessageRef& message) override {
    return chunks_.Block(message.block).subspan(message.offset, message.size);
  }

 private:
  // All records of the file (block 0) or of a chunk, up to the end of the data: a summary after it
  // repeats them.
  void ReadRecords(Bytes bytes, uint64_t block) {
    ByteCursor cursor(bytes);
    while (cursor.left() > 0) {
      const auto op = cursor.Read<uint8_t>();
      const auto size = cursor.Read<uint64_t>();
      if (!cursor.ok()) return;
      const uint64_t begin = cursor.position();
      const bool cut = size > cursor.left();
      const Bytes record = cursor.Take(cut ? cursor.left() : size);
      if (block == 0 && (op == kDataEnd || op == kFooter)) {
        closed_ = true;
        return;
      }
      if (op == kChunk && block == 0) {
        ReadChunk(record, kMagic.size() + begin);
      } else if (cut) {
        return;
      } else if (op == kSchema) {
        ReadSchema(record);
      } else if (op == kChannel) {
        ReadChannel(record);
      } else if (op == kMessage) {
        ReadMessage(record, block, begin);
      }
    }
  }

  void ReadSchema(Bytes record) {
    ByteCursor cursor(record);
    const auto id = cursor.Read<uint16_t>();
    const std::string name = cursor.Text();
    if (cursor.ok()) schemas_[id] = name;
  }

  void ReadChannel(Bytes record) {
    ByteCursor cursor(record);
    const auto id = cursor.Read<uint16_t>();
    const auto schema = cursor.Read<uint16_t>();
    Topic topic;
    topic.name = cursor.Text();
    const std::string encoding = cursor.Text();
    if (!cursor.ok() || channels_.contains(id)) return;
    if (const auto found = schemas_.find(schema); found != schemas_.end()) {
      topic.type = ShortType(found->second);
    }
    topic.serialization = encoding == "cdr"    ? Serialization::kCdr
                          : encoding == "ros1" ? Serialization::kRos1
                                               : Serialization::kOther;
    channels_[id] = static_cast<uint32_t>(topics_.size());
    topics_.push_back(topic);
  }

  void ReadMessage(Bytes record, uint64_t block, uint64_t begin) {
    ByteCursor cursor(record);
    const auto channel = channels_.find(cursor.Read<uint16_t>());
    cursor.Read<uint32_t>();  // sequence
    const auto log_time = cursor.Read<uint64_t>();
    cursor.Read<uint64_t>();  // publish time
    if (!cursor.ok() || channel == channels_.end()) return;
    AddMessage({channel->second, 0, static_cast<int64_t>(log_time), block,
                begin + cursor.position(), cursor.left()});
  }

  void ReadChunk(Bytes record, uint64_t position) {
    ByteCursor cursor(record);
    cursor.Read<uint64_t>();  // begin and end in time
    cursor.Read<uint64_t>();
    Chunk chunk;
    chunk.size = cursor.Read<uint64_t>();
    const auto crc = cursor.Read<uint32_t>();  // 0: not stated
    chunk.compression = cursor.Text();
    const auto size = cursor.Read<uint64_t>();
    if (!cursor.ok()) return;
    const bool whole = size <= cursor.left();
    chunk.data = cursor.Take(whole ? size : cursor.left());
    auto [bytes, problem] = chunks_.Add(position, chunk);
    if (whole && problem.empty() && crc != 0 && crc32_z(0, bytes.data(), bytes.size()) != crc) {
      problem = "does not have its checksum: some of it is damaged";
    }
    if (!problem.empty()) {
      warnings_.push_back(fmt::format("the chunk at byte {} {}; what can be read of it is used",
                                      position, problem));
    }
    ReadRecords(bytes, position);
  }

  std::map<uint16_t, std::string> schemas_;
  std::map<uint16_t, uint32_t> channels_;
  Chunks chunks_;
  bool closed_ = false;
};

}  // namespace

std::unique_ptr<BagFile> ReadMcap(Bytes bytes) {
  return std::make_unique<Mcap>(bytes);
}

bool IsMcap(Bytes bytes) {
  return TextOf(bytes).starts_with(kMagic);
}

}  // namespace gw::bag
