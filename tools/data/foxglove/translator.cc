#include "tools/data/foxglove/translator.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/wire/channels.h"
#include "tools/data/files/format.h"
#include "tools/data/files/json.h"
#include "tools/data/foxglove/advice.h"
#include "tools/data/foxglove/explain.h"
#include "tools/data/foxglove/image_view.h"

namespace gw::foxglove {
namespace {

using tools::Format;

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr DurationUs kSilence = Milliseconds(3000);  // HEALTH comes once a second
constexpr int kInfo = 2, kWarning = 3, kError = 4;   // foxglove.LogLevel
constexpr size_t kPiecesPerMessage = 10;
constexpr double kMaxFloorCells = 400'000;

constexpr Color kDrColor{0.60, 0.60, 0.66, 0.8};
constexpr Color kTruthColor{0.45, 0.75, 0.45, 0.7};

Color ColorOf(TrackingStatus status) {
  switch (status) {
    case TrackingStatus::kTracking:
      return {0.16, 0.60, 0.93, 1};
    case TrackingStatus::kDegraded:
      return {0.98, 0.75, 0.14, 1};
    case TrackingStatus::kDrOnly:
      return {0.96, 0.42, 0.10, 1};
    case TrackingStatus::kRecovering:
      return {0.72, 0.38, 0.93, 1};
    case TrackingStatus::kLost:
      return {0.90, 0.15, 0.20, 1};
    default:
      return {0.60, 0.60, 0.60, 1};
  }
}

Json Transform(Utime utime, const char* parent, const char* child, const SE3& T) {
  const Json pose = JsonPose(T);
  return {{"timestamp", JsonTime(utime)},
          {"parent_frame_id", parent},
          {"child_frame_id", child},
          {"translation", pose["position"]},
          {"rotation", pose["orientation"]}};
}

Json Label(const Eigen::Vector3d& p_W, const Color& color, const std::string& text) {
  return {{"pose", JsonPose(SE3(Eigen::Quaterniond::Identity(), p_W))},
          {"billboard", true},
          {"font_size", 12.0},
          {"scale_invariant", true},
          {"color", JsonColor(color)},
          {"text", text}};
}

// Over the first keyframe of a piece (docs/adr/0047-pieces-of-a-map.md).
Json PieceLabel(const Json& first) {
  const Eigen::Vector3d above(first["x"].get<double>(), first["y"].get<double>(),
                              first["z"].get<double>() + 0.4);
  return Label(above, ColorOf(TrackingStatus::kRecovering), "piece, place unknown");
}

std::string StateName(HealthState state) {
  static constexpr const char* kNames[] = {"invalid", "starting", "ok", "degraded", "failed"};
  return kNames[std::clamp(static_cast<int>(state), 0, 4)];
}

}  // namespace

Translator::Translator(TranslatorOptions options) : options_(std::move(options)) {
  wanted_.set();
}

Message Translator::Make(Topic topic, const Json& json) const {
  return {topic, now_, std::make_shared<const std::string>(tools::JsonLine(json))};
}

void Translator::Emit(Topic topic, const Json& json) {
  if (Wants(topic)) messages_.push_back(Make(topic, json));
}

void Translator::Log(int level, const std::string& name, const std::string& text, Utime utime) {
  Emit(Topic::kLog, {{"timestamp", JsonTime(utime)},
                     {"level", level},
                     {"message", text},
                     {"name", name},
                     {"file", ""},
                     {"line", 0}});
}

template <typename T>
void Translator::TakeDecoded(wire::ByteSpan bytes, ChannelCount* count) {
  const Result<T> message = wire::Decode<T>(bytes);
  if (message) {
    Take(*message);
  } else {
    ++count->undecodable;
  }
}

void Translator::Take(std::string_view channel, wire::ByteSpan bytes, Utime received) {
  const wire::Channel* known = wire::FindChannel(channel);
  if (known == nullptr) return;
  now_ = received;
  ChannelCount& count = channels_[std::string(channel)];
  ++count.messages;
  // Reliable messages are sent again, and on HEALTH every process counts for itself.
  if (known->policy != wire::QueuePolicy::kReliable && channel != wire::kHealth) {
    if (const auto header = wire::ReadHeader(bytes)) {
      if (count.last_seq > 0 && header->seq > count.last_seq + 1) {
        count.lost += header->seq - count.last_seq - 1;
      }
      count.last_seq = header->seq;
    }
  }
  if (channel == wire::kCamera) Take(bytes);
  if (channel == wire::kFramePose) TakeDecoded<FramePose>(bytes, &count);
  if (channel == wire::kFrameDetail) TakeDecoded<FrameDetail>(bytes, &count);
  if (channel == wire::kPose) TakeDecoded<Pose>(bytes, &count);
  if (channel == wire::kDr) TakeDecoded<DrState>(bytes, &count);
  if (channel == wire::kKeyframe) TakeDecoded<Keyframe>(bytes, &count);
  if (channel == wire::kMapUpdate) TakeDecoded<MapUpdate>(bytes, &count);
  if (channel == wire::kHealth) TakeDecoded<Health>(bytes, &count);
  if (channel == wire::kGroundTruth) TakeDecoded<GroundTruth>(bytes, &count);
  if (channel == wire::kNote) TakeDecoded<wire::Note>(bytes, &count);
}

void Translator::Take(wire::ByteSpan camera) {
  if (!Wants(Topic::kImage) || !image_rate_.Pass(now_)) return;
  const auto decoded = wire::Decode<wire::DecodedCamera>(camera);
  if (!decoded) {
    ++channels_[wire::kCamera].undecodable;
    return;
  }
  const CameraFrame& frame = decoded->frame;
  const auto json = ImageMessage(frame.utime, frame.left);
  if (!json) return;
  image_scale_ = ImageScale(frame.left.width);
  Emit(Topic::kImage, *json);
  constexpr size_t kRemembered = 8;  // images on their way through the front-end
  if (sent_images_.size() >= kRemembered) sent_images_.erase(sent_images_.begin());
  sent_images_.push_back(frame.utime);
}

void Translator::Take(const FrameDetail& detail) {
  detail_ = detail;
  const bool sent =
      std::find(sent_images_.begin(), sent_images_.end(), detail.utime) != sent_images_.end();
  if (!sent || !Wants(Topic::kFeatures)) return;
  const bool distorted = options_.camera && (options_.camera->rectification.needed ||
                                             options_.camera->calibration.camera.left.distorted());
  Emit(Topic::kFeatures,
       FeaturesMessage(detail, image_scale_, distorted ? options_.camera : std::nullopt));
}

void Translator::Take(const FramePose& pose) {
  if (detail_ && detail_->utime != pose.utime) detail_.reset();
  const bool in_piece = map_.InPiece(pose.reference_keyframe);
  if (Wants(Topic::kWeights)) {
    Emit(Topic::kWeights, WeightsMessage(pose, detail_, in_piece));
  }
  if (!last_frame_ || last_frame_->status != pose.status) {
    const bool good = pose.status == TrackingStatus::kTracking;
    Log(good ? kInfo : kWarning, "gw-frontend",
        std::string(StatusName(pose.status)) + ": " + Explain(pose, detail_, in_piece), pose.utime);
  }
  constexpr double kJump = 0.3;  // m; more than a robot drives between two images, at 9 m/s
  if (last_frame_ && (pose.T_WB.translation() - last_frame_->T_WB.translation()).norm() > kJump) {
    way_.Break();
    Log(kWarning, "gw-frontend",
        Format("the pose jumped by %.2f m (map revision %d)",
               (pose.T_WB.translation() - last_frame_->T_WB.translation()).norm(),
               pose.map_revision),
        pose.utime);
  }
  way_.Add(pose.T_WB.translation(), ColorOf(pose.status), AnchorOf(pose));
  last_frame_ = pose;
  // Without a dead-reckoning process nobody sends POSE.
  if (!last_pose_received_ || now_ - *last_pose_received_ > Milliseconds(500)) {
    if (pose_rate_.Pass(now_)) SendTransforms(pose.utime, pose.T_WB);
    if (!unchecked_ && error_rate_.Pass(now_)) unchecked_ = {pose.utime, pose.T_WB};
  }
}

// Where the body is in the reference keyframe's camera; without a camera, as far as the map is
// known.
std::optional<LineScene::Anchor> Translator::AnchorOf(const FramePose& pose) const {
  const KeyframeId id = pose.reference_keyframe;
  if (!id.valid()) return std::nullopt;
  if (options_.camera) {
    const SE3 T_CB = options_.camera->rectified.T_BC.inverse();
    return LineScene::Anchor{id, (pose.T_KC * T_CB).translation()};
  }
  const auto T_WK = map_.PoseNow(id);
  if (!T_WK) return std::nullopt;
  return LineScene::Anchor{id, T_WK->inverse() * pose.T_WB.translation()};
}

void Translator::Take(const Pose& pose) {
  last_pose_received_ = now_;
  if (pose_reset_counter_ && *pose_reset_counter_ != pose.reset_counter) {
    Log(kInfo, "gw-dr-ekf",
        Format("POSE begins anew at another place (reset counter %d)", pose.reset_counter),
        pose.utime);
  }
  pose_reset_counter_ = pose.reset_counter;
  T_WO_ = pose.T_WO;
  if (pose_rate_.Pass(now_)) SendTransforms(pose.utime, pose.T_WB);
  if (!unchecked_ && error_rate_.Pass(now_)) unchecked_ = {pose.utime, pose.T_WB};
  // While vision says nothing the way goes on by dead reckoning.
  if (last_frame_ && pose.utime - last_frame_->utime > Milliseconds(500)) {
    way_.Add(pose.T_WB.translation(), ColorOf(TrackingStatus::kDrOnly), {});
  }
}

void Translator::SendTransforms(Utime utime, const SE3& T_WB) {
  if (Wants(Topic::kTransforms)) {
    Json transforms = {Transform(utime, "world", "odometry", T_WO_),
                       Transform(utime, "odometry", "body", T_WO_.inverse() * T_WB),
                       Transform(utime, "world", "floor", T_WG())};
    if (options_.camera) {
      transforms.push_back(Transform(utime, "body", "camera", options_.camera->rectified.T_BC));
    }
    Emit(Topic::kTransforms, {{"transforms", std::move(transforms)}});
  }
  if (Wants(Topic::kPose)) {
    Emit(Topic::kPose,
         {{"timestamp", JsonTime(utime)}, {"frame_id", "world"}, {"pose", JsonPose(T_WB)}});
  }
}

void Translator::Take(const DrState& state) {
  if (!T_WO_start_ || state.reset_counter != dr_reset_counter_) {
    dr_way_.Break();
    if (T_WO_start_) {
      Log(kWarning, "gw-dr-ekf",
          Format("dead reckoning begins anew (reset counter %d)", state.reset_counter),
          state.utime);
    }
    T_WO_start_ = T_WO_;
  }
  dr_reset_counter_ = state.reset_counter;
  dr_way_.Add((*T_WO_start_ * state.T_OB).translation(), kDrColor, {});
  if (!Wants(Topic::kDeadReckoning) || !dr_rate_.Pass(now_)) return;
  const Eigen::Vector3d bias = state.gyro_bias_rad_s * kDegrees;
  Emit(Topic::kDeadReckoning,
       {{"timestamp", JsonTime(state.utime)},
        {"speed_m_s", state.v_OB_B.x()},
        {"turn_rate_deg_s", state.w_OB_B.z() * kDegrees},
        {"slip", state.slip},
        {"stationary", state.stationary},
        {"wheels_alive", state.wheels_alive},
        {"imu_alive", state.imu_alive},
        {"wheel_scale", state.wheel_scale},
        {"turn_scale", state.turn_scale},
        {"gyro_bias_deg_s", {bias.x(), bias.y(), bias.z()}},
        {"sigma_position_m",
         std::sqrt(std::max(state.cov_T_OB.diagonal().head<3>().maxCoeff(), 0.0))},
        {"reset_counter", state.reset_counter}});
}

void Translator::Take(const MapUpdate& update) {
  const size_t loops = map_.loops().size();
  map_.Take(update);
  map_changed_ = true;
  way_.Follow(map_);
  for (size_t i = loops; i < map_.loops().size(); ++i) {
    const MapView::Loop& loop = map_.loops()[i];
    Log(kInfo, "gw-backend",
        Format("loop closed: keyframe %d is where %d was; corrected by %.3f m, %.2f deg",
               loop.from.value, loop.to.value, loop.T_correction.translation().norm(),
               LogSO3(loop.T_correction.rotation()).norm() * kDegrees),
        update.utime);
  }
}

void Translator::Take(const Health& health) {
  Process& process = processes_[health.process];
  const bool known = process.health.state != HealthState::kInvalid;
  process.before = std::exchange(process.health, health);
  process.received = now_;
  if (!known || process.before.state != health.state || process.before.message != health.message) {
    const int level = health.state == HealthState::kFailed     ? kError
                      : health.state == HealthState::kDegraded ? kWarning
                                                               : kInfo;
    Log(level, health.process,
        StateName(health.state) + (health.message.empty() ? "" : ": " + health.message),
        health.utime);
  }
  if (Wants(Topic::kHealth)) Emit(Topic::kHealth, HealthJson(health.process));
}

Json Translator::HealthJson(const std::string& name) const {
  const Process& process = processes_.at(name);
  const Health& h = process.health;
  const DurationUs silent = now_ - process.received;
  const bool gone = silent > kSilence;
  Json counters = Json::array();
  for (const auto& [counter, value] : h.counters) {
    const auto& before = process.before.counters;
    const auto old = std::find_if(before.begin(), before.end(),
                                  [&name = counter](const auto& c) { return c.first == name; });
    counters.push_back({{"name", counter},
                        {"value", value},
                        {"grew", old != before.end() && value > old->second}});
  }
  return {{"timestamp", JsonTime(h.utime)},
          {"process", h.process},
          {"state", gone ? "silent" : StateName(h.state)},
          {"message", gone ? Format("no HEALTH for %d s: dead, or the bus is cut",
                                    static_cast<int>(silent.seconds()))
                           : h.message},
          {"action", gone ? AdviceForSilent(h.process) : AdviceFor(h)},
          {"latency_p50_ms", static_cast<double>(h.latency_p50_us) * 1e-3},
          {"latency_p99_ms", static_cast<double>(h.latency_p99_us) * 1e-3},
          {"latency_max_ms", static_cast<double>(h.latency_max_us) * 1e-3},
          {"queue_peak", h.queue_peak},
          {"silent_s", std::max(silent.seconds(), 0.0)},
          {"version", h.version},
          {"counters", std::move(counters)}};
}

void Translator::Take(const GroundTruth& truth) {
  if (unchecked_ && last_truth_ && truth.utime > last_truth_->utime) {
    const Utime utime = unchecked_->first;
    if (utime >= last_truth_->utime && utime <= truth.utime) {
      const double fraction =
          (utime - last_truth_->utime).seconds() / (truth.utime - last_truth_->utime).seconds();
      SendError(utime, unchecked_->second, Interpolate(last_truth_->T_GB, truth.T_GB, fraction));
    }
    if (utime <= truth.utime) unchecked_.reset();
  }
  last_truth_ = truth;
  if (tie_.tied()) truth_way_.Add((T_WG() * truth.T_GB).translation(), kTruthColor, {});
}

void Translator::SendError(Utime utime, const SE3& T_WB, const SE3& T_GB) {
  tie_.Add(T_WB, T_GB);
  const SE3 error = (tie_.T_WG() * T_GB).inverse() * T_WB;
  squared_errors_ += error.translation().squaredNorm();
  ++num_errors_;
  Emit(Topic::kError, {{"timestamp", JsonTime(utime)},
                       {"position_m", error.translation().norm()},
                       {"heading_deg", YawOf(error.rotation()) * kDegrees},
                       {"rmse_m", std::sqrt(squared_errors_ / static_cast<double>(num_errors_))}});
}

SE3 Translator::T_WG() const {
  if (tie_.tied()) return tie_.T_WG();
  return options_.T_GB_start ? options_.T_GB_start->inverse() : SE3();
}

void Translator::Take(const wire::Note& note) {
  Log(kInfo, "note", note.key + ": " + note.text, note.utime);
}

void Translator::Tick(Utime now) {
  now_ = now;
  if (line_rate_.Pass(now_)) SendLines();
  if (map_changed_ && map_rate_.Pass(now_)) SendMap();
  if (!silent_rate_.Pass(now_)) return;
  for (const auto& [name, process] : processes_) {
    if (now_ - process.received > kSilence && Wants(Topic::kHealth)) {
      Emit(Topic::kHealth, HealthJson(name));
    }
  }
}

void Translator::SendLines() {
  if (!Wants(Topic::kTrajectory)) return;
  Json entities = Json::array();
  for (LineScene* line : {&way_, &dr_way_, &truth_way_}) {
    for (Json& entity : line->TakeChanged(now_)) entities.push_back(std::move(entity));
  }
  if (!entities.empty()) Emit(Topic::kTrajectory, SceneUpdate(std::move(entities)));
}

void Translator::SendMap() {
  map_changed_ = false;
  if (Wants(Topic::kKeyframes)) Emit(Topic::kKeyframes, KeyframesJson());
  if (Wants(Topic::kLandmarks)) Emit(Topic::kLandmarks, LandmarksJson());
  // A large map changes little in a second, and costs the more to tell.
  map_rate_.set_interval(Milliseconds(1000 + static_cast<int64_t>(map_.landmarks().size()) / 20));
}

Json Translator::KeyframesJson() const {
  const SE3 T_CB = options_.camera ? options_.camera->rectified.T_BC.inverse() : SE3();
  Json ticks = Json::array(), loops = Json::array();
  std::map<KeyframeId, Json> chains;  // by piece: nothing leads from one to another
  for (const auto& [id, keyframe] : map_.keyframes()) {
    constexpr double kTick = 0.15;  // m
    const SE3 T_WB = keyframe.T_WC * T_CB;
    chains.try_emplace(keyframe.piece, Json::array())
        .first->second.push_back(JsonVector(T_WB.translation()));
    ticks.push_back(JsonVector(T_WB.translation()));
    ticks.push_back(JsonVector(T_WB * Eigen::Vector3d(kTick, 0, 0)));
  }
  Json entity = SceneEntity("keyframes", now_);
  for (const MapView::Loop& loop : map_.loops()) {
    const auto from = map_.PoseNow(loop.from), to = map_.PoseNow(loop.to);
    if (!from || !to) continue;
    loops.push_back(JsonVector((*from * T_CB).translation()));
    loops.push_back(JsonVector((*to * T_CB).translation()));
    const Eigen::Vector3d above = (*from * T_CB).translation() + Eigen::Vector3d(0, 0, 0.4);
    entity["texts"].push_back(Label(above, {0.2, 0.8, 0.5, 1},
                                    Format("loop %.2f m", loop.T_correction.translation().norm())));
  }
  const Color grey{0.55, 0.58, 0.64, 0.6}, cyan{0.35, 0.80, 0.90, 0.9}, green{0.2, 0.8, 0.5, 1};
  const Color apart = ColorOf(TrackingStatus::kRecovering);
  entity["lines"] = {LinePrimitive(LineType::kList, 1.5, std::move(ticks), cyan, Json::array()),
                     LinePrimitive(LineType::kList, 3, std::move(loops), green, Json::array())};
  for (auto& [piece, chain] : chains) {
    if (piece.valid()) entity["texts"].push_back(PieceLabel(chain.front()));
    entity["lines"].push_back(LinePrimitive(LineType::kStrip, piece.valid() ? 2.5 : 1,
                                            std::move(chain), piece.valid() ? apart : grey,
                                            Json::array()));
  }
  return SceneUpdate(Json::array({std::move(entity)}));
}

Json Translator::LandmarksJson() const {
  PackedElements points;
  for (const auto& [id, landmark] : map_.landmarks()) {
    for (int i = 0; i < 3; ++i) points.AddFloat(landmark.p_W[i]);
    // Proven landmarks (docs/glossary.md) are bright.
    const bool proven = landmark.num_observations >= 3;
    for (const int byte : {proven ? 110 : 130, proven ? 190 : 130, proven ? 255 : 140, 255}) {
      points.AddByte(static_cast<uint8_t>(byte));
    }
  }
  return {
      {"timestamp", JsonTime(now_)},
      {"frame_id", "world"},
      {"pose", JsonPose(SE3())},
      {"point_stride", 16},
      {"fields",
       {PackedField("x", 0, kFloat32), PackedField("y", 4, kFloat32), PackedField("z", 8, kFloat32),
        PackedField("red", 12, kUint8), PackedField("green", 13, kUint8),
        PackedField("blue", 14, kUint8), PackedField("alpha", 15, kUint8)}},
      {"data", points.base64()}};
}

Json Translator::FloorJson() const {
  const FloorCells& floor = *options_.floor;
  const double cells = static_cast<double>(floor.width) * floor.height;
  const int merge = std::max(1, static_cast<int>(std::ceil(std::sqrt(cells / kMaxFloorCells))));
  const int columns = (floor.width + merge - 1) / merge;
  const int rows = (floor.height + merge - 1) / merge;
  std::vector<uint8_t> occupied(static_cast<size_t>(columns) * rows, 0);
  for (int y = 0; y < floor.height; ++y) {
    for (int x = 0; x < floor.width; ++x) {
      if (floor.occupied[static_cast<size_t>(y) * floor.width + x] != 0) {
        occupied[static_cast<size_t>(y / merge) * columns + x / merge] = 255;
      }
    }
  }
  const Eigen::Vector3d origin(floor.origin.x(), floor.origin.y(), 0);
  const double size = floor.resolution * merge;
  return {{"timestamp", JsonTime(now_)},
          {"frame_id", "floor"},
          {"pose", JsonPose(SE3(Eigen::Quaterniond::Identity(), origin))},
          {"column_count", columns},
          {"cell_size", {{"x", size}, {"y", size}}},
          {"row_stride", columns},
          {"cell_stride", 1},
          {"fields", Json::array({PackedField("occupied", 0, kUint8)})},
          {"data", Base64(occupied)}};
}

std::vector<Message> Translator::Drain() {
  return std::exchange(messages_, {});
}

std::vector<Message> Translator::State(Topic topic) {
  std::vector<Message> messages;
  switch (topic) {
    case Topic::kTrajectory: {
      Json entities = Json::array();
      const Json clear = {{"timestamp", JsonTime(now_)}, {"type", 1}, {"id", ""}};
      messages.push_back(
          Make(topic, {{"deletions", Json::array({clear})}, {"entities", Json::array()}}));
      for (LineScene* line : {&way_, &dr_way_, &truth_way_}) {
        for (Json& entity : line->All(now_)) {
          entities.push_back(std::move(entity));
          if (entities.size() < kPiecesPerMessage) continue;
          messages.push_back(Make(topic, SceneUpdate(std::exchange(entities, Json::array()))));
        }
      }
      if (!entities.empty()) messages.push_back(Make(topic, SceneUpdate(std::move(entities))));
      break;
    }
    case Topic::kKeyframes:
      messages.push_back(Make(topic, KeyframesJson()));
      break;
    case Topic::kLandmarks:
      messages.push_back(Make(topic, LandmarksJson()));
      break;
    case Topic::kFloor:
      if (options_.floor) messages.push_back(Make(topic, FloorJson()));
      break;
    case Topic::kCalibration:
      if (options_.camera) {
        messages.push_back(Make(topic, CalibrationMessage(now_, options_.camera->rectified)));
      }
      break;
    case Topic::kHealth:
      for (const auto& [name, process] : processes_) {
        messages.push_back(Make(topic, HealthJson(name)));
      }
      break;
    default:
      break;
  }
  return messages;
}

}  // namespace gw::foxglove
