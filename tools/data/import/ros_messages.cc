#include "tools/data/import/ros_messages.h"

namespace gw::importer {
namespace {

Error Refused(const std::string& what) {
  return {ErrorCode::kBadData, what};
}

// More than any message here holds: a damaged length must not fill memory.
constexpr uint32_t kMostElements = 10000;

std::vector<double> Reals(RosReader& reader) {
  const auto count = reader.Read<uint32_t>();
  std::vector<double> values;
  for (uint32_t i = 0; i < count && reader.ok() && i < kMostElements; ++i) {
    values.push_back(reader.Read<double>());
  }
  return values;
}

}  // namespace

Result<RosReader::Header> DecodeRosHeader(const RosMessage& message) {
  RosReader reader(message);
  const RosReader::Header header = reader.ReadHeader();
  if (!reader.ok()) return Refused("message is shorter than its header");
  return header;
}

Result<ImuSample> DecodeRosImu(const RosMessage& message) {
  RosReader reader(message);
  ImuSample sample;
  sample.utime = reader.ReadHeader().utime();
  reader.SkipReals(4 + 9);  // orientation and its covariance
  sample.w_I_rad_s = reader.Vector();
  reader.SkipReals(9);
  sample.a_I_m_s2 = reader.Vector();
  reader.SkipReals(9);
  sample.has_accel = true;
  if (!reader.ok()) return Refused("IMU message is shorter than its type");
  if (!sample.w_I_rad_s.allFinite() || !sample.a_I_m_s2.allFinite()) {
    return Refused("IMU message holds a number that is not finite");
  }
  return sample;
}

bool IsPoseType(const std::string& type) {
  return type == "nav_msgs/Odometry" || type == "geometry_msgs/PoseStamped" ||
         type == "geometry_msgs/PoseWithCovarianceStamped" ||
         type == "geometry_msgs/TransformStamped";
}

Result<RosPose> DecodeRosPose(const RosMessage& message, const std::string& type) {
  RosReader reader(message);
  const RosReader::Header header = reader.ReadHeader();
  RosPose pose{header.utime(), header.frame, {}, {}};
  if (type == "nav_msgs/Odometry" || type == "geometry_msgs/TransformStamped") {
    pose.child = reader.Frame();
  }
  pose.T = reader.Pose();
  if (!reader.ok()) return Refused("message of a pose is too short or holds no pose");
  return pose;
}

Result<std::vector<RosPose>> DecodeRosTransforms(const RosMessage& message) {
  RosReader reader(message);
  const auto count = reader.Read<uint32_t>();
  std::vector<RosPose> transforms;
  for (uint32_t i = 0; i < count && reader.ok(); ++i) {
    const RosReader::Header header = reader.ReadHeader();
    const std::string child = reader.Frame();
    const SE3 T = reader.Pose();
    transforms.push_back({header.utime(), header.frame, child, T});
  }
  if (!reader.ok()) return Refused("transform message is too short or holds no pose");
  return transforms;
}

Result<RosCameraInfo> DecodeRosCameraInfo(const RosMessage& message) {
  RosReader reader(message);
  RosCameraInfo info;
  info.frame = reader.ReadHeader().frame;
  info.height = static_cast<int>(reader.Read<uint32_t>() & 0xffffff);
  info.width = static_cast<int>(reader.Read<uint32_t>() & 0xffffff);
  info.model = reader.Text();
  info.D = Reals(reader);
  for (double& value : info.K) value = reader.Read<double>();
  for (double& value : info.R) value = reader.Read<double>();
  for (double& value : info.P) value = reader.Read<double>();
  info.binning_x = static_cast<int>(reader.Read<uint32_t>() & 0xffff);
  info.binning_y = static_cast<int>(reader.Read<uint32_t>() & 0xffff);
  info.offset_x = static_cast<int>(reader.Read<uint32_t>() & 0xffff);
  info.offset_y = static_cast<int>(reader.Read<uint32_t>() & 0xffff);
  if (!reader.ok()) return Refused("CameraInfo message is shorter than its type");
  return info;
}

Result<RosJoints> DecodeRosJoints(const RosMessage& message) {
  RosReader reader(message);
  RosJoints joints;
  joints.utime = reader.ReadHeader().utime();
  const auto count = reader.Read<uint32_t>();
  for (uint32_t i = 0; i < count && reader.ok() && i < kMostElements; ++i) {
    joints.names.push_back(reader.Text());
  }
  joints.positions = Reals(reader);
  if (!reader.ok()) return Refused("JointState message is shorter than its type");
  if (joints.positions.size() != joints.names.size()) joints.positions.clear();
  return joints;
}

Result<RosTicks> DecodeKobukiTicks(const RosMessage& message) {
  RosReader reader(message);
  RosTicks ticks;
  ticks.utime = reader.ReadHeader().utime();
  reader.Read<uint16_t>();  // time stamp of the base, ms, wrapping
  ticks.contact.bumper = reader.Read<uint8_t>() != 0;
  ticks.contact.wheel_drop = reader.Read<uint8_t>() != 0;
  ticks.contact.cliff = reader.Read<uint8_t>() != 0;
  ticks.left = reader.Read<uint16_t>();
  ticks.right = reader.Read<uint16_t>();
  if (!reader.ok()) return Refused("SensorState message is shorter than its type");
  return ticks;
}

}  // namespace gw::importer
