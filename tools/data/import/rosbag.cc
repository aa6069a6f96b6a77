#include "tools/data/import/rosbag.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "common/config/loader.h"
#include "tools/data/files/format.h"
#include "tools/data/import/bag_frames.h"
#include "tools/data/import/image_file.h"
#include "tools/data/import/imu_check.h"
#include "tools/data/import/nominal_camera.h"
#include "tools/data/import/ros_frames.h"
#include "tools/data/import/ros_images.h"
#include "tools/data/import/ros_messages.h"
#include "tools/data/import/ros_wheels.h"
#include "tools/data/import/sensor_yaml.h"
#include "tools/data/import/stated_size.h"
#include "tools/data/import/stereo_range.h"
#include "tools/data/import/streams.h"
#include "tools/data/import/trajectory.h"

namespace gw::importer {
namespace {

constexpr const char* kBodyFrame = "base_link";        // ROS REP 105: the mobile base
constexpr const char* kFloorFrame = "base_footprint";  // its projection on the floor

bool IsTransforms(const std::string& type) {
  return type == "tf2_msgs/TFMessage" || type == "tf/tfMessage";
}

// Everything of a bag but pixels.
struct Streams {
  std::vector<BagImage> left, right, depth;
  std::vector<ImuSample> imu, accel;
  std::string imu_frame;
  std::vector<StampedPose> odometry;
  std::string odometry_frame;
  std::vector<WheelAngles> angles;
  std::vector<RosTicks> ticks;
  std::vector<StampedPose> truth;
  std::string truth_frame;
  std::optional<RosCameraInfo> left_info, right_info;
  RosFrames frames;
  struct Spoilt {
    int64_t count = 0;
    std::string why;  // of the first
  };
  std::map<std::string, Spoilt> spoilt;      // by topic: messages that are of no use
  std::map<std::string, int64_t> unstamped;  // by topic: stamped with their time of arrival
};

class StreamReader {
 public:
  StreamReader(bag::Bag& bag, const RosTopics& topics, Streams& streams)
      : bag_(bag), topics_(topics), streams_(streams) {}

  void ReadAll() {
    for (const bag::MessageRef& ref : bag_.messages()) {
      const bag::Topic& topic = bag_.topics()[ref.topic];
      if (!Wanted(ref.topic, topic)) continue;
      const Result<bag::Bytes> bytes = bag_.Read(ref);
      const Result<Done> read =
          bytes ? ReadMessage(ref, topic, {*bytes, topic.serialization}) : bytes.error();
      if (read) continue;
      Streams::Spoilt& spoilt = streams_.spoilt[topic.name];
      if (++spoilt.count == 1) spoilt.why = read.error().message;
    }
  }

 private:
  bool Wanted(uint32_t i, const bag::Topic& topic) const {
    for (const auto& chosen :
         {topics_.left, topics_.right, topics_.depth, topics_.left_info, topics_.right_info,
          topics_.odometry, topics_.imu, topics_.accel, topics_.truth}) {
      if (chosen == i) return true;
    }
    return IsTransforms(topic.type);
  }

  // The stamp, or the time of arrival where the sender wrote none.
  Utime TimeOf(const bag::MessageRef& ref, const bag::Topic& topic, Utime stamp) {
    if (stamp.us != 0) return stamp;
    ++streams_.unstamped[topic.name];
    return {(ref.log_ns + 500) / 1000};
  }

  Result<Done> ReadMessage(const bag::MessageRef& ref, const bag::Topic& topic,
                           const RosMessage& message) {
    if (ref.topic == topics_.left || ref.topic == topics_.right || ref.topic == topics_.depth) {
      const Result<RosReader::Header> header = DecodeRosHeader(message);
      if (!header) return header.error();
      auto& images = ref.topic == topics_.left    ? streams_.left
                     : ref.topic == topics_.right ? streams_.right
                                                  : streams_.depth;
      images.push_back({TimeOf(ref, topic, header->utime()), ref});
      return Done{};
    }
    if (ref.topic == topics_.left_info || ref.topic == topics_.right_info) {
      auto& info = ref.topic == topics_.left_info ? streams_.left_info : streams_.right_info;
      if (info) return Done{};
      Result<RosCameraInfo> read = DecodeRosCameraInfo(message);
      if (!read) return read.error();
      info = *std::move(read);
      return Done{};
    }
    if (ref.topic == topics_.imu || ref.topic == topics_.accel) return ReadImu(ref, topic, message);
    if (ref.topic == topics_.odometry) return ReadOdometry(ref, topic, message);
    if (ref.topic == topics_.truth) {
      return ReadPose(ref, topic, message, streams_.truth, streams_.truth_frame);
    }
    Result<std::vector<RosPose>> transforms = DecodeRosTransforms(message);
    if (!transforms) return transforms.error();
    for (const RosPose& transform : *transforms) streams_.frames.Add(transform);
    return Done{};
  }

  Result<Done> ReadImu(const bag::MessageRef& ref, const bag::Topic& topic,
                       const RosMessage& message) {
    Result<ImuSample> sample = DecodeRosImu(message);
    if (!sample) return sample.error();
    sample->utime = TimeOf(ref, topic, sample->utime);
    if (ref.topic == topics_.accel) {
      streams_.accel.push_back(*sample);
      return Done{};
    }
    if (streams_.imu_frame.empty()) streams_.imu_frame = DecodeRosHeader(message)->frame;
    streams_.imu.push_back(*sample);
    return Done{};
  }

  Result<Done> ReadPose(const bag::MessageRef& ref, const bag::Topic& topic,
                        const RosMessage& message, std::vector<StampedPose>& poses,
                        std::string& frame) {
    const Result<RosPose> pose = DecodeRosPose(message, topic.type);
    if (!pose) return pose.error();
    poses.push_back({TimeOf(ref, topic, pose->utime), pose->T});
    if (frame.empty()) frame = pose->child;
    return Done{};
  }

  Result<Done> ReadOdometry(const bag::MessageRef& ref, const bag::Topic& topic,
                            const RosMessage& message) {
    if (IsPoseType(topic.type)) {
      return ReadPose(ref, topic, message, streams_.odometry, streams_.odometry_frame);
    }
    if (topic.type == "sensor_msgs/JointState") {
      const Result<RosJoints> joints = DecodeRosJoints(message);
      if (!joints) return joints.error();
      // Other joints may share the topic, in messages of their own.
      const std::optional<WheelJoints> wheels = FindWheelJoints(*joints);
      if (!wheels) return Done{};
      streams_.angles.push_back({TimeOf(ref, topic, joints->utime), joints->positions[wheels->left],
                                 joints->positions[wheels->right]});
      return Done{};
    }
    Result<RosTicks> ticks = DecodeKobukiTicks(message);
    if (!ticks) return ticks.error();
    ticks->utime = TimeOf(ref, topic, ticks->utime);
    streams_.ticks.push_back(*ticks);
    return Done{};
  }

  bag::Bag& bag_;
  const RosTopics& topics_;
  Streams& streams_;
};

// The frame that the recording's body is. Where the wheels' frame is right above base_footprint,
// that is taken: it moves alike, and is on the floor.
std::string BodyOf(const Streams& streams) {
  const RosFrames& frames = streams.frames;
  std::string body = streams.odometry_frame;
  if (body.empty() || !frames.Has(body)) {
    for (const char* known : {kFloorFrame, kBodyFrame}) {
      if (frames.Has(known)) return known;
    }
    return body;
  }
  const std::optional<SE3> T_FloorBody = frames.Pose(kFloorFrame, body);
  if (T_FloorBody && LogSO3(T_FloorBody->rotation()).norm() < 1e-6 &&
      T_FloorBody->translation().head<2>().norm() < 1e-6) {
    return kFloorFrame;
  }
  return body;
}

// Builds the recording out of the streams.
class Assembler {
 public:
  Assembler(const RosbagOptions& options, const RosTopics& topics, Streams& streams,
            Recording& recording)
      : options_(options),
        topics_(topics),
        streams_(streams),
        recording_(recording),
        body_(BodyOf(streams)),
        given_(!options.robot_config.empty() || !options.cid_sims_calibration.empty()) {}

  Result<Done> Assemble(std::unique_ptr<bag::Bag> bag) {
    Judge(*bag);
    if (!body_.empty()) recording_.notes.emplace_back("body", "frame " + body_ + " of the bag");
    if (topics_.left) {
      Result<Done> camera = AssembleCamera(std::move(bag));
      if (!camera) return camera;
    } else if (!given_) {
      SetNominalCamera(recording_.name + " has no images that are chosen", recording_);
    }
    Result<Done> wheels = AssembleWheels();
    if (!wheels) return wheels;
    AssembleImu();
    AssembleTruth();
    return Done{};
  }

 private:
  void Warn(const std::string& text) { recording_.warnings.push_back(text); }

  // What is of no use, and what carries no stamp.
  void Judge(const bag::Bag& bag) {
    for (const std::string& warning : bag.warnings()) Warn(warning);
    for (const auto& [topic, spoilt] : streams_.spoilt) {
      int64_t total = 0;
      for (const bag::Topic& t : bag.topics()) total += t.name == topic ? t.messages : 0;
      Warn(tools::Format("topic %s: %d of %d messages are of no use (%s); left out", topic,
                         spoilt.count, total, spoilt.why));
    }
    for (const auto& [topic, count] : streams_.unstamped) {
      Warn(tools::Format(
          "topic %s: %d messages have no stamp; their time of arrival is taken, which "
          "is late by an unknown and unsteady time",
          topic, count));
    }
  }

  // Pose of a frame of the bag in the body, or a guess with a warning.
  SE3 PoseInBody(const std::string& frame, const std::string& what, const SE3& guess,
                 const std::string& guessed) {
    const std::optional<SE3> T = streams_.frames.Pose(body_, frame);
    if (T && !body_.empty()) return *T;
    Warn(tools::Format(
        "tf does not tell where the frame '%s' of the %s is on the robot (%s); taken: "
        "%s. Correct it in the YAML, or record /tf_static",
        frame, what, body_.empty() ? "no frame of the base is known" : "from '" + body_ + "'",
        guessed));
    return guess;
  }

  Result<Done> SetCameraFromInfo(BagImageRules& rules) {
    CameraCalibration& camera = recording_.calibration.camera;
    const bool stereo = topics_.right.has_value();
    if (!streams_.left_info || (stereo && !streams_.right_info)) {
      return Error{ErrorCode::kBadData, "the bag has no CameraInfo of " +
                                            std::string(stereo ? "both eyes" : "the image") +
                                            "; give the calibration with --calibration ROBOT.yaml"};
    }
    RosCameraInfo left = *streams_.left_info;
    RosEye left_eye;
    if (stereo) {
      Result<RosStereo> made =
          MakeRosStereo(left, *streams_.right_info, rectified_,
                        streams_.frames.Pose(left.frame, streams_.right_info->frame));
      if (!made) return made.error();
      if (left.width != streams_.right_info->width || left.height != streams_.right_info->height) {
        Warn(tools::Format(
            "the left images are %d x %d, the right ones %d x %d: those were "
            "resampled to the left camera's size and focal length",
            left.width, left.height, streams_.right_info->width, streams_.right_info->height));
      }
      camera.kind = CameraKind::kStereo;
      camera.right = made->right.intrinsics;
      camera.T_C0C1 = made->T_C0C1;
      rules.right = std::move(made->right.undistorter);
      stated_right_ = {made->right.width, made->right.height};
      left_eye = std::move(made->left);
    } else {
      // Depth stays what it is only in the camera's own direction.
      if (!rectified_) left.R.fill(0);
      Result<RosEye> made = MakeRosEye(left, rectified_);
      if (!made) return made.error();
      camera.kind = CameraKind::kRgbd;
      left_eye = *std::move(made);
    }
    camera.left = left_eye.intrinsics;
    stated_left_ = {left_eye.width, left_eye.height};
    const SE3 T_OpticalImported(Eigen::Quaterniond(left_eye.R_FromImported),
                                Eigen::Vector3d::Zero());
    camera.T_BC = PoseInBody(left.frame, "camera", PoseOfBodyAtCamera(),
                             "looking ahead from the middle of the axle") *
                  T_OpticalImported;
    rules.left = std::move(left_eye.undistorter);
    if (rules.left) {
      recording_.notes.emplace_back("images", "undistorted on import (model " + left.model + ")");
    }
    return Done{};
  }

  Result<Done> AssembleCamera(std::unique_ptr<bag::Bag> bag) {
    CameraCalibration& camera = recording_.calibration.camera;
    const bool depth = topics_.depth.has_value();
    rectified_ = bag->topics()[*topics_.left].name.find("rect") != std::string::npos;
    BagImageRules rules;
    if (given_ && (camera.kind == CameraKind::kRgbd) != depth) {
      return Error{ErrorCode::kBadConfig, std::string("the calibration that is given is of kind ") +
                                              (depth ? "stereo; choose the eyes with --stereo L,R"
                                                     : "rgbd; choose the images with --rgbd I,D")};
    }
    if (!given_) {
      Result<Done> set = SetCameraFromInfo(rules);
      if (!set) return set;
    }
    rules.second_is_depth = depth;
    rules.depth_unit_m = camera.depth_unit_m;
    std::vector<BagImage>& second = depth ? streams_.depth : streams_.right;
    Result<Done> ordered = MakeOrdered(streams_.left, "images", recording_.warnings);
    if (ordered) {
      ordered = MakeOrdered(second, depth ? "depth images" : "right images", recording_.warnings);
    }
    if (!ordered) return ordered;
    Result<std::vector<BagPair>> pairs =
        PairImages(streams_.left, second, depth, recording_.warnings);
    if (!pairs) return pairs.error();
    recording_.frames =
        MakeBagFrames(std::move(bag), *std::move(pairs), recording_.name, std::move(rules));
    return DescribeImages();
  }

  Result<Done> DescribeImages() {
    CameraCalibration& camera = recording_.calibration.camera;
    const Result<FramePixels> first = recording_.frames->Load(0);
    if (!first) return first.error();
    if (first->left.converted) {
      recording_.notes.emplace_back("images", std::string("converted: ") + kGreyConversion);
    }
    if (first->depth.converted) {
      recording_.notes.emplace_back("images", "depth: 32-bit metres, rounded to the depth unit");
    }
    camera.width = first->left.width;
    camera.height = first->left.height;
    std::vector<Utime> times;
    for (size_t i = 0; i < recording_.frames->size(); ++i) {
      times.push_back(recording_.frames->utime(i));
    }
    const double rate_hz = MedianRateHz(times);
    if (rate_hz > 0) camera.rate_hz = rate_hz;
    if (given_) return Done{};
    for (const auto& [size, eye, name] : {std::tuple{stated_left_, &camera.left, "left"},
                                          {stated_right_, &camera.right, "right"}}) {
      if (size.first == 0) continue;
      Result<Done> fits =
          FitStatedSize(size.first, size.second, std::string("CameraInfo of the ") + name + " eye",
                        camera, eye, recording_.warnings);
      if (!fits) return fits;
    }
    if (camera.kind == CameraKind::kStereo) SetStereoRange(camera);
    return Done{};
  }

  Result<Done> AssembleWheels() {
    if (!topics_.odometry) return Done{};
    WheelCalibration& wheel = recording_.calibration.wheel;
    if (options_.track_m > 0) wheel.track_width_m = options_.track_m;
    if (!streams_.angles.empty()) {
      if (!(options_.wheel_radius_m > 0) || !(options_.track_m > 0)) {
        return Error{
            ErrorCode::kInvalidArgument,
            "the odometry is the angles of two wheels: their radius and distance are needed "
            "(--wheel-radius M --track M)"};
      }
      Result<Done> ordered = MakeOrdered(streams_.angles, "odometry", recording_.warnings);
      if (!ordered) return ordered;
      recording_.wheel =
          WheelsFromAngles(streams_.angles, options_.wheel_radius_m, options_.track_m);
    } else if (!streams_.ticks.empty()) {
      Result<Done> ordered = MakeOrdered(streams_.ticks, "odometry", recording_.warnings);
      if (!ordered) return ordered;
      recording_.wheel =
          WheelsFromTicks(streams_.ticks, {wheel.ticks_per_metre, wheel.track_width_m});
      recording_.notes.emplace_back("wheel",
                                    tools::Format("encoder counts, %.1f a metre, track %.4f m",
                                                  wheel.ticks_per_metre, wheel.track_width_m));
    } else {
      Result<Done> ordered = MakeOrdered(streams_.odometry, "odometry", recording_.warnings);
      if (!ordered) return ordered;
      recording_.wheel = WheelIncrements(streams_.odometry);
      if (given_) WarnOfForeignBody();
    }
    return Done{};
  }

  // A calibration that is given is of a body that the bag cannot name.
  void WarnOfForeignBody() {
    const std::string& frame = streams_.odometry_frame;
    if (frame.empty() || frame == options_.truth_child || frame == kBodyFrame ||
        frame == kFloorFrame) {
      return;
    }
    Warn("the odometry is of the frame " + frame +
         "; taken as the body of the calibration that is given. If that is another, dead reckoning "
         "is wrong");
  }

  void AssembleImu() {
    OrderImu(streams_.imu, "IMU", recording_.warnings);
    recording_.imu = std::move(streams_.imu);
    if (topics_.accel) AddAccelerometer();
    if (recording_.imu.empty() || given_) return;
    recording_.calibration.imu.T_BI =
        PoseInBody(streams_.imu_frame, "IMU", SE3(), "x ahead, y left, z up");
  }

  // The accelerometer, measured at other instants, interpolated to the gyro's.
  void AddAccelerometer() {
    OrderImu(streams_.accel, "accelerometer", recording_.warnings);
    size_t next = 0;
    for (ImuSample& gyro : recording_.imu) {
      while (next < streams_.accel.size() && streams_.accel[next].utime < gyro.utime) ++next;
      gyro.has_accel = next > 0 && next < streams_.accel.size();
      if (!gyro.has_accel) continue;
      const ImuSample& before = streams_.accel[next - 1];
      const ImuSample& after = streams_.accel[next];
      const double share =
          (gyro.utime - before.utime).seconds() / (after.utime - before.utime).seconds();
      gyro.a_I_m_s2 = before.a_I_m_s2 + share * (after.a_I_m_s2 - before.a_I_m_s2);
    }
    recording_.notes.emplace_back("imu", "the accelerometer is interpolated to the gyro's times");
  }

  void AssembleTruth() {
    std::string frame = streams_.truth_frame;
    std::vector<StampedPose>& truth = streams_.truth;
    if (!topics_.truth) {
      truth = streams_.frames.Motion(options_.truth_parent, options_.truth_child);
      frame.clear();
    }
    Result<Done> ordered = MakeOrdered(truth, "ground truth", recording_.warnings);
    if (!ordered) {
      Warn(ordered.error().message + ": no ground truth in the log");
      return;
    }
    if (truth.empty()) {
      Warn("no topic is a ground truth, and no transform leads from " + options_.truth_parent +
           " to " + options_.truth_child + ": no ground truth in the log");
      return;
    }
    const std::optional<SE3> T_BodyTruth =
        frame.empty() ? std::nullopt : streams_.frames.Pose(body_, frame);
    if (!frame.empty() && !T_BodyTruth && frame != body_) {
      Warn("tf does not tell where the frame '" + frame +
           "' of the ground truth is on the robot; taken as the body");
    }
    recording_.ground_truth = GroundTruthOfBody(truth, T_BodyTruth.value_or(SE3()));
  }

  const RosbagOptions& options_;
  const RosTopics& topics_;
  Streams& streams_;
  Recording& recording_;
  std::string body_;
  bool given_;  // the calibration is the user's
  bool rectified_ = false;
  std::pair<int, int> stated_left_, stated_right_;  // sizes that intrinsics are stated for
};

// The calibration that the user gives, if any. Returns T_ItoC of a CID-SIMS file.
Result<SE3> ReadGivenCalibration(const RosbagOptions& options, Recording& recording) {
  if (!options.robot_config.empty() && !options.cid_sims_calibration.empty()) {
    return Error{ErrorCode::kInvalidArgument,
                 "give either --calibration or --cid-sims-calibration, not both"};
  }
  if (!options.robot_config.empty()) {
    const Result<RobotConfig> config = LoadRobotConfig(options.robot_config.string());
    if (!config) return config.error();
    recording.calibration = config->calibration;
  } else if (!options.cid_sims_calibration.empty()) {
    return ReadCidSimsCalibration(options.cid_sims_calibration, options.mount, recording);
  }
  return SE3();
}

}  // namespace

Result<Recording> ReadRosbag(const std::filesystem::path& file, const RosbagOptions& options) {
  Recording recording;
  recording.format = "rosbag";
  recording.name = file.filename().empty() ? FolderName(file) : file.filename().string();
  const Result<SE3> T_ItoC = ReadGivenCalibration(options, recording);
  if (!T_ItoC) return T_ItoC.error();
  Result<std::unique_ptr<bag::Bag>> bag = bag::Bag::Open(file);
  if (!bag) return bag.error();
  const auto refused = [&](const Error& error) {
    return Error{error.code, recording.name + ": " + error.message};
  };
  if ((*bag)->messages().empty()) {
    std::string why;
    for (const std::string& warning : (*bag)->warnings()) why += "; " + warning;
    return Error{ErrorCode::kBadData, file.string() + ": holds no message" + why};
  }
  TopicWishes wishes = options.topics;
  if (!options.robot_config.empty() || !options.cid_sims_calibration.empty()) {
    wishes.kind = recording.calibration.camera.kind;
  }
  const Result<RosTopics> topics = ChooseTopics(**bag, wishes);
  if (!topics) return refused(topics.error());
  for (const std::string& choice : topics->choices) recording.notes.emplace_back("topic", choice);
  Streams streams;
  StreamReader(**bag, *topics, streams).ReadAll();
  const Result<Done> assembled =
      Assembler(options, *topics, streams, recording).Assemble(*std::move(bag));
  if (!assembled) return refused(assembled.error());
  if (!options.cid_sims_calibration.empty()) {
    std::vector<StampedPose> T_GC;
    for (const StampedPose& pose : streams.truth) {
      T_GC.push_back({pose.utime, pose.T * recording.calibration.camera.T_BC});
    }
    SetImuPose(*T_ItoC, ImuMatrix::kAuto, T_GC, recording);
  }
  return recording;
}

Result<std::string> ListRosbag(const std::filesystem::path& file, const RosbagOptions& options) {
  Result<std::unique_ptr<bag::Bag>> bag = bag::Bag::Open(file);
  if (!bag) return bag.error();
  std::string text = tools::Format("%s: %s, %d messages\n", file.string(), (*bag)->container(),
                                   (*bag)->messages().size());
  text += ListTopics(**bag);
  RosTopics none;
  Streams streams;
  StreamReader(**bag, none, streams).ReadAll();
  for (const std::string& frame : streams.frames.Describe()) text += "  tf: " + frame + "\n";
  const Result<RosTopics> topics = ChooseTopics(**bag, options.topics);
  if (!topics) return topics.error();
  text += "taken:\n";
  for (const std::string& choice : topics->choices) text += "  " + choice + "\n";
  for (const std::string& warning : (*bag)->warnings()) text += "warning: " + warning + "\n";
  return text;
}

}  // namespace gw::importer
