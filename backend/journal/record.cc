#include "backend/journal/record.h"

#include <zlib.h>

#include <algorithm>
#include <array>

#include "common/core/check.h"

namespace gw::backend {
namespace {

uint32_t Crc(std::span<const uint8_t> bytes) {
  return static_cast<uint32_t>(crc32_z(0, bytes.data(), bytes.size()));
}

void PutWord(uint32_t word, std::vector<uint8_t>& out) {
  for (int i = 0; i < 4; ++i) out.push_back(static_cast<uint8_t>(word >> (8 * i)));
}

uint32_t GetWord(std::span<const uint8_t> bytes, size_t index) {
  uint32_t word = 0;
  for (size_t i = 0; i < 4; ++i) word |= uint32_t{bytes[4 * index + i]} << (8 * i);
  return word;
}

}  // namespace

void AppendRecord(RecordType type, std::span<const uint8_t> payload, std::vector<uint8_t>& out) {
  GW_CHECK(payload.size() < (uint64_t{1} << 32));
  const size_t header = out.size();
  PutWord(kRecordMagic, out);
  PutWord(static_cast<uint32_t>(type), out);
  PutWord(static_cast<uint32_t>(payload.size()), out);
  PutWord(Crc(payload), out);
  PutWord(Crc(std::span(out).subspan(header, 16)), out);
  out.insert(out.end(), payload.begin(), payload.end());
}

bool BeginsWith(std::span<const uint8_t> bytes, std::string_view magic) {
  return bytes.size() >= magic.size() && std::equal(magic.begin(), magic.end(), bytes.begin());
}

bool IsOtherVersion(std::span<const uint8_t> bytes) {
  constexpr size_t kDigit = kFileMagic.size() - 2;
  return bytes.size() >= kFileMagic.size() &&
         std::equal(kFileMagic.begin(), kFileMagic.begin() + kDigit, bytes.begin()) &&
         bytes[kDigit] != kFileMagic[kDigit] && bytes[kDigit] != kFileMagicBefore[kDigit] &&
         bytes[kDigit] >= '0' && bytes[kDigit] <= '9' && bytes[kDigit + 1] == '\n';
}

RecordReader::RecordReader(std::span<const uint8_t> bytes) : bytes_(bytes) {
  if (BeginsWith(bytes, kFileMagic) || BeginsWith(bytes, kFileMagicBefore)) {
    good_end_ = kFileMagic.size();
  }
}

RecordReader::State RecordReader::Next(RecordView& record) {
  if (good_end_ == 0) {
    return bytes_.size() < kFileMagic.size() ? State::kTorn : State::kDamaged;
  }
  const std::span<const uint8_t> rest = bytes_.subspan(good_end_);
  if (rest.empty()) return State::kEnd;
  if (rest.size() < kRecordHeaderBytes) return State::kTorn;
  if (GetWord(rest, 0) != kRecordMagic || GetWord(rest, 4) != Crc(rest.first(16))) {
    return State::kDamaged;
  }
  const size_t length = GetWord(rest, 2);
  if (rest.size() - kRecordHeaderBytes < length) return State::kTorn;
  record.type = static_cast<RecordType>(GetWord(rest, 1));
  record.payload = rest.subspan(kRecordHeaderBytes, length);
  if (Crc(record.payload) != GetWord(rest, 3)) return State::kDamaged;
  good_end_ += kRecordHeaderBytes + length;
  record.end = good_end_;
  return State::kOk;
}

bool RecordReader::Resync() {
  for (size_t at = good_end_ + 1; at + kRecordHeaderBytes <= bytes_.size(); ++at) {
    if (GetWord(bytes_.subspan(at), 0) != kRecordMagic) continue;
    RecordReader there(*this);
    there.good_end_ = at;
    RecordView record{};
    if (there.Next(record) != State::kOk) continue;
    good_end_ = at;
    return true;
  }
  return false;
}

}  // namespace gw::backend
