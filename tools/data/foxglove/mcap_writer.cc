#include "tools/data/foxglove/mcap_writer.h"

#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace gw::foxglove {
namespace {

constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);
enum Opcode : uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0B,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F,
};

// The content of a record.
class Record {
 public:
  template <typename U>
  Record& Number(U value) {
    for (size_t i = 0; i < sizeof(U); ++i) {
      bytes_.push_back(static_cast<char>(static_cast<uint64_t>(value) >> (8 * i)));
    }
    return *this;
  }
  Record& Text(std::string_view text) {
    Number(static_cast<uint32_t>(text.size()));
    return Raw(text);
  }
  Record& Raw(std::string_view bytes) {
    bytes_.append(bytes);
    return *this;
  }
  size_t size() const { return bytes_.size(); }
  const std::string& bytes() const { return bytes_; }
  std::string As(Opcode opcode) const {
    Record head;
    head.Number(opcode).Number(static_cast<uint64_t>(bytes_.size()));
    return head.bytes() + bytes_;
  }

 private:
  std::string bytes_;
};

}  // namespace

uint32_t Crc32(std::string_view bytes) {
  return static_cast<uint32_t>(
      ::crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())));
}

Result<McapWriter> McapWriter::Create(const std::string& path) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) {
    return Error{ErrorCode::kIo, path + ": cannot be made: " + std::strerror(errno)};
  }
  McapWriter writer(path, file);
  const std::string header = Record().Text("").Text("Good Weights").As(kHeader);
  if (auto written = writer.Append(std::string(kMagic) + header); !written) return written.error();
  return writer;
}

Result<Done> McapWriter::Append(const std::string& bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size()) {
    return Error{ErrorCode::kIo, path_ + ": cannot be written: " + std::strerror(errno)};
  }
  position_ += bytes.size();
  return Done{};
}

uint16_t McapWriter::AddSchema(std::string_view name, std::string_view encoding,
                               std::string_view text) {
  const auto id = static_cast<uint16_t>(schemas_.size() + 1);
  schemas_.push_back(Record().Number(id).Text(name).Text(encoding).Text(text).As(kSchema));
  chunk_.records += schemas_.back();
  return id;
}

uint16_t McapWriter::AddChannel(uint16_t schema, std::string_view topic,
                                std::string_view encoding) {
  const auto id = static_cast<uint16_t>(channels_.size() + 1);
  channels_.push_back(
      Record().Number(id).Number(schema).Text(topic).Text(encoding).Text("").As(kChannel));
  chunk_.records += channels_.back();
  return id;
}

Result<Done> McapWriter::Write(uint16_t channel, uint64_t log_time, std::string_view data) {
  const bool first_of_chunk = chunk_.index.empty();
  chunk_.first_time = first_of_chunk ? log_time : std::min(chunk_.first_time, log_time);
  chunk_.last_time = first_of_chunk ? log_time : std::max(chunk_.last_time, log_time);
  first_time_ = message_count_ == 0 ? log_time : std::min(first_time_, log_time);
  last_time_ = std::max(last_time_, log_time);
  ++message_count_;
  ++counts_[channel];
  chunk_.index[channel].emplace_back(log_time, chunk_.records.size());
  chunk_.records += Record()
                        .Number(channel)
                        .Number(sequence_[channel]++)
                        .Number(log_time)
                        .Number(log_time)
                        .Raw(data)
                        .As(kMessage);
  return chunk_.records.size() >= kChunkBytes ? FlushChunk() : Done{};
}

Result<Done> McapWriter::FlushChunk() {
  if (chunk_.records.empty()) return Done{};
  const std::string record = Record()
                                 .Number(chunk_.first_time)
                                 .Number(chunk_.last_time)
                                 .Number(static_cast<uint64_t>(chunk_.records.size()))
                                 .Number(Crc32(chunk_.records))
                                 .Text("")  // no compression
                                 .Number(static_cast<uint64_t>(chunk_.records.size()))
                                 .Raw(chunk_.records)
                                 .As(kChunk);
  ChunkPlace place{
      chunk_.first_time, chunk_.last_time, position_, record.size(), 0, chunk_.records.size(), {}};
  std::string indices;
  for (auto& [channel, entries] : chunk_.index) {
    std::stable_sort(entries.begin(), entries.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    place.index_offsets[channel] = position_ + record.size() + indices.size();
    Record index;
    index.Number(channel).Number(static_cast<uint32_t>(entries.size() * 16));
    for (const auto& [time, offset] : entries) index.Number(time).Number(offset);
    indices += index.As(kMessageIndex);
  }
  place.index_length = indices.size();
  chunks_.push_back(std::move(place));
  chunk_ = {};
  return Append(record + indices);
}

std::string McapWriter::StatisticsRecord() const {
  Record record;
  record.Number(message_count_)
      .Number(static_cast<uint16_t>(schemas_.size()))
      .Number(static_cast<uint32_t>(channels_.size()))
      .Number(uint32_t{0})
      .Number(uint32_t{0})
      .Number(static_cast<uint32_t>(chunks_.size()))
      .Number(first_time_)
      .Number(last_time_)
      .Number(static_cast<uint32_t>(counts_.size() * 10));
  for (const auto& [channel, count] : counts_) record.Number(channel).Number(count);
  return record.As(kStatistics);
}

std::string McapWriter::ChunkIndexRecord(const ChunkPlace& place) {
  Record record;
  record.Number(place.first_time)
      .Number(place.last_time)
      .Number(place.offset)
      .Number(place.length)
      .Number(static_cast<uint32_t>(place.index_offsets.size() * 10));
  for (const auto& [channel, offset] : place.index_offsets) record.Number(channel).Number(offset);
  return record.Number(place.index_length)
      .Text("")
      .Number(place.records_size)
      .Number(place.records_size)
      .As(kChunkIndex);
}

Result<Done> McapWriter::WriteSummary() {
  const uint64_t summary_start = position_;
  std::string summary, offsets;
  const auto add_group = [&](Opcode opcode, const std::vector<std::string>& records) {
    const uint64_t start = summary_start + summary.size();
    for (const std::string& record : records) summary += record;
    const uint64_t length = summary_start + summary.size() - start;
    if (length > 0) {
      offsets += Record().Number(opcode).Number(start).Number(length).As(kSummaryOffset);
    }
  };
  std::vector<std::string> chunk_records;
  for (const ChunkPlace& place : chunks_) chunk_records.push_back(ChunkIndexRecord(place));
  add_group(kSchema, schemas_);
  add_group(kChannel, channels_);
  add_group(kStatistics, {StatisticsRecord()});
  add_group(kChunkIndex, chunk_records);
  const uint64_t offsets_start = summary_start + summary.size();
  // The CRC covers the summary and the footer up to the CRC itself.
  Record footer_head;
  footer_head.Number(kFooter).Number(uint64_t{20}).Number(summary_start).Number(offsets_start);
  const std::string covered = summary + offsets + footer_head.bytes();
  return Append(covered + Record().Number(Crc32(covered)).bytes() + std::string(kMagic));
}

Result<Done> McapWriter::Close() {
  if (auto written = FlushChunk(); !written) return written;
  if (auto written = Append(Record().Number(uint32_t{0}).As(kDataEnd)); !written) return written;
  if (auto written = WriteSummary(); !written) return written;
  if (std::fclose(file_.release()) != 0) {
    return Error{ErrorCode::kIo, path_ + ": cannot be written: " + std::strerror(errno)};
  }
  return Done{};
}

}  // namespace gw::foxglove
