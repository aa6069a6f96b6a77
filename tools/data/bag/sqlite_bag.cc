#include "tools/data/bag/sqlite_bag.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <map>
#include <string_view>
#include <utility>

#include "tools/data/bag/decompress.h"

namespace gw::bag {
namespace {

constexpr std::string_view kMagic{"SQLite format 3\0", 16};
constexpr uint64_t kLargestMessage = uint64_t{1} << 31;

struct CloseDatabase {
  void operator()(sqlite3* database) const { sqlite3_close(database); }
};
struct CloseStatement {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Database = std::unique_ptr<sqlite3, CloseDatabase>;
using Statement = std::unique_ptr<sqlite3_stmt, CloseStatement>;

Statement Prepare(sqlite3* database, const char* sql) {
  sqlite3_stmt* statement = nullptr;
  sqlite3_prepare_v2(database, sql, -1, &statement, nullptr);
  return Statement(statement);
}

std::string TextColumn(sqlite3_stmt* statement, int column) {
  const unsigned char* const text = sqlite3_column_text(statement, column);
  return text == nullptr ? "" : reinterpret_cast<const char*>(text);
}

Bytes BlobColumn(sqlite3_stmt* statement, int column) {
  const void* const data = sqlite3_column_blob(statement, column);
  const int size = sqlite3_column_bytes(statement, column);
  return {static_cast<const uint8_t*>(data), data == nullptr ? 0 : static_cast<size_t>(size)};
}

class SqliteBag : public BagFile {
 public:
  SqliteBag(Database database, bool compressed)
      : database_(std::move(database)), compressed_(compressed) {}

  Result<Done> ReadTables() {
    const Statement topics =
        Prepare(database_.get(), "SELECT id, name, type, serialization_format FROM topics");
    const Statement messages =
        Prepare(database_.get(), "SELECT id, topic_id, timestamp FROM messages ORDER BY id");
    by_id_ = Prepare(database_.get(), "SELECT data FROM messages WHERE id = ?");
    if (!topics || !messages || !by_id_) return NotABag();
    int code = SQLITE_ROW;
    while ((code = sqlite3_step(topics.get())) == SQLITE_ROW) {
      Topic topic;
      topic.name = TextColumn(topics.get(), 1);
      topic.type = ShortType(TextColumn(topics.get(), 2));
      topic.serialization =
          TextColumn(topics.get(), 3) == "cdr" ? Serialization::kCdr : Serialization::kOther;
      topic_of_id_[sqlite3_column_int64(topics.get(), 0)] = static_cast<uint32_t>(topics_.size());
      topics_.push_back(topic);
    }
    if (code != SQLITE_DONE) return NotABag();
    while ((code = sqlite3_step(messages.get())) == SQLITE_ROW) {
      const auto topic = topic_of_id_.find(sqlite3_column_int64(messages.get(), 1));
      if (topic == topic_of_id_.end()) continue;
      AddMessage({topic->second, 0, sqlite3_column_int64(messages.get(), 2),
                  static_cast<uint64_t>(sqlite3_column_int64(messages.get(), 0)), 0, 0});
    }
    if (code != SQLITE_DONE) {
      warnings_.push_back(fmt::format("is damaged ({}); the {} messages before the damage are read",
                                      sqlite3_errmsg(database_.get()), messages_.size()));
    }
    return Done{};
  }

  Result<Bytes> Read(const MessageRef& message) override {
    sqlite3_reset(by_id_.get());
    sqlite3_bind_int64(by_id_.get(), 1, static_cast<int64_t>(message.block));
    if (sqlite3_step(by_id_.get()) != SQLITE_ROW) {
      return Error{ErrorCode::kBadData, fmt::format("message {} cannot be read: {}", message.block,
                                                    sqlite3_errmsg(database_.get()))};
    }
    const Bytes data = BlobColumn(by_id_.get(), 0);
    if (!compressed_) return data;
    Decompressed unpacked = Decompress("zstd", data, kLargestMessage);
    if (!unpacked.problem.empty()) return Error{ErrorCode::kBadData, unpacked.problem};
    unpacked_ = std::move(unpacked.bytes);
    return Bytes(unpacked_);
  }

 private:
  Error NotABag() const {
    return {ErrorCode::kBadData, fmt::format("is no database of rosbag2 that can be read ({})",
                                             sqlite3_errmsg(database_.get()))};
  }

  Database database_;
  Statement by_id_;
  bool compressed_;
  std::map<int64_t, uint32_t> topic_of_id_;
  std::vector<uint8_t> unpacked_;
};

// Read-only as it is; where its folder cannot be written, and a log of the recorder is beside it,
// SQLite can only open it as one that nobody changes.
Database OpenDatabase(const std::filesystem::path& file) {
  for (const char* suffix : {"?mode=ro", "?immutable=1"}) {
    std::string uri = "file:";
    for (const char c : std::filesystem::absolute(file).string()) {
      const bool reserved = c == '?' || c == '#' || c == '%';
      uri += reserved ? fmt::format("%{:02x}", static_cast<unsigned char>(c)) : std::string(1, c);
    }
    sqlite3* handle = nullptr;
    const int code = sqlite3_open_v2((uri + suffix).c_str(), &handle,
                                     SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, nullptr);
    Database database(handle);
    if (code == SQLITE_OK && sqlite3_exec(handle, "SELECT 1 FROM sqlite_master", nullptr, nullptr,
                                          nullptr) == SQLITE_OK) {
      return database;
    }
  }
  return nullptr;
}

}  // namespace

Result<std::unique_ptr<BagFile>> ReadSqliteBag(const std::filesystem::path& file,
                                               bool compressed_messages) {
  Database database = OpenDatabase(file);
  if (!database) {
    return Error{ErrorCode::kBadData, "cannot be opened as an SQLite3 database; is it cut off?"};
  }
  auto bag = std::make_unique<SqliteBag>(std::move(database), compressed_messages);
  const Result<Done> read = bag->ReadTables();
  if (!read) return read.error();
  return std::unique_ptr<BagFile>(std::move(bag));
}

bool IsSqlite(Bytes bytes) {
  return TextOf(bytes).starts_with(kMagic);
}

}  // namespace gw::bag
