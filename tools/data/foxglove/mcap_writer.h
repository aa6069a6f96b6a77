// Writes MCAP files (https://mcap.dev/spec): schemas, channels and messages in chunks without
// compression, an index of the chunks, statistics, and a summary, so that viewers open them
// anywhere and at once. Little-endian; strings and arrays have their length in front.
//
//   magic | Header | (Chunk MessageIndex...)... | DataEnd | Schema... Channel... Statistics
//   ChunkIndex... SummaryOffset... | Footer | magic
#pragma once

#include <cstdint>
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/core/result.h"

namespace gw::foxglove {

class McapWriter {
 public:
  // Creates or overwrites. Error kIo: the path, what the system says.
  static Result<McapWriter> Create(const std::string& path);

  // Schemas and channels: before the first message of them. Ids count from 1 and are returned.
  uint16_t AddSchema(std::string_view name, std::string_view encoding, std::string_view text);
  uint16_t AddChannel(uint16_t schema, std::string_view topic, std::string_view encoding);
  // log_time: nanoseconds since the epoch.
  Result<Done> Write(uint16_t channel, uint64_t log_time, std::string_view data);
  // Writes the rest and the summary; the writer must not be used afterwards.
  Result<Done> Close();

  uint64_t messages() const { return message_count_; }
  uint64_t bytes() const { return position_; }

  static constexpr size_t kChunkBytes = 1u << 20;

 private:
  struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  struct Chunk {
    uint64_t first_time = 0, last_time = 0;
    std::string records;
    std::map<uint16_t, std::vector<std::pair<uint64_t, uint64_t>>> index;  // time, offset
  };
  struct ChunkPlace {
    uint64_t first_time, last_time, offset, length, index_length, records_size;
    std::map<uint16_t, uint64_t> index_offsets;
  };
  McapWriter(std::string path, std::FILE* file) : path_(std::move(path)), file_(file) {}

  Result<Done> Append(const std::string& bytes);
  Result<Done> FlushChunk();
  std::string StatisticsRecord() const;
  Result<Done> WriteSummary();
  static std::string ChunkIndexRecord(const ChunkPlace& place);

  std::string path_;
  std::unique_ptr<std::FILE, CloseFile> file_;
  uint64_t position_ = 0;
  std::vector<std::string> schemas_, channels_;  // records
  Chunk chunk_;
  std::vector<ChunkPlace> chunks_;
  std::map<uint16_t, uint64_t> counts_;
  uint64_t message_count_ = 0, first_time_ = 0, last_time_ = 0;
  std::map<uint16_t, uint32_t> sequence_;
};

// CRC-32 as in zlib and IEEE 802.3.
uint32_t Crc32(std::string_view bytes);

}  // namespace gw::foxglove
