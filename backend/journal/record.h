// Records of the map journal, and how a reader tells a torn end from damage.
//
// File: kFileMagic, then records. Record: header of five little-endian uint32
//   {kRecordMagic, type, payload length, crc32 of the payload, crc32 of the four words before}
// and the payload. Checksums are zlib's crc32. The header has its own, so that a flipped length
// is damage and not a record that seems to reach beyond the end.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace gw::backend {

// The digit is the format's version. Files of the one before, which knew no pieces of a map, are
// read, but not continued: what goes on is a new generation.
inline constexpr std::string_view kFileMagic = "GWMAPJ3\n";
inline constexpr std::string_view kFileMagicBefore = "GWMAPJ2\n";
inline constexpr uint32_t kRecordMagic = 0x52574721;  // "!GWR"
inline constexpr size_t kRecordHeaderBytes = 20;

enum class RecordType : uint32_t {
  kKeyframe = 1,    // wire::Encode(Keyframe), as inserted
  kMapUpdate = 2,   // wire::Encode(MapUpdate), as published
  kCheckpoint = 3,  // uint64 little-endian: Map::Hash() of everything before; ends a checkpoint
  kSession = 4,     // Encode(MapSession): who writes from here on
};

bool BeginsWith(std::span<const uint8_t> bytes, std::string_view magic);

// True when a file begins like a journal of another format version, which this program cannot read
// and must not replace.
bool IsOtherVersion(std::span<const uint8_t> bytes);

// Appends one record to `out`. Precondition: the payload is shorter than 4 GiB.
void AppendRecord(RecordType type, std::span<const uint8_t> payload, std::vector<uint8_t>& out);

struct RecordView {
  RecordType type;
  std::span<const uint8_t> payload;  // points into the file's bytes
  size_t end = 0;                    // offset behind the record
};

// Walks through a file's bytes; copies nothing.
class RecordReader {
 public:
  enum class State {
    kOk,       // Next() found a record
    kEnd,      // the bytes end with a record
    kTorn,     // they end inside one: the writer was cut off
    kDamaged,  // wrong magic or checksum; nothing behind it can be trusted
  };

  explicit RecordReader(std::span<const uint8_t> bytes);
  State Next(RecordView& record);
  // Goes on behind a damaged place, at the next record that is whole. False: there is none.
  bool Resync();
  // Behind the last good record (after Resync: before the next).
  size_t good_end() const { return good_end_; }

 private:
  std::span<const uint8_t> bytes_;
  size_t good_end_ = 0;
};

}  // namespace gw::backend
