// Messages between front-end and back-end.
#include <algorithm>
#include <gw_lcm/keyframe_t.hpp>
#include <gw_lcm/map_request_t.hpp>
#include <gw_lcm/map_update_t.hpp>
#include <gw_lcm/place_match_t.hpp>
#include <gw_lcm/place_query_t.hpp>

#include "common/wire/archive.h"

namespace gw::wire {
namespace {

constexpr int32_t kMaxCount = std::numeric_limits<int32_t>::max();
constexpr double kMaxReal = std::numeric_limits<double>::max();
constexpr int kMaxLevel = 31;

// Least bytes of one element of each list, from the fields in the .lcm files.
constexpr size_t kFeatureBytes = 61, kKeyframeUpdateBytes = 72, kKeyframeRemovalBytes = 72,
                 kLandmarkUpdateBytes = 100, kObservationBytes = 12, kLandmarkMergeBytes = 16,
                 kLandmarkIdBytes = 8, kDrEdgeWeightBytes = 24, kLoopEventBytes = 73;

// The types as they were: logs and maps of then are read, those of before there were pieces with
// everything in the map itself.
constexpr OlderTypes kKeyframesBefore = {{0x3666777e63bcbaf8, TypeAge::kBeforePieces},
                                         {0x4d4cf13dcd24c456, TypeAge::kBeforeLengths},
                                         {0x3598c0f1cc8c8301, TypeAge::kBeforeHeights}};
constexpr OlderTypes kMapUpdatesBefore = {
    {static_cast<int64_t>(0xc60eb93846af94b6), TypeAge::kBeforePieces},
    {static_cast<int64_t>(0xea9ec3d407e44639), TypeAge::kBeforeLengths}};

template <typename A>
void PieceField(A& a, const char* field, typename A::template Of<KeyframeId>& piece) {
  if (a.Has(TypeAge::kBeforePieces)) Id(a, field, piece, false);
}

template <typename A>
void LengthFactor(A& a, typename A::template Of<double>& factor) {
  if (!a.Has(TypeAge::kBeforeLengths)) return;
  a.Real("length_factor", factor, Keyframe::kLeastLengthFactor, Keyframe::kMostLengthFactor);
}

template <typename A>
void DeliveryFields(A& a, typename A::template Of<Delivery>& delivery) {
  Seq(a, "seq", delivery.seq);
  a.Duration("session", delivery.session);
  Seq(a, "oldest_seq", delivery.oldest_seq);
}
// Fields of delivery for messages whose struct knows only the seq, or nothing of its delivery.
template <typename A>
void DeliveryFields(A& a, typename A::template Of<int64_t>& seq) {
  Delivery delivery{.seq = seq};
  DeliveryFields(a, delivery);
  if constexpr (std::is_same_v<A, Reader>) seq = delivery.seq;
}

template <typename A>
void IncrementFields(A& a, typename A::template Of<DrIncrement>& m) {
  a.Time("dr.utime_begin", m.utime_begin);
  a.Time("dr.utime_end", m.utime_end);
  a.Rule("dr.utime_begin", "after dr.utime_end", m.utime_begin <= m.utime_end);
  Transform(a, "dr.T_BaBb", m.T_BaBb);
  Covariance(a, "dr.cov_T_BaBb_m2_rad2", m.cov);
  ResetCounter(a, "dr.reset_counter", m.reset_counter);
  a.Bool("dr.slip", m.slip);
  a.Bool("dr.synthetic", m.synthetic);
}

// A feature lives in three parallel vectors of the keyframe.
template <typename A>
void FeatureFields(A& a, typename A::template Of<Feature>& feature,
                   typename A::template Of<Descriptor>& descriptor,
                   typename A::template Of<LandmarkId>& landmark) {
  a.Real32("features.u_px", feature.u);
  a.Real32("features.v_px", feature.v);
  a.Real32("features.u_right_px", feature.u_right);
  a.Real32("features.depth_m", feature.depth);
  a.Real32("features.angle_rad", feature.angle);
  a.Byte("features.level", feature.level, kMaxLevel);
  DescriptorBytes(a, descriptor);
  Id(a, "features.landmark_id", landmark, false);
}

template <typename A>
void KeyframeHead(A& a, typename A::template Of<Keyframe>& m) {
  a.Time("utime", m.utime);
  int64_t seq = 0;
  DeliveryFields(a, seq);
  Id(a, "keyframe_id", m.id);
  Transform(a, "T_WC", m.T_WC);
  Covariance(a, "cov_T_WC_m2_rad2", m.cov_T_WC);
  Seq(a, "map_revision", m.map_revision);
  Id(a, "previous_keyframe_id", m.previous, false);
  PieceField(a, "piece_keyframe_id", m.piece);
  if (a.Has(TypeAge::kBeforePieces)) a.Bool("withdraws", m.withdraws);
  LengthFactor(a, m.length_factor);
}

template <typename A>
void HeightFields(A& a, typename A::template Of<std::optional<DrHeight>>& height) {
  if (!a.Has(TypeAge::kBeforeHeights)) return;
  bool has = height.has_value();
  DrHeight told = height.value_or(DrHeight{});
  a.Bool("has_height", has);
  a.Real("height_m", told.z);
  a.Real("height_var_m2", told.variance, 0, kMaxReal);
  ResetCounter(a, "height_reset_counter", told.reset_counter);
  a.Rule("height_var_m2", "not positive", !has || told.variance > 0);
  if constexpr (std::is_same_v<A, Reader>) {
    if (has) height = told;
  }
}

template <typename A>
void KeyframeCounts(A& a, typename A::template Of<Keyframe>& m) {
  a.Real("quality", m.q, 0, 1);
  a.Int32("num_tracked", m.num_tracked, 0, kMaxCount);
}

}  // namespace

static void Fields(Writer& a, const Keyframe& m) {
  GW_CHECK(m.descriptors.size() == m.features.size());
  GW_CHECK(m.landmarks.size() == m.features.size());
  KeyframeHead(a, m);
  a.Bool("has_dr", m.dr.has_value());
  IncrementFields(a, m.dr.value_or(DrIncrement{}));
  HeightFields(a, m.height);
  KeyframeCounts(a, m);
  a.Int32("num_features", m.features.size(), 0, 0);
  for (size_t i = 0; i < m.features.size(); ++i) {
    FeatureFields(a, m.features[i], m.descriptors[i], m.landmarks[i]);
  }
}

static void Fields(Reader& a, Keyframe& m) {
  KeyframeHead(a, m);
  bool has_dr = false;
  DrIncrement dr;
  a.Bool("has_dr", has_dr);
  IncrementFields(a, dr);
  if (has_dr) m.dr = dr;
  HeightFields(a, m.height);
  KeyframeCounts(a, m);
  size_t i = 0;
  a.List("features", m.features, LandmarkId::kMaxFeatures, kFeatureBytes,
         [&](Reader& each, Feature& feature) {
           if (i == 0) {
             m.descriptors.resize(m.features.size());
             m.landmarks.resize(m.features.size());
           }
           FeatureFields(each, feature, m.descriptors[i], m.landmarks[i]);
           ++i;
         });
}

template <typename A>
static void LandmarkFields(A& a, typename A::template Of<LandmarkUpdate>& m) {
  Id(a, "landmarks.landmark_id", m.id);
  Vector(a, "landmarks.p_W_m", m.p_W);
  Vector(a, "landmarks.normal_W", m.normal_W);
  a.Real32("landmarks.min_distance_m", m.min_distance);
  a.Real32("landmarks.max_distance_m", m.max_distance);
  DescriptorBytes(a, m.descriptor);
  a.List("landmarks.observations", m.observations, kMaxCount, kObservationBytes,
         [](A& each, typename A::template Of<Observation>& observation) {
           Id(each, "landmarks.observations.keyframe_id", observation.keyframe);
           each.Int32("landmarks.observations.feature_index", observation.feature_index, 0,
                      LandmarkId::kMaxFeatures - 1);
         });
  const auto& list = m.observations;
  a.Rule("landmarks.observations", "not sorted or not unique",
         std::adjacent_find(list.begin(), list.end(), std::greater_equal<>()) == list.end());
}

template <typename A>
static void Fields(A& a, typename A::template Of<MapUpdate>& m) {
  a.Time("utime", m.utime);
  DeliveryFields(a, m.seq);
  Seq(a, "revision", m.revision);
  Seq(a, "base_revision", m.base_revision);
  a.Rule("base_revision", "after revision", m.base_revision <= m.revision);
  a.Bool("snapshot", m.snapshot);
  a.Rule("base_revision", "not 0 in a snapshot", !m.snapshot || m.base_revision == 0);
  a.Bool("frozen", m.frozen);
  Id(a, "newest_keyframe_id", m.newest_keyframe, false);
  LengthFactor(a, m.length_factor);
  a.List("keyframes", m.keyframes, kMaxCount, kKeyframeUpdateBytes,
         [](A& each, typename A::template Of<KeyframeUpdate>& keyframe) {
           Id(each, "keyframes.keyframe_id", keyframe.id);
           each.Time("keyframes.keyframe_utime", keyframe.utime);
           Transform(each, "keyframes.T_WC", keyframe.T_WC);
           PieceField(each, "keyframes.piece_keyframe_id", keyframe.piece);
         });
  a.List("removed_keyframes", m.removed_keyframes, kMaxCount, kKeyframeRemovalBytes,
         [](A& each, typename A::template Of<KeyframeRemoval>& removal) {
           Id(each, "removed_keyframes.removed_keyframe_id", removal.id);
           Id(each, "removed_keyframes.parent_keyframe_id", removal.parent);
           Transform(each, "removed_keyframes.T_ParentC", removal.T_ParentC);
         });
  a.List("landmarks", m.landmarks, kMaxCount, kLandmarkUpdateBytes,
         [](A& each, auto& landmark) { LandmarkFields(each, landmark); });
  a.List("merged_landmarks", m.merged_landmarks, kMaxCount, kLandmarkMergeBytes,
         [](A& each, typename A::template Of<LandmarkMerge>& merge) {
           Id(each, "merged_landmarks.from_landmark_id", merge.from);
           Id(each, "merged_landmarks.into_landmark_id", merge.into);
         });
  a.List("removed_landmark_ids", m.removed_landmarks, kMaxCount, kLandmarkIdBytes,
         [](A& each, auto& id) { Id(each, "removed_landmark_ids", id); });
  a.List("dr_edges", m.dr_edges, kMaxCount, kDrEdgeWeightBytes,
         [](A& each, typename A::template Of<DrEdgeWeight>& edge) {
           Id(each, "dr_edges.from_keyframe_id", edge.from);
           Id(each, "dr_edges.to_keyframe_id", edge.to);
           each.Real("dr_edges.alpha", edge.alpha, 0, kMaxReal);
         });
  a.List("loops", m.loops, kMaxCount, kLoopEventBytes,
         [](A& each, typename A::template Of<LoopEvent>& loop) {
           Id(each, "loops.loop_from_keyframe_id", loop.from);
           Id(each, "loops.loop_to_keyframe_id", loop.to);
           each.Bool("loops.accepted", loop.accepted);
           Transform(each, "loops.T_correction", loop.T_correction);
         });
}

static void Fields(Writer& a, const PlaceQuery& m) {
  GW_CHECK(m.descriptors.size() == m.features.size());
  a.Time("utime", m.utime);
  Seq(a, "seq", m.seq);
  a.Int32("num_features", m.features.size(), 0, 0);
  for (size_t i = 0; i < m.features.size(); ++i) {
    FeatureFields(a, m.features[i], m.descriptors[i], LandmarkId{});
  }
}

static void Fields(Reader& a, PlaceQuery& m) {
  a.Time("utime", m.utime);
  Seq(a, "seq", m.seq);
  size_t i = 0;
  a.List("features", m.features, LandmarkId::kMaxFeatures, kFeatureBytes,
         [&](Reader& each, Feature& feature) {
           if (i == 0) m.descriptors.resize(m.features.size());
           LandmarkId none;
           FeatureFields(each, feature, m.descriptors[i], none);
           ++i;
         });
}

template <typename A>
static void Fields(A& a, typename A::template Of<PlaceMatch>& m) {
  a.Time("utime", m.utime);
  Seq(a, "seq", m.seq);
  Seq(a, "query_seq", m.query_seq);
  a.Bool("found", m.found);
  Transform(a, "T_WC", m.T_WC);
  Covariance(a, "cov_T_WC_m2_rad2", m.cov_T_WC);
  a.Int32("num_sights", m.num_sights, 0, kMaxCount);
  Seq(a, "map_revision", m.map_revision);
  Id(a, "keyframe_id", m.keyframe, false);
}

template <typename A>
static void Fields(A& a, typename A::template Of<MapRequest>& m) {
  a.Time("utime", m.utime);
  DeliveryFields(a, m.seq);
  a.Bool("has_guess", m.has_guess);
  Transform(a, "T_WC_guess", m.T_WC_guess);
}

namespace {

constexpr size_t kDeliveryOffset = 16;  // behind the fingerprint and the utime
constexpr size_t kDeliveryBytes = 24;

bool HasDelivery(ByteSpan message) {
  const auto header = ReadHeader(message);
  return header && message.size() >= kDeliveryOffset + kDeliveryBytes &&
         (header->fingerprint == gw_lcm::keyframe_t::getHash() ||
          header->fingerprint == gw_lcm::map_update_t::getHash() ||
          header->fingerprint == gw_lcm::map_request_t::getHash());
}

}  // namespace

Bytes Encode(const Keyframe& keyframe) {
  return EncodeFields(gw_lcm::keyframe_t::getHash(), keyframe);
}
template <>
Result<Keyframe> Decode(ByteSpan message) {
  return DecodeFields<Keyframe>("keyframe_t", gw_lcm::keyframe_t::getHash(), message,
                                kKeyframesBefore);
}

Bytes Encode(const MapUpdate& update) {
  return EncodeFields(gw_lcm::map_update_t::getHash(), update);
}
template <>
Result<MapUpdate> Decode(ByteSpan message) {
  return DecodeFields<MapUpdate>("map_update_t", gw_lcm::map_update_t::getHash(), message,
                                 kMapUpdatesBefore);
}

Bytes Encode(const MapRequest& request) {
  return EncodeFields(gw_lcm::map_request_t::getHash(), request);
}
template <>
Result<MapRequest> Decode(ByteSpan message) {
  return DecodeFields<MapRequest>("map_request_t", gw_lcm::map_request_t::getHash(), message);
}

Bytes Encode(const PlaceQuery& query) {
  return EncodeFields(gw_lcm::place_query_t::getHash(), query);
}
template <>
Result<PlaceQuery> Decode(ByteSpan message) {
  return DecodeFields<PlaceQuery>("place_query_t", gw_lcm::place_query_t::getHash(), message);
}

Bytes Encode(const PlaceMatch& match) {
  return EncodeFields(gw_lcm::place_match_t::getHash(), match);
}
template <>
Result<PlaceMatch> Decode(ByteSpan message) {
  return DecodeFields<PlaceMatch>("place_match_t", gw_lcm::place_match_t::getHash(), message);
}

void SetDelivery(const Delivery& delivery, Bytes& message) {
  GW_CHECK(HasDelivery(message));
  Writer writer;
  DeliveryFields(writer, delivery);
  const Bytes fields = std::move(writer).Take();
  std::copy(fields.begin(), fields.end(), message.begin() + kDeliveryOffset);
}

std::optional<Delivery> ReadDelivery(ByteSpan message) {
  if (!HasDelivery(message)) return std::nullopt;
  Reader reader(message.subspan(kDeliveryOffset, kDeliveryBytes));
  Delivery delivery;
  DeliveryFields(reader, delivery);
  if (!reader.ok()) return std::nullopt;
  return delivery;
}

}  // namespace gw::wire
