// The checks of a recording, by what they look at. Each gives what it finds; nothing is found
// where a sensor is absent or moves too little to tell.
#pragma once

#include "common/config/robot_config.h"
#include "tools/lab/check/finding.h"
#include "tools/lab/check/log_facts.h"
#include "tools/lab/check/motion_sources.h"
#include "tools/lab/check/vision_motion.h"

namespace gw::check {

// Presence, rates, gaps, order and clocks of the streams; damage of the file.
Findings CheckStreams(const LogFacts& facts, const RobotConfig& config);

// Exposure, sharpness, frozen and static images, the two eyes, depth. motion: tells when the robot
// turned.
Findings CheckImages(const LogFacts& facts, const RobotConfig& config, const MotionSources& motion);

// Units and gravity of the IMU.
Findings CheckInertial(const LogFacts& facts, const RobotConfig& config);

// Gyro, wheels and vision against each other: signs, axes, scales, delays, the camera's mounting.
Findings CheckMotion(const MotionSources& motion, const RobotConfig& config);

// Where vision was blind. vision: of the whole recording.
Findings CheckBlindness(const VisionRun& vision);

}  // namespace gw::check
