// Real and independently simulated recordings of wheels and IMU for the tests of this folder: text
// readers and the folder they are in. All of them are optional: a test whose folder is absent
// skips.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/camera/calibration.h"
#include "common/contract/samples.h"
#include "common/core/se3.h"
#include "common/core/time.h"
#include "dr_ekf/test/robot_sim.h"

namespace gw::dr_ekf {

struct StampedPose {
  Utime utime;
  SE3 T;
};

// Wheels, and where there is one the IMU, of one drive, in the order of their times.
struct RealDrive {
  Calibration calibration;
  std::vector<Sample> samples;
  std::vector<StampedPose> raw;    // the wheels' own sum
  std::vector<StampedPose> truth;  // pose of the body; empty: not known
};

// $GW_SHARED_DIR/data/<name>, else ../shared/data/<name> beside the sources; empty when absent.
std::optional<std::filesystem::path> FindRecording(const std::string& name);

// Lines `t px py pz qx qy qz qw ...`, seconds and metres; other lines are comments.
std::vector<StampedPose> ReadPoses(const std::filesystem::path& file);

// Motion from each pose to the next one, in the body at the begin, planar part.
std::vector<WheelSample> WheelsFromPoses(const std::vector<StampedPose>& poses);
// Sum of the samples, from the origin; poses before and after each sample.
std::vector<StampedPose> SumOf(const std::vector<WheelSample>& wheels);

// A folder of poses alone: odometry and reference by their file names.
RealDrive ReadOdometryAlone(const std::filesystem::path& folder, const std::string& odometry,
                            const std::string& reference);

enum class RenderedWheels {
  kOdometry,  // odom.txt: 20 Hz, made from 50 Hz encoder readings
  kEncoder,   // encoder.txt: the 50 Hz readings themselves
};
// The layout of OpenLORIS-Scene: gyro, accelerometer, odometry, trans_matrix.yaml.
RealDrive ReadRendered(const std::filesystem::path& folder, RenderedWheels wheels);

// Four-wheeled skid-steer robot, encoders.csv and imu.csv.
struct SkidSteerOptions {
  double track_m = 0.393;            // the geometric one, as its maker states it
  double accel_unit_m_s2 = 9.80665;  // of the recorded accelerations: they are in g
  bool accelerometer = true;
};
RealDrive ReadSkidSteer(const std::filesystem::path& folder, const SkidSteerOptions& options);

}  // namespace gw::dr_ekf
