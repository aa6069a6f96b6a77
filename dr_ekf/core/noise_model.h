// Constants of the dead-reckoning model that are neither calibration nor tuning: priors, and what
// is assumed of a wheeled indoor robot while a sensor is missing. Each says where it comes from.
#pragma once

namespace gw::dr_ekf {

inline constexpr double kGravity = 9.80665;  // m/s^2, standard; the accel bias absorbs the rest

// Priors at start (one sigma). Gyro: raw Kobuki and BMI055 offsets are up to about 1 deg/s.
// Accelerometer: consumer parts, after the driver's factory calibration.
inline constexpr double kGyroBiasPrior = 0.02;      // rad/s
inline constexpr double kAccelBiasPrior = 0.1;      // m/s^2
inline constexpr double kForwardSpeedPrior = 0.5;   // m/s, start in motion
inline constexpr double kSidewaysSpeedPrior = 0.1;  // m/s
inline constexpr double kTiltPrior = 0.05;          // rad: 0.5 m/s^2 of motion while levelling
inline constexpr double kLevelingSigma = 0.05;      // m/s^2, unseen motion during levelling

// Track of the base, as a factor on the turn of its wheels: a skid-steer base turns half as far as
// its geometric track says, a wrong calibration is in there too. With a gyro this is the prior, one
// sigma; the first turn tells. Without one the turn of the wheels is all there is.
inline constexpr double kYawScalePrior = 1.0;
inline constexpr double kLeastYawScale = 0.25;
inline constexpr double kMostYawScale = 4.0;
// Diameters of the left and the right wheel differ by this share of one (Borenstein and Feng,
// Measurement and correction of systematic odometry errors in mobile robots, 1996): a turn in
// proportion to the way, which divides it by the track. What nine real bases show, 0.3 deg/m, is
// this at a track of 0.4 m (docs/adr/0061-what-steady-driving-tells.md).
inline constexpr double kUnequalWheels = 0.002;
// An error in proportion to the way is published as one of the turn rate, at the speed of the last
// so many seconds: at the speed of each sample it would look like a new error with each change.
inline constexpr double kUsualSpeedMemory = 5;  // s
// Factors on the variance of the wheels' turn per angle and of the accelerometer's way, before it
// is known what this robot is (see NoiseFactor): two and five times the sigma.
inline constexpr double kTurnNoisePrior = 4;
inline constexpr double kAccelNoisePrior = 25;
// Stamps that are off by more than this share of their period cannot weigh the wheels' scale:
// slowly changing time errors look like one.
inline constexpr double kMostTimeError = 0.25;
// Below this factor the accelerometer agrees with the wheels: twice the sigma it is said to have.
inline constexpr double kAgreeingNoise = 4;
// The wheels' turn can tell of slip where the track is known this well, and is what it is said to
// be: tyres that slide in every turn (skid steer: a factor of two) cannot.
inline constexpr double kKnownTrackSigma = 0.1;
inline constexpr double kOtherTrack = 0.2;
inline constexpr double kTrackDoubt = 0.05;  // of a known one, when gyro and wheels part
// The watchdog compares filter and wheels over this time.
inline constexpr double kWatchMemory = 10;  // s

// An IMU (and with it "up" and "ahead") that is mounted this much askew, about a degree, sees the
// body rise and go sideways by this share of the way.
inline constexpr double kAskewPrior = 0.02;
// How far ahead of the origin of B is the point that rolls straight ahead in a turn, seen from the
// IMU: brackets are off by a centimetre, the middle of a base that cannot steer by some.
inline constexpr double kTurnCentrePrior = 0.03;  // m

// The scales of wheels and gyro drift this slowly (temperature, tyre wear, payload): 0.04 % in an
// hour.
inline constexpr double kScaleWalk = 6e-6;  // 1/sqrt(s)

// Wheels at rest still let the body rock by this much between two samples. Along the way it comes
// back: an error of the sums.
inline constexpr double kWayFloor = 1e-4;  // m
inline constexpr double kYawFloor = 1e-4;  // rad

// Sideways (and vertical) motion is white per way: scrub of the tyres, thresholds. A sideways
// velocity stays for about this long.
inline constexpr double kLateralCorrelation = 0.1;  // s

// A floor. Without an accelerometer the robot is taken to stand flat; with one its height is taken
// to wander no more than such a floor does. How far a floor is from flat: roll and pitch wander
// around zero with this sigma, and forget over this way.
inline constexpr double kFloorTilt = 0.01;    // rad
inline constexpr double kFloorTiltWay = 1.0;  // m
// Height of a floor around its level: twice what DIN 18202 allows over 15 m. More is a ramp.
inline constexpr double kFloorHeight = 0.03;  // m

// Motion that no sensor measures (wheels lost without accelerometer; gyro lost without wheels): a
// velocity that wanders around zero with this sigma and this memory.
inline constexpr double kUnmeasuredSpeed = 0.5;          // m/s
inline constexpr double kUnmeasuredSpeedMemory = 2.0;    // s
inline constexpr double kUnmeasuredYawRate = 0.5;        // rad/s
inline constexpr double kUnmeasuredYawRateMemory = 0.2;  // s
inline constexpr double kUnmeasuredTiltDensity = 4e-4;   // rad^2/s, roll and pitch in a gyro gap
// With an accelerometer and without wheels, integration runs away in a minute. A wheeled robot's
// speed does not: this prior bounds it.
inline constexpr double kSpeedPrior = 1.0;        // m/s
inline constexpr double kLeastSpeed = 0.1;        // m/s, at which it may still slide
inline constexpr double kSpeedPriorMemory = 10.;  // s

// The base's own gyro heading (Kobuki: 0.01 deg steps, scale errors of a few tenths of a percent,
// drivers/kobuki/README.md): white in time, white in angle turned, quantisation.
inline constexpr double kHeadingSigmaPerSqrtS = 5e-4;    // rad/sqrt(s)
inline constexpr double kHeadingSigmaPerSqrtRad = 5e-3;  // rad/sqrt(rad)
inline constexpr double kHeadingStep = 1.75e-4;          // rad
inline constexpr double kHeadingDrift = 2e-4;            // rad/s, constant over seconds

// A parked robot: keeps covariances invertible. 2 mm and 0.1 deg per hour.
inline constexpr double kPoseFloor = 1e-9;  // m^2/s, rad^2/s

// Corrections by updates come in steps; as white noise they are spread over this time.
inline constexpr double kCorrectionMemory = 0.2;  // s
// A parked robot that starts: way and turn that pass before stillness is seen to end.
inline constexpr double kUnnoticedWay = 1e-4;   // m
inline constexpr double kUnnoticedTurn = 5e-4;  // rad

// Slip. While it lasts the wheels' variance is multiplied, and a share of their turn is doubted.
inline constexpr double kSlipVarianceFactor = 25;
inline constexpr double kSlipYawShare = 0.3;
inline constexpr double kSlipHold = 0.5;  // s, the flag outlives the last evidence
// Less disagreement with gyro or accelerometer than this in SlipGate::kMemory is no slip: a bad
// floor along the way; sideways also an IMU that is not quite where the calibration says.
inline constexpr double kLeastSlip = 0.015;     // m
inline constexpr double kLeastSlipTurn = 0.01;  // rad
inline constexpr double kLeastSlide = 0.03;     // m
// Vision that accuses the wheels lowers the limits of the accelerometer's gate to this share.
inline constexpr double kAccusedShare = 0.75;
inline constexpr double kVisionAcquitsAfter = 0.3;  // s of rejection
inline constexpr double kVisionDelay = 0.25;  // s: VisionWitness's window and the way of an image
// An accelerometer that wants wheels of another size, or that roll elsewhere, than the priors allow
// (sigmas), or finds slip this often, is the one that is wrong: filtered, late, not where it is
// said to be.
inline constexpr double kMostPriorSigmas = 2.5;
inline constexpr double kMostSlips = 2.5;
inline constexpr double kSlipsMemory = 20;  // s
// An accelerometer that is found wrong: by how much the speed, and the tilt that gravity leaks by.
inline constexpr double kSpeedSlack = 0.15;  // m/s
inline constexpr double kTiltDoubt = 0.02;   // rad
// After this time the wheels are believed again, unless vision contradicts them, too: the
// accelerometer knows the speed to 0.1 m/s for this long.
inline constexpr double kMaxWayRejection = 3.0;  // s
// A disagreement of gyro and wheels that lasts longer is no slip; what it is shows by its shape.
inline constexpr double kMaxYawRejection = 3.0;  // s
// A gyro's bias may jump by up to this (data sheets: offsets of 5 deg/s); still wheels and a rate
// that is as steady as the noise for this long are a jump, not a turn.
inline constexpr double kMaxBiasJump = 0.15;   // rad/s
inline constexpr double kSteadyRateFor = 1.0;  // s

// Plausibility of samples.
inline constexpr double kMaxGyro = 40.0;    // rad/s: beyond the 2000 deg/s range of MEMS gyros
inline constexpr double kMaxAccel = 200.0;  // m/s^2: beyond the 16 g range of MEMS parts

}  // namespace gw::dr_ekf
