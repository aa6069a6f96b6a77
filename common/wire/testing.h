// Random contract structs, valid ones, for tests of anything that sends or stores them.
#pragma once

#include <algorithm>
#include <vector>

#include "common/core/random.h"
#include "common/wire/frame_detail.h"
#include "common/wire/grid.h"
#include "common/wire/wire.h"

namespace gw::wire::testing {

class RandomMessages {
 public:
  explicit RandomMessages(uint64_t seed) : rng_(seed, 0, 0) {}

  bool Bool() { return rng_.Below(2) == 0; }
  int32_t Count(uint32_t n = 1000) { return static_cast<int32_t>(rng_.Below(n)); }
  double LengthFactor() { return 0.5 + rng_.Uniform(); }
  int64_t Big() { return static_cast<int64_t>(rng_.NextU64() >> 2); }
  Utime Time() { return {static_cast<int64_t>(rng_.NextU64() >> 14)}; }
  double Real() { return rng_.Normal() * std::pow(10.0, rng_.Uniform(-6, 6)); }
  float Real32() { return static_cast<float>(Real()); }
  uint32_t Word() { return static_cast<uint32_t>(rng_.NextU64()); }
  Eigen::Vector3d Vector() { return {Real(), Real(), Real()}; }
  SE3 Pose() {
    return {Eigen::Quaterniond(rng_.Normal(), rng_.Normal(), rng_.Normal(), rng_.Normal()),
            Vector()};
  }
  Matrix6d Covariance() {
    return Matrix6d::NullaryExpr([this] { return Real(); });
  }
  KeyframeId Keyframe() { return {1 + static_cast<int64_t>(rng_.Below(1u << 30))}; }
  LandmarkId Landmark() { return LandmarkId::From(Keyframe(), Count(1 << 14)); }
  Descriptor Bits() { return {rng_.NextU64(), rng_.NextU64(), rng_.NextU64(), rng_.NextU64()}; }
  std::string Text() {
    std::string text(rng_.Below(30), ' ');
    for (char& c : text) c = static_cast<char>(1 + rng_.Below(255));
    return text;
  }

  void Fill(ImuSample& m) { m = {Time(), Big(), Vector(), Vector(), Bool()}; }
  void Fill(WheelSample& m) {
    m.utime_begin = Time();
    m.utime = m.utime_begin + DurationUs{Count()};
    m.seq = Big();
    m.has_ticks = Bool();
    m.left_ticks = static_cast<uint16_t>(Word());
    m.right_ticks = static_cast<uint16_t>(Word());
    m.dx_m = Real();
    m.dy_m = Real();
    m.dyaw_rad = Real();
    m.has_heading = Bool();
    m.heading_rad = Real();
    m.contact = {Bool(), Bool(), Bool()};
  }
  void Fill(GroundTruth& m) { m = {Time(), Big(), Pose()}; }
  void Fill(BaseCommand& m) { m = {Time(), Big(), Real(), Real()}; }
  void Fill(Note& m) { m = {Time(), Big(), Text(), Text()}; }
  void Fill(Ack& m) { m = {Time(), Big(), Time().us, Time().us, Big()}; }
  void Fill(DrState& m) {
    m = {Time(), Big(), Word(), Pose(), Vector(), Vector(), Vector(), Vector()};
    m.wheel_scale = std::abs(Real());
    m.turn_scale = std::abs(Real());
    m.cov_T_OB = Covariance();
    m.cov_twist_white = Covariance();
    m.cov_twist_coherent = Covariance();
    m.way_scale_sigma = std::abs(Real());
    m.turn_scale_sigma = std::abs(Real());
    m.gravity_aligned = Bool();
    m.slip = Bool();
    m.stationary = Bool();
    m.wheels_alive = Bool();
    m.imu_alive = Bool();
    m.synthetic = Bool();
  }
  void Fill(FramePose& m) {
    m.utime = Time();
    m.seq = Big();
    m.T_WB = Pose();
    m.cov_T_WB = Covariance();
    m.motion_us = Count();
    m.cov_motion = Covariance();
    m.status = static_cast<TrackingStatus>(Count(7));
    m.reason = static_cast<TrackingReason>(Count(9));
    m.num_detected = Count();
    m.num_tracked = Count();
    m.num_inliers = Count();
    m.q = rng_.Uniform();
    m.alpha = std::abs(Real());
    m.dr_share = rng_.Uniform();
    m.map_revision = Big();
    m.reference_keyframe = Keyframe();
    m.T_KC = Pose();
    m.dr_seq = Big();
    m.dr_reset_counter = Word();
    m.latency_us = Count();
  }
  void Fill(FrameDetail& m) {
    m.utime = Time();
    m.seq = Big();
    m.q = rng_.Uniform();
    m.q_close = rng_.Uniform();
    m.alpha_translation = std::abs(Real());
    m.alpha_rotation = std::abs(Real());
    m.bounded_translation = std::abs(Real());
    m.bounded_rotation = std::abs(Real());
    m.bound = static_cast<AlphaBound>(Count(6));
    for (int i = 0; i < 6; ++i) m.dr_share[i] = rng_.Uniform();
    m.features.clear();
    for (int i = Count(40); i > 0; --i) {
      m.features.push_back({Real32(), Real32(), static_cast<FeatureFate>(Count(4))});
    }
  }
  void Fill(gw::Pose& m) {
    m.utime = Time();
    m.seq = Big();
    m.T_WB = Pose();
    m.cov_T_WB = Covariance();
    m.v_WB_B = Vector();
    m.w_WB_B = Vector();
    m.T_WO = Pose();
    m.cov_T_WO = Covariance();
    m.has_map = Bool();
    m.frame_pose_age_us = Count();
    m.frame_pose_seq = Big();
    m.map_revision = Big();
    m.dr_seq = Big();
    m.dr_reset_counter = Word();
    m.reset_counter = Word();
  }
  void Fill(Health& m) {
    m.utime = Time();
    m.seq = Big();
    m.process = Text();
    m.state = static_cast<HealthState>(Count(5));
    m.message = Text();
    m.counters.clear();
    for (int i = Count(6); i > 0; --i) m.counters.emplace_back(Text(), Big());
    m.latency_p50_us = Count();
    m.latency_p99_us = Count();
    m.latency_max_us = Count();
    m.queue_peak = Count();
    m.config_hash = rng_.NextU64();
    m.version = Text();
  }
  void Fill(gw::Keyframe& m) {
    m.id = Keyframe();
    m.utime = Time();
    m.T_WC = Pose();
    m.cov_T_WC = Covariance();
    m.map_revision = Big();
    m.previous = Keyframe();
    m.piece = Bool() ? Keyframe() : KeyframeId{};
    m.withdraws = Bool();
    m.length_factor = LengthFactor();
    m.dr.reset();
    if (Bool()) {
      DrIncrement& dr = m.dr.emplace();
      dr.utime_begin = Time();
      dr.utime_end = dr.utime_begin + DurationUs{Count()};
      dr.T_BaBb = Pose();
      dr.cov = Covariance();
      dr.reset_counter = Word();
      dr.slip = Bool();
      dr.synthetic = Bool();
    }
    m.height.reset();
    if (Bool()) m.height = DrHeight{Real(), LengthFactor(), Word()};
    m.q = rng_.Uniform();
    m.num_tracked = Count();
    m.features.clear();
    m.descriptors.clear();
    m.landmarks.clear();
    for (int i = Count(40); i > 0; --i) {
      m.features.push_back(
          {Real32(), Real32(), Real32(), Real32(), Real32(), static_cast<uint8_t>(Count(8))});
      m.descriptors.push_back(Bits());
      m.landmarks.push_back(Bool() ? Landmark() : LandmarkId{});
    }
  }
  void Fill(MapUpdate& m) {
    m = {};
    m.utime = Time();
    m.revision = Big();
    m.snapshot = Bool();
    m.base_revision = m.snapshot ? 0 : m.revision / 2;
    m.frozen = Bool();
    m.newest_keyframe = Keyframe();
    m.length_factor = LengthFactor();
    for (int i = Count(5); i > 0; --i)
      m.keyframes.push_back({Keyframe(), Time(), Pose(), Keyframe()});
    for (int i = Count(5); i > 0; --i)
      m.removed_keyframes.push_back({Keyframe(), Keyframe(), Pose()});
    for (int i = Count(20); i > 0; --i) {
      LandmarkUpdate landmark{Landmark(), Vector(), Vector(), Real32(), Real32(), Bits(), {}};
      auto& list = landmark.observations;
      for (int k = Count(9); k > 0; --k) list.push_back({Keyframe(), Count(1 << 14)});
      std::sort(list.begin(), list.end());
      list.erase(std::unique(list.begin(), list.end()), list.end());
      m.landmarks.push_back(landmark);
    }
    for (int i = Count(5); i > 0; --i) m.merged_landmarks.push_back({Landmark(), Landmark()});
    for (int i = Count(5); i > 0; --i) m.removed_landmarks.push_back(Landmark());
    for (int i = Count(5); i > 0; --i) {
      m.dr_edges.push_back({Keyframe(), Keyframe(), std::abs(Real())});
    }
    for (int i = Count(3); i > 0; --i) m.loops.push_back({Keyframe(), Keyframe(), Bool(), Pose()});
  }
  void Fill(MapRequest& m) { m = {Time(), Big(), Bool(), Pose()}; }
  void Fill(GridUpdate& m) {
    m = {Time(), Big(), Count(), Big(), Big(), 0.01 + rng_.Uniform(), {}};
    for (int i = Count(3); i > 0; --i) {
      GridTile& tile = m.tiles.emplace_back();
      tile.x = Count(1000) - 500;
      tile.y = static_cast<int32_t>(m.tiles.size()) - 2;
      tile.version = Big();
      for (CellState& cell : tile.cells) cell = static_cast<CellState>(Count(3));
    }
  }
  void Fill(ObstacleView& m) {
    m = {Time(), Big(), 0.01 + rng_.Uniform(), rng_.Uniform(), {}};
    for (int i = Count(20); i > 0; --i) m.obstacles.emplace_back(Real32(), Real32());
  }
  void Fill(PlaceQuery& m) {
    m = {Time(), Big(), {}, {}};
    for (int i = Count(40); i > 0; --i) {
      m.features.push_back(
          {Real32(), Real32(), Real32(), Real32(), Real32(), static_cast<uint8_t>(Count(8))});
      m.descriptors.push_back(Bits());
    }
  }
  void Fill(PlaceMatch& m) {
    m = {Time(), Big(), Big(), Bool(), Pose(), Covariance(), Count(), Big(), Keyframe()};
  }

  template <typename T>
  T Make() {
    T message;
    Fill(message);
    return message;
  }

  // Stereo or RGB-D with random pixels and row padding; the views point into `pixels`.
  CameraFrame Camera(Bytes& pixels) {
    CameraFrame frame;
    frame.utime = Time();
    frame.seq = Big();
    frame.exposure_us = Count();
    frame.emitter = static_cast<EmitterState>(Count(3));
    const int width = 1 + Count(40);
    const int height = 1 + Count(30);
    const int stride = width * 2 + 2 * Count(8);
    const size_t image_bytes = static_cast<size_t>(stride) * height;
    pixels.resize(2 * image_bytes);
    for (uint8_t& pixel : pixels) pixel = static_cast<uint8_t>(Word());
    frame.left = {pixels.data(), width, height, stride, PixelFormat::kGray8};
    ImageView& other = Bool() ? frame.right : frame.depth;
    other = frame.left;
    other.data += image_bytes;
    if (&other == &frame.depth) other.format = PixelFormat::kDepth16;
    return frame;
  }

 private:
  CounterRng rng_;
};

}  // namespace gw::wire::testing
