// Where the camera is on the base, and what wheels and gyro are off by, from a drive: vision's own
// trajectory against the raw wheels and gyro, all at once.
//
// Between two images about half a second apart vision tells the motion A of the camera, in metres.
// X A X^-1 with X = T_BC is that of the body, which on a floor is
//   x, y   the arc of the wheels' way (scaled) and turn (scaled), at the wheels' own time,
//   z, roll, pitch   zero,
//   yaw    the wheels' turn (scaled), and the gyro's (scaled, with a bias), each at its own time.
// Least squares over all of these (Ceres), robust against slip; the noise of each kind of residual
// is measured from the residuals themselves, so that the covariance is that of this drive; what
// vision tells wrong all the time, and no drive can show (a factor of its turns and of its ways, a
// direction of its ways that is too high), is a parameter with a prior.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/camera/calibration.h"
#include "common/contract/samples.h"
#include "common/core/result.h"

namespace gw::calibrate {

struct CameraPose {
  Utime utime;
  SE3 T_WC;
  bool seen = false;  // by vision
};

// What is estimated, each with its standard deviation.
struct Quantity {
  std::string name, unit;
  double value = 0;    // in unit; of rotation and place: the correction to what was given
  double sigma = 0;    // infinite: this drive does not tell it
  double wanted = 0;   // accuracy that it should be known to, in unit
  std::string remedy;  // the motion that tells it
  // Known well enough to be used in place of what was given.
  bool determined() const { return sigma <= 3 * wanted; }
  // Nine of ten such values are as near to the truth as is wanted (1.645 sigma of a normal one).
  bool exact() const { return 1.645 * sigma <= wanted; }
};

// Order of DriveCalibration::quantities.
enum QuantityIndex {
  kRoll,
  kPitch,
  kYaw,  // deg, of T_BC, about the body's axes, on the left
  kX,
  kY,  // m, of T_BC
  kWheelWay,
  kWheelTurn,
  kGyroTurn,  // true over measured motion
  kWheelDelay,
  kGyroDelay,  // s, as calibration.*.time_offset_s
  kNumQuantities
};

struct DriveCalibration {
  std::array<Quantity, kNumQuantities> quantities;
  SE3 T_BC;                        // as estimated; what is undetermined stays as it was given
  int steps = 0;                   // of half a second that were used
  double way_m = 0, turn_rad = 0;  // of the body in them, whichever way
  // Standard deviation of one step's residuals: x, y, z in m, roll, pitch, yaw by wheels, yaw by
  // gyro in rad.
  std::array<double, 7> noise{};
};

// What the robot did too little of for a calibration, and what to drive; empty when it did both.
std::string MissingMotion(const DriveCalibration& found);

// Height of the camera above the floor is not told by driving on it and stays as given. Error:
// kBadData when vision tells too little or wheels or gyro have too little in common with it, and
// which of them it is.
Result<DriveCalibration> CalibrateDrive(const std::vector<CameraPose>& vision,
                                        const std::vector<WheelSample>& wheels,
                                        const std::vector<ImuSample>& imu,
                                        const Calibration& given);

// The calibration with what was determined.
Calibration Corrected(const Calibration& given, const DriveCalibration& found);

}  // namespace gw::calibrate
