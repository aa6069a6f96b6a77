#include "tools/data/import/ros_topics.h"

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <utility>

#include "tools/data/files/format.h"
#include "tools/data/import/ros_images.h"
#include "tools/data/import/ros_messages.h"
#include "tools/data/import/ros_wheels.h"

namespace gw::importer {
namespace {

using Index = uint32_t;

constexpr const char* kNone = "none";

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

bool IsTicksType(const std::string& type) {
  return type == "kobuki_msgs/SensorState" || type == "kobuki_ros_interfaces/SensorState";
}

// What the first message of a topic says.
struct Facts {
  std::string frame, encoding;
  bool has_wheels = false;                 // of a JointState
  bool has_gyro = true, has_accel = true;  // of an Imu: not all zero
};

Facts FactsOf(const RosMessage& message, const std::string& type) {
  Facts facts;
  if (const auto header = DecodeRosHeader(message)) facts.frame = header->frame;
  if (IsImageType(type)) {
    if (const auto encoding = DecodeRosEncoding(message, type)) facts.encoding = *encoding;
  } else if (type == "sensor_msgs/JointState") {
    const auto joints = DecodeRosJoints(message);
    facts.has_wheels = joints && FindWheelJoints(*joints).has_value();
  } else if (type == "sensor_msgs/Imu") {
    if (const auto imu = DecodeRosImu(message)) {
      facts.has_gyro = !imu->w_I_rad_s.isZero(0);
      facts.has_accel = !imu->a_I_m_s2.isZero(0);
    }
  }
  return facts;
}

class Chooser {
 public:
  Chooser(bag::Bag& bag, const TopicWishes& wishes) : bag_(bag), wishes_(wishes) { Peek(); }

  Result<RosTopics> Choose() {
    for (const auto& choose : {&Chooser::ChooseCamera, &Chooser::ChooseOdometry,
                               &Chooser::ChooseImu, &Chooser::ChooseTruth}) {
      const Result<Done> done = (this->*choose)();
      if (!done) return done.error();
    }
    return chosen_;
  }

 private:
  // A gyro may rest at exactly zero in its first message; ten are looked at.
  void Peek() {
    std::map<Index, int> seen;
    facts_.resize(bag_.topics().size());
    for (const bag::MessageRef& ref : bag_.messages()) {
      const bag::Topic& topic = bag_.topics()[ref.topic];
      const int before = seen[ref.topic]++;
      if (before >= (topic.type == "sensor_msgs/Imu" ? 10 : 1)) continue;
      const Result<bag::Bytes> bytes = bag_.Read(ref);
      if (!bytes) continue;
      const Facts facts = FactsOf({*bytes, topic.serialization}, topic.type);
      if (before == 0) {
        facts_[ref.topic] = facts;
      } else {
        facts_[ref.topic].has_gyro |= facts.has_gyro;
        facts_[ref.topic].has_accel |= facts.has_accel;
      }
    }
  }

  const bag::Topic& topic(Index i) const { return bag_.topics()[i]; }

  std::vector<Index> All(const std::function<bool(const bag::Topic&)>& wanted) const {
    std::vector<Index> found;
    for (Index i = 0; i < bag_.topics().size(); ++i) {
      if (topic(i).messages > 0 && wanted(topic(i))) found.push_back(i);
    }
    return found;
  }

  std::string Names(const std::vector<Index>& topics) const {
    std::string names;
    for (const Index i : topics) names += (names.empty() ? "" : ", ") + topic(i).name;
    return names.empty() ? "none" : names;
  }

  // The topic of this name, and of a type that is wanted.
  Result<Index> Named(const std::string& name, const char* option,
                      const std::function<bool(const bag::Topic&)>& wanted,
                      const std::string& what) const {
    for (Index i = 0; i < bag_.topics().size(); ++i) {
      if (topic(i).name != name && topic(i).name != "/" + name) continue;
      if (!wanted(topic(i))) {
        return Error{ErrorCode::kBadData, "topic " + topic(i).name + " (" + option + ") holds " +
                                              topic(i).type + ", expected " + what};
      }
      if (topic(i).messages == 0) {
        return Error{ErrorCode::kBadData,
                     "topic " + topic(i).name + " (" + option + ") has no message"};
      }
      return i;
    }
    return Error{ErrorCode::kBadData, "topic " + name + " (" + option +
                                          ") is not in the bag; those of its type are: " +
                                          Names(All(wanted)) + " (--list shows all)"};
  }

  void Say(const std::string& what, Index i, const std::vector<Index>& others = {}) {
    std::string line = what + ": " + topic(i).name + " (" + topic(i).type + ")";
    std::vector<Index> rest;
    for (const Index other : others) {
      if (other != i) rest.push_back(other);
    }
    if (!rest.empty()) line += "; also there: " + Names(rest);
    chosen_.choices.push_back(line);
  }

  static bool IsImage(const bag::Topic& topic) { return IsImageType(topic.type); }

  bool IsDepth(Index i) const {
    return IsDepthEncoding(facts_[i].encoding) ||
           (facts_[i].encoding == "mono16" && Contains(topic(i).name, "depth"));
  }

  // The depth image that belongs to a grey one, pixel by pixel: stamped with the same frame.
  std::optional<Index> DepthOf(Index grey, const std::vector<Index>& images) const {
    std::optional<Index> best;
    for (const Index i : images) {
      if (!IsDepth(i) || facts_[i].frame != facts_[grey].frame) continue;
      if (!best || Contains(topic(i).name, "aligned")) best = i;
    }
    return best;
  }

  std::optional<Index> RightOf(Index left, const std::vector<Index>& images) const {
    constexpr std::array<std::pair<const char*, const char*>, 5> kEyes = {{{"left", "right"},
                                                                           {"infra1", "infra2"},
                                                                           {"cam0", "cam1"},
                                                                           {"Left", "Right"},
                                                                           {"camera0", "camera1"}}};
    for (const auto& [l, r] : kEyes) {
      std::string name = topic(left).name;
      size_t at = name.find(l);
      if (at == std::string::npos) continue;
      for (; at != std::string::npos; at = name.find(l, at + std::string(r).size())) {
        name.replace(at, std::string(l).size(), r);
      }
      for (const Index i : images) {
        if (topic(i).name == name) return i;
      }
    }
    return std::nullopt;
  }

  std::optional<Index> InfoOf(Index image) const {
    std::string name = topic(image).name;
    for (int level = 0; level < 3; ++level) {
      name = name.substr(0, name.rfind('/'));
      for (Index i = 0; i < bag_.topics().size(); ++i) {
        if (topic(i).type == "sensor_msgs/CameraInfo" && topic(i).messages > 0 &&
            topic(i).name == name + "/camera_info") {
          return i;
        }
      }
      if (name.empty()) break;
    }
    return std::nullopt;
  }

  Result<std::pair<Index, Index>> NamedPair(const std::string& names, const char* option) const {
    const size_t comma = names.find(',');
    if (comma == std::string::npos) {
      return Error{ErrorCode::kInvalidArgument,
                   std::string(option) + ": two topics with a comma between are needed, not '" +
                       names + "'"};
    }
    const std::string what = "sensor_msgs/Image or sensor_msgs/CompressedImage";
    const Result<Index> first = Named(names.substr(0, comma), option, IsImage, what);
    if (!first) return first.error();
    const Result<Index> second = Named(names.substr(comma + 1), option, IsImage, what);
    if (!second) return second.error();
    return std::pair{*first, *second};
  }

  void TakeStereo(Index left, Index right) {
    chosen_.left = left;
    chosen_.right = right;
    chosen_.right_info = InfoOf(right);
    Say("left eye", left);
    Say("right eye", right);
  }
  void TakeRgbd(Index image, Index depth) {
    chosen_.left = image;
    chosen_.depth = depth;
    Say("image", image);
    Say("depth", depth);
  }

  // What is there is told by name: raw images before compressed ones, which lose something.
  void FindCamera() {
    std::vector<Index> images = All(IsImage);
    std::stable_sort(images.begin(), images.end(), [&](Index a, Index b) {
      return std::pair(topic(a).type, topic(b).messages) >
             std::pair(topic(b).type, topic(a).messages);
    });
    std::optional<std::pair<Index, Index>> rgbd, stereo;
    for (const Index i : images) {
      if (IsDepth(i)) continue;
      const auto depth = DepthOf(i, images);
      if (!rgbd && depth) rgbd = {i, *depth};
      const auto right = RightOf(i, images);
      if (!stereo && right && !IsDepth(*right)) stereo = {i, *right};
    }
    if (stereo && wishes_.kind == CameraKind::kStereo) rgbd.reset();
    if (rgbd) {
      TakeRgbd(rgbd->first, rgbd->second);
      if (stereo) {
        chosen_.choices.push_back("a stereo pair is there too: --stereo " +
                                  topic(stereo->first).name + "," + topic(stereo->second).name);
      }
    } else if (stereo) {
      TakeStereo(stereo->first, stereo->second);
    } else if (!images.empty()) {
      chosen_.choices.push_back(
          "no images: no two topics are a stereo pair or an image with the depth of its frame; "
          "--stereo L,R or --rgbd I,D choose among: " +
          Names(images));
    }
  }

  Result<Done> ChooseCamera() {
    if (!wishes_.stereo.empty() && wishes_.stereo != kNone) {
      const auto pair = NamedPair(wishes_.stereo, "--stereo");
      if (!pair) return pair.error();
      TakeStereo(pair->first, pair->second);
    } else if (!wishes_.rgbd.empty() && wishes_.rgbd != kNone) {
      const auto pair = NamedPair(wishes_.rgbd, "--rgbd");
      if (!pair) return pair.error();
      TakeRgbd(pair->first, pair->second);
    } else if (wishes_.stereo.empty() && wishes_.rgbd.empty()) {
      FindCamera();
    }
    if (chosen_.left) chosen_.left_info = InfoOf(*chosen_.left);
    return Done{};
  }

  bool IsWheels(Index i) const {
    return topic(i).type == "nav_msgs/Odometry" || IsTicksType(topic(i).type) ||
           (topic(i).type == "sensor_msgs/JointState" && facts_[i].has_wheels);
  }

  // Smaller is better: the wheels' own before what a filter or a camera made.
  int OdometryRank(Index i) const {
    const std::string& name = topic(i).name;
    for (const char* other : {"truth", "gt", "filtered", "visual", "vio", "rtabmap", "slam", "t265",
                              "icp", "laser", "amcl", "camera"}) {
      if (Contains(name, other)) return 4;
    }
    if (topic(i).type != "nav_msgs/Odometry") return IsTicksType(topic(i).type) ? 2 : 3;
    return Contains(name, "wheel") ? 0 : 1;
  }

  Result<Done> ChooseOdometry() {
    if (wishes_.odometry == kNone) return Done{};
    if (!wishes_.odometry.empty()) {
      const Result<Index> named = Named(
          wishes_.odometry, "--odom",
          [&](const bag::Topic& t) { return IsWheels(static_cast<Index>(&t - &topic(0))); },
          "nav_msgs/Odometry, sensor_msgs/JointState with a left and a right wheel, or "
          "kobuki_msgs/SensorState");
      if (!named) return named.error();
      chosen_.odometry = *named;
      Say("odometry", *named);
      return Done{};
    }
    std::vector<Index> found =
        All([&](const bag::Topic& t) { return IsWheels(static_cast<Index>(&t - &topic(0))); });
    std::stable_sort(found.begin(), found.end(),
                     [&](Index a, Index b) { return OdometryRank(a) < OdometryRank(b); });
    if (found.empty()) return Done{};
    if (OdometryRank(found.front()) == 4) {
      chosen_.choices.push_back("no odometry: " + Names(found) +
                                " seem to be no wheels' own; --odom takes one");
      return Done{};
    }
    chosen_.odometry = found.front();
    Say("odometry", found.front(), found);
    return Done{};
  }

  static bool IsImu(const bag::Topic& topic) { return topic.type == "sensor_msgs/Imu"; }

  Result<Done> ChooseImu() {
    if (wishes_.imu == kNone) return Done{};
    if (!wishes_.imu.empty()) {
      const size_t comma = wishes_.imu.find(',');
      const Result<Index> gyro =
          Named(wishes_.imu.substr(0, comma), "--imu", IsImu, "sensor_msgs/Imu");
      if (!gyro) return gyro.error();
      chosen_.imu = *gyro;
      Say("IMU", *gyro);
      if (comma == std::string::npos) return Done{};
      const Result<Index> accel =
          Named(wishes_.imu.substr(comma + 1), "--imu", IsImu, "sensor_msgs/Imu");
      if (!accel) return accel.error();
      chosen_.accel = *accel;
      Say("accelerometer", *accel);
      return Done{};
    }
    std::vector<Index> gyros, accels;
    for (const Index i : All(IsImu)) {
      if (facts_[i].has_gyro) gyros.push_back(i);
      if (facts_[i].has_accel && !facts_[i].has_gyro) accels.push_back(i);
    }
    if (gyros.empty()) return Done{};
    // One with an accelerometer before one without, then the fastest.
    std::stable_sort(gyros.begin(), gyros.end(), [&](Index a, Index b) {
      return std::pair(facts_[a].has_accel, topic(a).messages) >
             std::pair(facts_[b].has_accel, topic(b).messages);
    });
    chosen_.imu = gyros.front();
    Say("IMU", gyros.front(), gyros);
    if (!facts_[gyros.front()].has_accel && !accels.empty()) {
      chosen_.accel = accels.front();
      Say("accelerometer", accels.front(), accels);
    }
    return Done{};
  }

  Result<Done> ChooseTruth() {
    if (wishes_.truth == kNone) return Done{};
    const auto is_pose = [](const bag::Topic& t) { return IsPoseType(t.type); };
    if (!wishes_.truth.empty()) {
      const Result<Index> named = Named(wishes_.truth, "--truth", is_pose,
                                        "nav_msgs/Odometry or a stamped pose of geometry_msgs");
      if (!named) return named.error();
      chosen_.truth = *named;
      Say("ground truth", *named);
      return Done{};
    }
    for (const Index i : All(is_pose)) {
      if (i == chosen_.odometry) continue;
      for (const char* part : {"truth", "mocap", "vicon", "vrpn", "optitrack", "/gt"}) {
        if (!Contains(topic(i).name, part)) continue;
        chosen_.truth = i;
        Say("ground truth", i);
        return Done{};
      }
    }
    return Done{};
  }

  bag::Bag& bag_;
  const TopicWishes& wishes_;
  std::vector<Facts> facts_;
  RosTopics chosen_;
};

}  // namespace

Result<RosTopics> ChooseTopics(bag::Bag& bag, const TopicWishes& wishes) {
  return Chooser(bag, wishes).Choose();
}

std::string ListTopics(const bag::Bag& bag) {
  size_t widest = 0;
  for (const bag::Topic& topic : bag.topics()) widest = std::max(widest, topic.name.size());
  std::string text;
  for (const bag::Topic& topic : bag.topics()) {
    const double span_s = static_cast<double>(topic.last_ns - topic.first_ns) * 1e-9;
    const double rate = span_s > 0 ? static_cast<double>(topic.messages - 1) / span_s : 0.0;
    text += tools::Format("  %-*s %-36s %8d messages %8.1f Hz%s\n", static_cast<int>(widest),
                          topic.name, topic.type, topic.messages, rate,
                          topic.serialization == bag::Serialization::kOther
                              ? " (a serialisation that is not known)"
                              : "");
  }
  return text;
}

}  // namespace gw::importer
