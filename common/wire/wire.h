// Contract structs <-> LCM messages. The bytes are exactly those of the lcm-gen types in ../*.lcm
// (wire_test.cc compares the two), so lcm-logger, lcm-spy and generated readers in any language
// work.
//
// The conversion is ours, not lcm-gen's, for two reasons: generated decoders allocate whatever a
// count field claims before they look at the message (a flipped bit asks for gigabytes), and they
// copy images twice.
//
// Decode refuses, with Error kBadData and a text that names the type, the field and the rule:
//   another fingerprint; too few or too many bytes; numbers that are not finite; quaternions whose
//   norm is off 1 by more than 1e-3 (others are normalised); enums, ids, counts, times and sequence
//   numbers out of range; intervals that end before they begin; images with implausible size,
//   stride or format; observations that are not sorted. No input can make it abort or allocate
//   more than a small multiple of the message.
// Decode(Encode(x)) gives x, bit for bit, for every x that obeys these rules.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/contract/dead_reckoning.h"
#include "common/contract/health.h"
#include "common/contract/map.h"
#include "common/contract/place.h"
#include "common/contract/samples.h"
#include "common/contract/tracking.h"
#include "common/core/result.h"

namespace gw::wire {

using Bytes = std::vector<uint8_t>;
using ByteSpan = std::span<const uint8_t>;

// Acknowledges reliable messages; see common/process/reliable.h.
struct Ack {
  Utime utime;
  int64_t seq = 0;
  int64_t session = 0;        // of the process that acknowledges
  int64_t acked_session = 0;  // of the process whose messages these are
  int64_t acked_seq = 0;      // everything up to here
};

// A note inside a log: provenance, synthetic streams, edits.
struct Note {
  Utime utime;
  int64_t seq = 0;
  std::string key;   // "source", "dr.synthetic", "edit.black", ...
  std::string text;  // neither may hold a NUL
};

// A camera message and the bytes that its images point into. Movable, not copyable.
struct DecodedCamera {
  DecodedCamera() = default;
  DecodedCamera(DecodedCamera&&) = default;
  DecodedCamera& operator=(DecodedCamera&&) = default;
  DecodedCamera(const DecodedCamera&) = delete;
  DecodedCamera& operator=(const DecodedCamera&) = delete;

  CameraFrame frame;
  Bytes storage;
};

// Images are written without row padding. Precondition: left is not empty.
Bytes Encode(const CameraFrame& frame);
Bytes Encode(const ImuSample& sample);
Bytes Encode(const WheelSample& sample);
Bytes Encode(const DrState& state);
Bytes Encode(const FramePose& pose);
Bytes Encode(const Pose& pose);
// KEYFRAME, MAP_UPDATE and MAP_REQUEST leave with Delivery zero (and seq of the struct where it has
// one); the sender stamps them with SetDelivery. Precondition: the parallel vectors of a keyframe
// have equal lengths.
Bytes Encode(const Keyframe& keyframe);
Bytes Encode(const MapUpdate& update);
Bytes Encode(const MapRequest& request);
Bytes Encode(const PlaceQuery& query);  // precondition: as many descriptors as features
Bytes Encode(const PlaceMatch& match);
Bytes Encode(const Ack& ack);
Bytes Encode(const Health& health);
Bytes Encode(const BaseCommand& command);
Bytes Encode(const GroundTruth& truth);
Bytes Encode(const Note& note);

// Takes the message over: the images of the result point into it. Depth images are 2-byte aligned.
Result<DecodedCamera> DecodeCamera(Bytes message);

// The same without a copy where that can be: the images point into the message, which must outlive
// them.
Result<DecodedCamera> ViewCamera(ByteSpan message);

template <typename T>
Result<T> Decode(ByteSpan message);
template <>
Result<DecodedCamera> Decode(ByteSpan message);  // copies the message once
template <>
Result<ImuSample> Decode(ByteSpan message);
template <>
Result<WheelSample> Decode(ByteSpan message);
template <>
Result<DrState> Decode(ByteSpan message);
template <>
Result<FramePose> Decode(ByteSpan message);
template <>
Result<Pose> Decode(ByteSpan message);
template <>
Result<Keyframe> Decode(ByteSpan message);
template <>
Result<MapUpdate> Decode(ByteSpan message);
template <>
Result<MapRequest> Decode(ByteSpan message);
template <>
Result<PlaceQuery> Decode(ByteSpan message);
template <>
Result<PlaceMatch> Decode(ByteSpan message);
template <>
Result<Ack> Decode(ByteSpan message);
template <>
Result<Health> Decode(ByteSpan message);
template <>
Result<BaseCommand> Decode(ByteSpan message);
template <>
Result<GroundTruth> Decode(ByteSpan message);
template <>
Result<Note> Decode(ByteSpan message);

// What every message of ours begins with, without decoding the rest.
struct Header {
  int64_t fingerprint = 0;
  Utime utime;
  int64_t seq = 0;
};
// Empty when the message is too short to be one of ours.
std::optional<Header> ReadHeader(ByteSpan message);

// LCM fingerprint of messages of `type` (a Channel::type, "imu_t"). Precondition: the type is in
// kChannels.
int64_t FingerprintOf(std::string_view type);

// Sequence of a KEYFRAME, MAP_UPDATE or MAP_REQUEST message, at fixed places behind the utime.
struct Delivery {
  int64_t seq = 0;
  int64_t session = 0;     // start time of the sending process, us
  int64_t oldest_seq = 0;  // oldest message the sender still holds
  bool operator==(const Delivery&) const = default;
};
// Precondition: `message` was encoded from one of the three structs.
void SetDelivery(const Delivery& delivery, Bytes& message);
// Empty when the message is not of one of the three types, or too short, or out of range.
std::optional<Delivery> ReadDelivery(ByteSpan message);

}  // namespace gw::wire
