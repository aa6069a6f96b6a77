#include "tools/data/import/rosbag.h"

#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <deque>
#include <map>
#include <set>
#include <vector>

#include "common/config/loader.h"
#include "tools/data/import/image_file.h"
#include "tools/data/import/imu_check.h"
#include "tools/data/import/ros_messages.h"
#include "tools/data/import/streams.h"
#include "tools/data/import/trajectory.h"

namespace gw::importer {
namespace {

constexpr const char* kBodyFrame = "base_link";        // ROS REP 105: the mobile base
constexpr const char* kFloorFrame = "base_footprint";  // its projection on the floor

std::vector<uint8_t> BytesOf(const rosbag::MessageInstance& message) {
  std::vector<uint8_t> bytes(message.size());
  ros::serialization::OStream stream(bytes.data(), static_cast<uint32_t>(bytes.size()));
  message.write(stream);
  return bytes;
}

// An open bag, and those of its messages that are read when they are needed.
struct OpenBag {
  rosbag::Bag bag;
  std::unique_ptr<rosbag::View> view;
  std::deque<rosbag::MessageInstance> images;  // copyable, but not assignable
};

struct BagImage {
  Utime utime;
  size_t index;  // in OpenBag::images
};

class BagFrames : public FrameSource {
 public:
  struct Pair {
    Utime utime;
    size_t left, depth;  // in OpenBag::images
  };
  BagFrames(std::unique_ptr<OpenBag> bag, std::vector<Pair> pairs, std::string name,
            double depth_unit_m)
      : bag_(std::move(bag)),
        pairs_(std::move(pairs)),
        name_(std::move(name)),
        depth_unit_m_(depth_unit_m) {}

  size_t size() const override { return pairs_.size(); }
  Utime utime(size_t index) const override { return pairs_[index].utime; }
  Result<FramePixels> Load(size_t index) const override {
    const auto fail = [&](const std::string& what) {
      return Error{ErrorCode::kBadData, name_ + ": frame " + std::to_string(index) + ": " + what};
    };
    try {
      Result<Image> left = DecodeRosGrey(BytesOf(bag_->images[pairs_[index].left]));
      if (!left) return fail(left.error().message);
      Result<Image> depth =
          DecodeRosDepth(BytesOf(bag_->images[pairs_[index].depth]), depth_unit_m_);
      if (!depth) return fail(depth.error().message);
      if (left->width != depth->width || left->height != depth->height) {
        return fail("image and depth differ in size; is the depth aligned to this camera?");
      }
      FramePixels pixels;
      pixels.left = *std::move(left);
      pixels.depth = *std::move(depth);
      return pixels;
    } catch (const std::exception& e) {
      return fail(std::string("bag is damaged: ") + e.what());
    }
  }

 private:
  std::unique_ptr<OpenBag> bag_;
  std::vector<Pair> pairs_;
  std::string name_;
  double depth_unit_m_;
};

struct Streams {
  std::vector<BagImage> left, depth;
  std::vector<StampedPose> odometry, truth;
  std::set<std::string> odometry_frames;          // child frames that odometry states
  std::map<std::string, int64_t> spoilt;          // by topic: samples that are of no use
  std::map<std::string, std::string> why_spoilt;  // of the first
};

Result<Done> ReadMessage(const rosbag::MessageInstance& message, const RosbagOptions& o,
                         OpenBag& bag, Recording& recording, Streams& streams) {
  const std::string& topic = message.getTopic();
  const auto expect = [&](const char* type) -> Result<Done> {
    if (message.getDataType() == type) return Done{};
    return Error{ErrorCode::kBadData, recording.name + ": topic " + topic + " holds " +
                                          message.getDataType() + ", expected " + type};
  };
  const auto refused = [&](const Error& error) {
    return Error{ErrorCode::kBadData, recording.name + ": topic " + topic + ": " + error.message};
  };
  const auto spoilt = [&](const Error& error) {
    if (++streams.spoilt[topic] == 1) streams.why_spoilt[topic] = error.message;
    return Result<Done>(Done{});
  };
  if (topic == o.left || topic == o.depth) {
    const Result<Done> type = expect("sensor_msgs/Image");
    if (!type) return type;
    const Result<Utime> utime = DecodeRosStamp(BytesOf(message));
    if (!utime) return refused(utime.error());
    (topic == o.left ? streams.left : streams.depth).push_back({*utime, bag.images.size()});
    bag.images.push_back(message);
  } else if (topic == o.imu) {
    const Result<Done> type = expect("sensor_msgs/Imu");
    if (!type) return type;
    const Result<ImuSample> sample = DecodeRosImu(BytesOf(message));
    if (!sample) return spoilt(sample.error());
    recording.imu.push_back(*sample);
  } else if (topic == o.odometry) {
    const Result<Done> type = expect("nav_msgs/Odometry");
    if (!type) return type;
    const Result<RosPose> pose = DecodeRosOdometry(BytesOf(message));
    if (!pose) return spoilt(pose.error());
    streams.odometry.push_back({pose->utime, pose->T});
    streams.odometry_frames.insert(pose->child);
  } else if (topic == o.transforms) {
    const Result<Done> type = expect("tf2_msgs/TFMessage");
    if (!type) return type;
    const Result<std::vector<RosTransform>> transforms = DecodeRosTransforms(BytesOf(message));
    if (!transforms) return refused(transforms.error());
    for (const RosTransform& t : *transforms) {
      if (t.parent != o.truth_parent || t.child != o.truth_child) continue;
      streams.truth.push_back({t.utime, t.T});
    }
  }
  return Done{};
}

Result<Done> PairFrames(std::unique_ptr<OpenBag> bag, Streams& streams, Recording& recording) {
  const auto times = [](const std::vector<BagImage>& images) {
    std::vector<Utime> out;
    for (const BagImage& image : images) out.push_back(image.utime);
    return out;
  };
  Result<Done> ordered = MakeOrdered(streams.left, "images", recording.warnings);
  if (ordered) ordered = MakeOrdered(streams.depth, "depth images", recording.warnings);
  if (!ordered) return ordered;
  std::vector<BagFrames::Pair> pairs;
  for (const auto& [i, j] :
       AssociateNearest(times(streams.left), times(streams.depth), Milliseconds(20))) {
    pairs.push_back({streams.left[i].utime, streams.left[i].index, streams.depth[j].index});
  }
  if (pairs.empty()) {
    return Error{ErrorCode::kBadData,
                 recording.name +
                     ": no image has a depth image within 20 ms; name the topics with "
                     "--left and --depth (rosbag info lists them)"};
  }
  if (pairs.size() < streams.left.size()) {
    recording.warnings.push_back(std::to_string(streams.left.size() - pairs.size()) +
                                 " images have no depth image within 20 ms; left out");
  }
  CameraCalibration& camera = recording.calibration.camera;
  auto frames = std::make_unique<BagFrames>(std::move(bag), std::move(pairs), recording.name,
                                            camera.depth_unit_m);
  const Result<FramePixels> first = frames->Load(0);
  if (!first) return first.error();
  if (first->left.converted) {
    recording.notes.emplace_back("images", std::string("colour, converted: ") + kGreyConversion);
  }
  if (first->depth.converted) {
    recording.notes.emplace_back("images", "depth: 32-bit metres, rounded to the depth unit");
  }
  camera.width = first->left.width;
  camera.height = first->left.height;
  const double rate_hz = MedianRateHz(times(streams.left));
  if (rate_hz > 0) camera.rate_hz = rate_hz;
  recording.frames = std::move(frames);
  return Done{};
}

// Warns of samples that are of no use, and of odometry in a frame that is not the body. Error when
// more than half of a topic is of no use.
Result<Done> JudgeStreams(const RosbagOptions& options, const Streams& streams,
                          Recording& recording) {
  for (const auto& [topic, count] : streams.spoilt) {
    const size_t good = topic == options.imu ? recording.imu.size() : streams.odometry.size();
    const std::string text = "topic " + topic + ": " + std::to_string(count) + " of " +
                             std::to_string(good + static_cast<size_t>(count)) +
                             " messages are of no use (" + streams.why_spoilt.at(topic) + ")";
    if (static_cast<size_t>(count) > good) {
      return Error{ErrorCode::kBadData, recording.name + ": " + text};
    }
    recording.warnings.push_back(text + "; left out");
  }
  for (const std::string& frame : streams.odometry_frames) {
    if (frame.empty() || frame == options.truth_child || frame == kBodyFrame ||
        frame == kFloorFrame)
      continue;
    recording.warnings.push_back("topic " + options.odometry + ": is of the frame " + frame +
                                 "; taken as the body. If the calibration has another body, dead "
                                 "reckoning is wrong");
  }
  return Done{};
}

}  // namespace

bool HasRosbagSupport() {
  return true;
}

Result<Recording> ReadRosbag(const std::filesystem::path& file, const RosbagOptions& options) {
  Recording recording;
  recording.format = "rosbag";
  recording.name = file.filename().string();
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) {
    return Error{ErrorCode::kNotFound, file.string() + ": not there; SRC is the bag file"};
  }
  SE3 T_ItoC;
  if (options.robot_config.empty() == options.cid_sims_calibration.empty()) {
    return Error{ErrorCode::kInvalidArgument,
                 "a bag holds no complete calibration: give either --calibration ROBOT.yaml or "
                 "--cid-sims-calibration FILE with --mount"};
  }
  if (!options.robot_config.empty()) {
    const Result<RobotConfig> config = LoadRobotConfig(options.robot_config.string());
    if (!config) return config.error();
    recording.calibration = config->calibration;
  } else {
    const Result<SE3> read =
        ReadCidSimsCalibration(options.cid_sims_calibration, options.mount, recording);
    if (!read) return read.error();
    T_ItoC = *read;
  }
  if (recording.calibration.camera.kind != CameraKind::kRgbd) {
    return Error{ErrorCode::kBadConfig, options.robot_config.string() +
                                            ": calibration.camera.kind must be rgbd; only RGB-D "
                                            "bags can be imported"};
  }
  Streams streams;
  auto bag = std::make_unique<OpenBag>();
  try {
    bag->bag.open(file.string(), rosbag::bagmode::Read);
    bag->view = std::make_unique<rosbag::View>(bag->bag);
    for (const rosbag::MessageInstance& message : *bag->view) {
      const Result<Done> read = ReadMessage(message, options, *bag, recording, streams);
      if (!read) return read.error();
    }
  } catch (const std::exception& e) {
    return Error{ErrorCode::kBadData, file.string() + ": cannot be read as a bag (" + e.what() +
                                          "); rosbag reindex may repair it"};
  }
  const Result<Done> paired = PairFrames(std::move(bag), streams, recording);
  if (!paired) return paired.error();
  const Result<Done> judged = JudgeStreams(options, streams, recording);
  if (!judged) return judged.error();
  OrderImu(recording.imu, options.imu, recording.warnings);
  Result<Done> ordered = MakeOrdered(streams.odometry, options.odometry, recording.warnings);
  if (ordered) ordered = MakeOrdered(streams.truth, options.transforms, recording.warnings);
  if (!ordered) return ordered.error();
  recording.wheel = WheelIncrements(streams.odometry);
  recording.ground_truth = GroundTruthOfBody(streams.truth, SE3());
  if (streams.truth.empty()) {
    recording.warnings.push_back("no transform from " + options.truth_parent + " to " +
                                 options.truth_child + ": no ground truth in the log");
  }
  if (!options.cid_sims_calibration.empty()) {
    std::vector<StampedPose> T_GC;
    for (const StampedPose& pose : streams.truth) {
      T_GC.push_back({pose.utime, pose.T * recording.calibration.camera.T_BC});
    }
    SetImuPose(T_ItoC, ImuMatrix::kAuto, T_GC, recording);
  }
  return recording;
}

}  // namespace gw::importer
