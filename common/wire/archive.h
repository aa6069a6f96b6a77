// Writer and Reader of LCM's encoding (big-endian, fields in order, no padding) behind the same
// operations, so that one list of fields per type serves both ways. The operations also hold the
// rules of validity; the Writer does not apply them.
//
// A field list is `template <typename A> static void Fields(A& a, typename A::template Of<X>& x)`
// in namespace gw::wire itself: argument-dependent lookup does not see unnamed namespaces.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/wire/wire.h"

namespace gw::wire {

// Values beyond these cannot be added, subtracted or multiplied safely by those who get them.
inline constexpr int64_t kMaxTimeUs = 100'000'000'000'000'000;  // 3000 years
inline constexpr int64_t kMaxSeq = int64_t{1} << 62;
inline constexpr int64_t kMaxKeyframeId = int64_t{1} << 47;
inline constexpr int64_t kMaxLandmarkId = kMaxKeyframeId * LandmarkId::kMaxFeatures;
inline constexpr double kQuaternionNormTolerance = 1e-3;

// Types change. Those of before are read as well, without the fields that came later.
enum class TypeAge {
  kBeforePieces,   // of a map; nor are there keyframes that withdraw others
  kBeforeLengths,  // that are corrected
  kBeforeHeights,  // of keyframes, by dead reckoning
  kNow,
};
struct OlderType {
  int64_t fingerprint;
  TypeAge age;
};
using OlderTypes = std::initializer_list<OlderType>;

class Writer {
 public:
  template <typename T>
  using Of = const T;

  // Without a fingerprint: fields alone.
  Writer() = default;
  explicit Writer(int64_t fingerprint, size_t reserve = 1024) {
    bytes_.reserve(reserve);
    Big(static_cast<uint64_t>(fingerprint));
  }
  Bytes Take() && { return std::move(bytes_); }
  // What came after this age: all of it.
  static constexpr bool Has(TypeAge /*later_than*/) { return true; }

  void Time(const char*, Utime t) { Big(static_cast<uint64_t>(t.us)); }
  void Duration(const char*, int64_t us) { Big(static_cast<uint64_t>(us)); }
  template <typename T>
  void Int64(const char*, T value, int64_t, int64_t) {
    Big(static_cast<uint64_t>(value));
  }
  template <typename T>
  void Int32(const char*, T value, int64_t, int64_t) {
    Big(static_cast<uint32_t>(value));
  }
  void Bits64(uint64_t value) { Big(value); }
  void Byte(const char*, uint8_t value, int) { bytes_.push_back(value); }
  void Bool(const char*, bool value) { bytes_.push_back(value ? 1 : 0); }
  void Real(const char*, double value,  //
            double = -std::numeric_limits<double>::max(),
            double = std::numeric_limits<double>::max()) {
    Big(std::bit_cast<uint64_t>(value));
  }
  void Real32(const char*, float value) { Big(std::bit_cast<uint32_t>(value)); }
  void Text(const char*, const std::string& text) {
    const std::string_view shown(text.c_str());  // up to the first NUL
    Big(static_cast<uint32_t>(shown.size() + 1));
    Raw(shown.data(), shown.size());
    bytes_.push_back(0);
  }
  template <typename Element, typename Each>
  void List(const char*, const std::vector<Element>& list, size_t, size_t, Each each) {
    Big(static_cast<uint32_t>(list.size()));
    for (const Element& element : list) each(*this, element);
  }
  void Rule(const char*, const char*, bool) {}

  void Raw(const void* data, size_t size) {
    const auto* begin = static_cast<const uint8_t*>(data);
    bytes_.insert(bytes_.end(), begin, begin + size);
  }

 private:
  template <typename U>
  void Big(U value) {
    uint8_t big[sizeof(U)];
    for (size_t i = 0; i < sizeof(U); ++i) {
      big[i] = static_cast<uint8_t>(value >> (8 * (sizeof(U) - 1 - i)));
    }
    Raw(big, sizeof(U));
  }

  Bytes bytes_;
};

class Reader {
 public:
  template <typename T>
  using Of = T;

  // Fields alone.
  explicit Reader(ByteSpan fields) : type_(""), rest_(fields) {}
  // A whole message. type: for error texts. older: the type as it was before, which is understood,
  // too.
  Reader(const char* type, int64_t fingerprint, ByteSpan message, OlderTypes older = {})
      : type_(type), rest_(message) {
    const auto told = static_cast<int64_t>(Big<uint64_t>());
    if (told == fingerprint) return;
    const auto* const of_then = std::find_if(
        older.begin(), older.end(), [&](const OlderType& o) { return o.fingerprint == told; });
    if (of_then == older.end()) {
      Fail("fingerprint", "of another type");
    } else {
      age_ = of_then->age;
    }
  }
  // The message is of a type that has what came after this age.
  bool Has(TypeAge later_than) const { return age_ > later_than; }

  bool ok() const { return field_ == nullptr; }
  // After the last field: everything read, nothing left over.
  void End() {
    if (!rest_.empty()) Fail("end", "followed by bytes that belong to no field");
  }
  // Precondition: !ok().
  Error error() const {
    return {ErrorCode::kBadData,
            std::string(type_) + " message refused: " + field_ + " is " + rule_};
  }
  // The first failure is the one reported; everything read after it is zero.
  void Fail(const char* field, const char* rule) {
    if (!ok()) return;
    field_ = field;
    rule_ = rule;
    rest_ = {};
  }
  void Rule(const char* field, const char* broken, bool holds) {
    if (!holds) Fail(field, broken);
  }

  void Time(const char* field, Utime& t) { Int64(field, t.us, -kMaxTimeUs, kMaxTimeUs); }
  void Duration(const char* field, int64_t& us) { Int64(field, us, -kMaxTimeUs, kMaxTimeUs); }
  template <typename T>
  void Int64(const char* field, T& value, int64_t min, int64_t max) {
    const auto wire = static_cast<int64_t>(Big<uint64_t>());
    if (wire < min || wire > max) return Fail(field, "out of range");
    value = static_cast<T>(wire);
  }
  template <typename T>
  void Int32(const char* field, T& value, int64_t min, int64_t max) {
    const auto wire = static_cast<int32_t>(Big<uint32_t>());
    if (wire < min || wire > max) return Fail(field, "out of range");
    value = static_cast<T>(wire);
  }
  void Bits64(uint64_t& value) { value = Big<uint64_t>(); }
  void Byte(const char* field, uint8_t& value, int max) {
    value = Big<uint8_t>();
    if (value > max) Fail(field, "out of range");
  }
  void Bool(const char* field, bool& value) {
    const auto wire = Big<uint8_t>();
    if (wire > 1) return Fail(field, "neither 0 nor 1");
    value = wire == 1;
  }
  void Real(const char* field, double& value, double min = -std::numeric_limits<double>::max(),
            double max = std::numeric_limits<double>::max()) {
    value = std::bit_cast<double>(Big<uint64_t>());
    if (!std::isfinite(value)) return Fail(field, "not finite");
    if (value < min || value > max) Fail(field, "out of range");
  }
  void Real32(const char* field, float& value) {
    value = std::bit_cast<float>(Big<uint32_t>());
    if (!std::isfinite(value)) Fail(field, "not finite");
  }
  void Text(const char* field, std::string& text) {
    const auto size = Big<uint32_t>();
    const ByteSpan wire = Raw(size);
    if (!ok()) return;
    if (wire.empty() || wire.back() != 0) return Fail(field, "not terminated");
    if (std::memchr(wire.data(), 0, wire.size() - 1) != nullptr)
      return Fail(field, "broken by NUL");
    text.assign(wire.begin(), wire.end() - 1);
  }
  // element_bytes: what one element takes at least; bounds the allocation by the message size.
  template <typename Element, typename Each>
  void List(const char* field, std::vector<Element>& list, size_t max_count, size_t element_bytes,
            Each each) {
    const size_t count = Big<uint32_t>();
    if (count > max_count) return Fail(field, "too long");
    if (count * element_bytes > rest_.size()) return Fail(field, "longer than the message");
    list.resize(count);
    for (Element& element : list) each(*this, element);
  }

  // The next bytes as they are; empty and failed when there are fewer.
  ByteSpan Raw(size_t size) {
    if (size > rest_.size()) {
      Fail("length", "shorter than its type");
      return {};
    }
    const ByteSpan bytes = rest_.first(size);
    rest_ = rest_.subspan(size);
    return bytes;
  }

 private:
  template <typename U>
  U Big() {
    const ByteSpan big = Raw(sizeof(U));
    U value = 0;
    for (const uint8_t byte : big) value = static_cast<U>((uint64_t{value} << 8) | byte);
    return value;
  }

  const char* type_;
  ByteSpan rest_;
  TypeAge age_ = TypeAge::kNow;
  const char* field_ = nullptr;
  const char* rule_ = nullptr;
};

// Fields that occur in many types, in terms of the operations above.

template <typename A>
void Seq(A& a, const char* field, typename A::template Of<int64_t>& seq) {
  a.Int64(field, seq, 0, kMaxSeq);
}
template <typename A>
void ResetCounter(A& a, const char* field, typename A::template Of<uint32_t>& counter) {
  a.Int64(field, counter, 0, std::numeric_limits<uint32_t>::max());
}
template <typename A>
void Id(A& a, const char* field, typename A::template Of<KeyframeId>& id, bool required = true) {
  a.Int64(field, id.value, required ? 1 : 0, kMaxKeyframeId);
}
template <typename A>
void Id(A& a, const char* field, typename A::template Of<LandmarkId>& id, bool required = true) {
  a.Int64(field, id.value, required ? 1 : 0, kMaxLandmarkId);
}
template <typename A, typename E>
void Enum(A& a, const char* field, E& value, int32_t last) {
  a.Int32(field, value, 0, last);
}
template <typename A>
void Vector(A& a, const char* field, typename A::template Of<Eigen::Vector3d>& v) {
  for (int i = 0; i < 3; ++i) a.Real(field, v[i]);
}
// Position, then quaternion w x y z.
inline void Transform(Writer& a, const char* field, const SE3& T) {
  Vector(a, field, T.translation());
  const Eigen::Quaterniond& q = T.rotation();
  for (const double value : {q.w(), q.x(), q.y(), q.z()}) a.Real(field, value);
}
inline void Transform(Reader& a, const char* field, SE3& T) {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  Vector(a, field, p);
  for (double* value : {&q.w(), &q.x(), &q.y(), &q.z()}) a.Real(field, *value);
  if (!a.ok()) return;
  if (!(std::abs(q.norm() - 1.0) <= kQuaternionNormTolerance)) {
    return a.Fail(field, "rotated by a quaternion that is not of unit length");
  }
  T = SE3(q, p);
}
// Row-major, [translation; rotation].
template <typename A>
void Covariance(A& a, const char* field, typename A::template Of<Matrix6d>& cov) {
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 6; ++column) a.Real(field, cov(row, column));
  }
}
// 32 bytes; byte i holds bits 8i to 8i + 7.
template <typename A>
void DescriptorBytes(A& a, typename A::template Of<Descriptor>& descriptor) {
  if constexpr (std::is_same_v<A, Writer>) {
    uint8_t bytes[32];
    for (int i = 0; i < 32; ++i) bytes[i] = static_cast<uint8_t>(descriptor[i / 8] >> (i % 8 * 8));
    a.Raw(bytes, sizeof(bytes));
  } else {
    const ByteSpan bytes = a.Raw(32);
    descriptor = {};
    for (size_t i = 0; i < bytes.size(); ++i)
      descriptor[i / 8] |= uint64_t{bytes[i]} << (i % 8 * 8);
  }
}

template <typename T>
Bytes EncodeFields(int64_t fingerprint, const T& value) {
  Writer writer(fingerprint);
  Fields(writer, value);
  return std::move(writer).Take();
}

template <typename T>
Result<T> DecodeFields(const char* type, int64_t fingerprint, ByteSpan message,
                       OlderTypes older = {}) {
  Reader reader(type, fingerprint, message, older);
  T value;
  Fields(reader, value);
  reader.End();
  if (!reader.ok()) return reader.error();
  return value;
}

}  // namespace gw::wire
