#include "tools/robot/calibrate/refine_stereo.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "common/camera/camera_model.h"
#include "common/core/format.h"

namespace gw::tools {
namespace {

// Change of the right eye: rotation (rad), relative focal length, principal point (px).
constexpr int kNumShared = 6;
using Shared = std::array<double, kNumShared>;
// Nothing is known better than this; keeps what a recording cannot tell where it was.
constexpr Shared kPriorSigma = {0.02, 0.02, 0.02, 0.02, 20.0, 20.0};

constexpr int kResidualsPerTrack = 6;
constexpr size_t kMinTracks = 500;
constexpr size_t kMaxPairs = 60;
constexpr double kLossPx = 0.5;
constexpr std::array<double, 2> kOutlierPx = {4.0, 1.5};  // after the first and the second round

CameraCalibration Apply(const CameraCalibration& given, const double* shared) {
  CameraCalibration c = given;
  const Eigen::Vector3d w(shared[0], shared[1], shared[2]);
  c.T_C0C1 = SE3(given.T_C0C1.rotation() * ExpSO3(w), given.T_C0C1.translation());
  c.right.fx *= 1.0 + shared[3];
  c.right.fy *= 1.0 + shared[3];
  c.right.cx += shared[4];
  c.right.cy += shared[5];
  return c;
}

// Pixel of a point that may be infinitely far away (only its direction counts).
Eigen::Vector2d Project(const PinholeIntrinsics& eye, const Eigen::Vector3d& p) {
  const Eigen::Vector2d n = Distort(eye, {p.x() / p.z(), p.y() / p.z()});
  return {eye.fx * n.x() + eye.cx, eye.fy * n.y() + eye.cy};
}

struct Track {
  StereoTrack pixels;
  Eigen::Vector3d ray;       // left0, z = 1
  double inverse_depth = 0;  // along the ray, 1/m
  size_t pair = 0;
  bool used = true;
};

// Blocks: shared, motion of the pair (rotation vector and translation of left0 in left1), inverse
// depth. Residuals: right0, left1, right1 (px).
struct TrackCost {
  const CameraCalibration* given;
  const Track* track;

  bool operator()(const double* shared, const double* motion, const double* inverse_depth,
                  double* residuals) const {
    const CameraCalibration camera = Apply(*given, shared);
    const SE3 T_RightLeft = camera.T_C0C1.inverse();
    const Eigen::Vector3d& ray = track->ray;
    const double rho = *inverse_depth;
    const Eigen::Vector3d right0 = T_RightLeft.rotation() * ray + T_RightLeft.translation() * rho;
    const Eigen::Vector3d left1 = ExpSO3({motion[0], motion[1], motion[2]}) * ray +
                                  Eigen::Vector3d(motion[3], motion[4], motion[5]) * rho;
    const Eigen::Vector3d right1 = T_RightLeft.rotation() * left1 + T_RightLeft.translation() * rho;
    if (right0.z() < 0.05 || left1.z() < 0.05 || right1.z() < 0.05) return false;
    Eigen::Map<Eigen::Matrix<double, kResidualsPerTrack, 1>> r(residuals);
    r << Project(camera.right, right0) - track->pixels.right0,
        Project(camera.left, left1) - track->pixels.left1,
        Project(camera.right, right1) - track->pixels.right1;
    return true;
  }
};

struct PriorCost {
  bool operator()(const double* shared, double* residuals) const {
    for (int i = 0; i < kNumShared; ++i)
      residuals[i] = shared[i] / kPriorSigma[static_cast<size_t>(i)];
    return true;
  }
};

// The estimate: the tracks, the motions, the shared change.
class Adjustment {
 public:
  Adjustment(const CameraCalibration& given, const std::vector<PairTracks>& pairs)
      : given_(given), motions_(pairs.size(), Motion{}) {
    const SE3 T_RightLeft = given.T_C0C1.inverse();
    for (size_t i = 0; i < pairs.size(); ++i) {
      for (const StereoTrack& pixels : pairs[i]) {
        const auto n = Undistort(given.left, {(pixels.left0.x() - given.left.cx) / given.left.fx,
                                              (pixels.left0.y() - given.left.cy) / given.left.fy});
        if (!n) continue;
        Track track{pixels, {n->x(), n->y(), 1.0}, 0, i, true};
        // First guess from the disparity, at least half a pixel of it.
        const double u_infinity = Project(given.right, T_RightLeft.rotation() * track.ray).x();
        const double disparity = std::max(0.5, u_infinity - pixels.right0.x());
        track.inverse_depth = disparity / (given.right.fx * given.T_C0C1.translation().norm());
        tracks_.push_back(track);
      }
    }
  }

  size_t num_used() const {
    return static_cast<size_t>(
        std::count_if(tracks_.begin(), tracks_.end(), [](const Track& t) { return t.used; }));
  }
  const double* shared() const { return shared_.data(); }

  // Back to the given calibration; the tracks that are used stay.
  void Reset() { shared_ = {}; }

  // False: no solution. `refine` false holds the calibration.
  bool Solve(bool refine) {
    ceres::Problem problem;
    Build(&problem);
    if (!refine) problem.SetParameterBlockConstant(shared_.data());
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_SCHUR;
    options.max_num_iterations = 50;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    return summary.IsSolutionUsable();
  }

  void DropOutliers(double limit_px) {
    for (Track& track : tracks_) track.used = track.used && Norm(track) < limit_px;
  }

  // Root mean square of the residuals, per coordinate.
  double Rms() const {
    double sum = 0;
    for (const Track& track : tracks_) {
      if (track.used) sum += Norm(track) * Norm(track);
    }
    return std::sqrt(sum / (kResidualsPerTrack * static_cast<double>(num_used())));
  }

  // Covariance of the shared change, for residuals of 1 px. Empty matrix: singular.
  Eigen::MatrixXd SharedCovariance() {
    ceres::Problem problem;
    Build(&problem);
    ceres::Covariance covariance{ceres::Covariance::Options{}};
    const std::vector<const double*> wanted = {shared_.data()};
    if (!covariance.Compute(wanted, &problem)) return {};
    Eigen::Matrix<double, kNumShared, kNumShared, Eigen::RowMajor> result;
    covariance.GetCovarianceBlock(shared_.data(), shared_.data(), result.data());
    return result;
  }

 private:
  using Motion = std::array<double, 6>;

  double Norm(const Track& track) const {
    std::array<double, kResidualsPerTrack> r;
    const TrackCost cost{&given_, &track};
    if (!cost(shared_.data(), motions_[track.pair].data(), &track.inverse_depth, r.data())) {
      return 1e9;
    }
    return Eigen::Map<const Eigen::Matrix<double, kResidualsPerTrack, 1>>(r.data()).norm();
  }

  void Build(ceres::Problem* problem) {
    using Cost = ceres::NumericDiffCostFunction<TrackCost, ceres::CENTRAL, kResidualsPerTrack,
                                                kNumShared, 6, 1>;
    using Prior = ceres::NumericDiffCostFunction<PriorCost, ceres::CENTRAL, kNumShared, kNumShared>;
    for (Track& track : tracks_) {
      if (!track.used) continue;
      problem->AddResidualBlock(new Cost(new TrackCost{&given_, &track}),
                                new ceres::CauchyLoss(kLossPx), shared_.data(),
                                motions_[track.pair].data(), &track.inverse_depth);
    }
    problem->AddResidualBlock(new Prior(new PriorCost), nullptr, shared_.data());
  }

  CameraCalibration given_;
  std::vector<Track> tracks_;
  std::vector<Motion> motions_;
  Shared shared_{};
};

// Where the right eye sees the point at infinity that the left eye sees at `left`.
double RightColumn(const CameraCalibration& camera, const Eigen::Vector3d& ray) {
  return Project(camera.right, camera.T_C0C1.rotation().conjugate() * ray).x();
}

double Shift(const CameraCalibration& given, const double* shared, double column) {
  const Eigen::Vector3d ray((column - given.left.cx) / given.left.fx, 0, 1);
  return RightColumn(Apply(given, shared), ray) - RightColumn(given, ray);
}

double SigmaShift(const CameraCalibration& given, const double* shared, double column,
                  const Eigen::MatrixXd& covariance) {
  Eigen::Matrix<double, kNumShared, 1> gradient;
  for (int i = 0; i < kNumShared; ++i) {
    constexpr double kStep = 1e-6;
    Shared moved;
    std::copy_n(shared, kNumShared, moved.begin());
    moved[static_cast<size_t>(i)] += kStep;
    gradient[i] = (Shift(given, moved.data(), column) - Shift(given, shared, column)) / kStep;
  }
  return std::sqrt(gradient.dot(covariance * gradient));
}

std::vector<PairTracks> Thin(const std::vector<PairTracks>& pairs) {
  if (pairs.size() <= kMaxPairs) return pairs;
  std::vector<PairTracks> some;
  for (size_t i = 0; i < kMaxPairs; ++i) some.push_back(pairs[i * pairs.size() / kMaxPairs]);
  return some;
}

Error NotEnough(const std::string& what) {
  return {ErrorCode::kBadData, what + "; record a drive past textured things at several distances"};
}

}  // namespace

Result<StereoRefinement> RefineStereo(const CameraCalibration& given,
                                      const std::vector<PairTracks>& pairs) {
  if (given.kind != CameraKind::kStereo) {
    return Error{ErrorCode::kBadConfig,
                 "calibration.camera.kind: only a stereo camera has a right eye"};
  }
  const std::vector<PairTracks> used_pairs = Thin(pairs);
  Adjustment adjustment(given, used_pairs);
  if (adjustment.num_used() < kMinTracks) {
    return NotEnough("only " + std::to_string(adjustment.num_used()) + " tracks, needed are " +
                     std::to_string(kMinTracks));
  }
  for (const double limit_px : kOutlierPx) {
    if (!adjustment.Solve(true)) return NotEnough("the adjustment finds no solution");
    adjustment.DropOutliers(limit_px);
    if (adjustment.num_used() < kMinTracks) return NotEnough("too few tracks fit together");
  }
  if (!adjustment.Solve(true)) return NotEnough("the adjustment finds no solution");

  StereoRefinement result;
  const double* shared = adjustment.shared();
  result.camera = Apply(given, shared);
  result.rms_after_px = adjustment.Rms();
  result.num_pairs = static_cast<int>(used_pairs.size());
  result.num_tracks = static_cast<int>(adjustment.num_used());
  result.shift_left_px = Shift(given, shared, 0);
  result.shift_centre_px = Shift(given, shared, 0.5 * given.width);
  result.shift_right_px = Shift(given, shared, given.width);
  const Eigen::MatrixXd covariance = adjustment.SharedCovariance();
  if (covariance.size() == 0) return NotEnough("the recording does not determine the calibration");
  result.sigma_shift_px =
      result.rms_after_px * SigmaShift(given, shared, 0.5 * given.width, covariance);
  if (!(result.sigma_shift_px <= kMaxSigmaShiftPx)) {
    return NotEnough("the disparity stays uncertain by " + FormatFixed(result.sigma_shift_px, 2) +
                     " px");
  }
  Adjustment before = adjustment;
  before.Reset();
  if (!before.Solve(false)) return NotEnough("the adjustment finds no solution");
  result.rms_before_px = before.Rms();
  return result;
}

}  // namespace gw::tools
