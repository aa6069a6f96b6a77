#include "backend/core/local_ba.h"

#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>

#include "backend/core/ceres_blocks.h"

namespace gw::backend {
namespace {

// Relative change of the cost at which a pass ends early: far below what a pixel is worth.
constexpr double kFunctionTolerance = 1e-4;

// When fewer than this share of the sightings turned out to be outliers after the first pass, their
// Huber-bounded pull is too small to be worth a second one; they leave the map all the same.
constexpr double kNegligibleOutliers = 0.005;

// Chi-square of a sighting; infinite when the landmark is not in front of the camera.
double ChiSquare(const LocalBaJob& job, const LocalBaJob::Sighting& s, const SE3& T_CW,
                 const Eigen::Vector3d& p_W) {
  const Eigen::Vector3d p_C = T_CW * p_W;
  if (!(p_C.z() > kMinProjectionDepth)) return std::numeric_limits<double>::infinity();
  return ReprojectionResidual(job.camera, s.pixel, p_C).squaredNorm();
}

// The variables of a solve, and the sightings that still count.
struct State {
  std::vector<PoseBlock> poses;
  std::vector<Eigen::Vector3d> points;
  std::vector<bool> used;  // one per sighting
};

// Marks the sightings within their chi-square gate, or with `gate` false only those in front of
// the camera.
void Classify(const LocalBaJob& job, bool gate, State& state) {
  std::vector<SE3> T_CW;
  T_CW.reserve(state.poses.size());
  for (const PoseBlock& pose : state.poses) T_CW.push_back(FromBlock(pose.data()).inverse());
  for (size_t i = 0; i < job.sightings.size(); ++i) {
    const auto& s = job.sightings[i];
    const double chi2 = ChiSquare(job, s, T_CW[s.keyframe], state.points[s.landmark]);
    state.used[i] = gate ? chi2 <= s.pixel.chi2_gate() : std::isfinite(chi2);
  }
}

// One pass over the used sightings. False when the solver failed; the state is then unspecified.
bool SolvePass(const LocalBaJob& job, const ceres::Manifold& manifold, State& state,
               LocalBaResult& result) {
  ceres::HuberLoss huber_mono(std::sqrt(kChi2Mono));
  ceres::HuberLoss huber_stereo(std::sqrt(kChi2Stereo));
  std::deque<ReprojectionCost<2>> mono;  // deques: the costs cannot be moved
  std::deque<ReprojectionCost<3>> stereo;
  std::deque<RelativePoseCost> relative;

  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.disable_all_safety_checks = true;
  ceres::Problem problem(ownership);

  auto* ordering = new ceres::ParameterBlockOrdering;  // the solver's options own it
  for (size_t i = 0; i < state.poses.size(); ++i) {
    double* block = state.poses[i].data();
    problem.AddParameterBlock(block, 7, const_cast<ceres::Manifold*>(&manifold));
    if (job.keyframes[i].fixed) problem.SetParameterBlockConstant(block);
    ordering->AddElementToGroup(block, 1);
  }
  for (size_t i = 0; i < job.sightings.size(); ++i) {
    if (!state.used[i]) continue;
    const auto& s = job.sightings[i];
    double* pose = state.poses[s.keyframe].data();
    double* point = state.points[s.landmark].data();
    if (s.pixel.has_depth) {
      stereo.emplace_back(&job.camera, s.pixel);
      problem.AddResidualBlock(&stereo.back(), &huber_stereo, pose, point);
    } else {
      mono.emplace_back(&job.camera, s.pixel);
      problem.AddResidualBlock(&mono.back(), &huber_mono, pose, point);
    }
    ordering->AddElementToGroup(point, 0);
  }
  for (const auto& edge : job.dr_edges) {
    relative.emplace_back(edge.T_FromTo, edge.sqrt_information);
    problem.AddResidualBlock(&relative.back(), nullptr, state.poses[edge.from].data(),
                             state.poses[edge.to].data());
  }
  if (problem.NumResidualBlocks() == 0) {
    delete ordering;
    return true;
  }

  ceres::Solver::Options options;
  options.linear_solver_ordering.reset(ordering);
  // The reduced camera system of a window is small and nearly full: dense is faster up to some 60
  // keyframes (measured by local_ba_benchmark).
  options.linear_solver_type =
      job.keyframes.size() > 120 ? ceres::SPARSE_SCHUR : ceres::DENSE_SCHUR;
  options.dense_linear_algebra_library_type = ceres::EIGEN;
  options.num_threads = 1;
  options.max_num_iterations = job.iterations;
  options.function_tolerance = kFunctionTolerance;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  result.iterations += static_cast<int>(summary.iterations.size());
  return summary.IsSolutionUsable();
}

// Robust cost of the used sightings and the DR edges.
double Cost(const LocalBaJob& job, const State& state) {
  double cost = 0;
  std::vector<SE3> T_CW;
  for (const PoseBlock& pose : state.poses) T_CW.push_back(FromBlock(pose.data()).inverse());
  for (size_t i = 0; i < job.sightings.size(); ++i) {
    if (!state.used[i]) continue;
    const auto& s = job.sightings[i];
    const double chi2 = ChiSquare(job, s, T_CW[s.keyframe], state.points[s.landmark]);
    const double gate = s.pixel.chi2_gate();
    cost += chi2 <= gate ? chi2 : 2.0 * std::sqrt(chi2 * gate) - gate;
  }
  for (const auto& edge : job.dr_edges) {
    const SE3 T_ab = T_CW[edge.from] * T_CW[edge.to].inverse();
    cost += (edge.sqrt_information * (edge.T_FromTo.inverse() * T_ab).Log()).squaredNorm();
  }
  return 0.5 * cost;
}

}  // namespace

LocalBaResult SolveLocalBa(const LocalBaJob& job) {
  LocalBaResult result;
  result.revision = job.revision;
  result.newest = job.newest;
  State state;
  for (const auto& keyframe : job.keyframes) state.poses.push_back(ToBlock(keyframe.T_WC));
  for (const auto& landmark : job.landmarks) state.points.push_back(landmark.p_W);
  state.used.resize(job.sightings.size());
  const State start = state;

  const PoseManifold manifold;
  Classify(job, /*gate=*/false, state);
  if (!SolvePass(job, manifold, state, result)) return result;
  Classify(job, /*gate=*/true, state);
  const auto outliers = std::count(state.used.begin(), state.used.end(), false);
  if (static_cast<double>(outliers) >
      kNegligibleOutliers * static_cast<double>(state.used.size())) {
    if (!SolvePass(job, manifold, state, result)) return result;
    Classify(job, /*gate=*/true, state);
  }

  result.usable = true;
  for (size_t i = 0; i < job.keyframes.size(); ++i) {
    if (job.keyframes[i].fixed) continue;
    const SE3 T_WC = FromBlock(state.poses[i].data());
    result.usable &= T_WC.IsFinite();
    result.keyframes.push_back({job.keyframes[i].id, T_WC});
  }
  for (size_t i = 0; i < job.landmarks.size(); ++i) {
    result.usable &= state.points[i].allFinite();
    result.landmarks.push_back({job.landmarks[i].id, state.points[i]});
  }
  for (size_t i = 0; i < job.sightings.size(); ++i) {
    const auto& s = job.sightings[i];
    if (state.used[i]) {
      ++result.num_sightings;
    } else {
      result.outliers.push_back({job.landmarks[s.landmark].id, job.keyframes[s.keyframe].id});
    }
  }
  for (const auto& edge : job.dr_edges) {
    result.dr_edges.push_back({job.keyframes[edge.from].id, job.keyframes[edge.to].id, edge.alpha});
  }
  State before = start;
  before.used = state.used;
  result.cost_before = Cost(job, before);
  result.cost_after = Cost(job, state);
  result.usable &= std::isfinite(result.cost_after);
  return result;
}

}  // namespace gw::backend
