#include "backend/core/bundle/local_ba.h"

#include <ceres/iteration_callback.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>
#include <utility>

#include "backend/core/bundle/ceres_blocks.h"
#include "backend/core/bundle/landmark_fit.h"
#include "backend/core/bundle/window_solver.h"
#include "common/core/robust_loss.h"
#include "common/good_weights/edge_covariance.h"

namespace gw::backend {
namespace {

// When fewer than this share of the observations turned out to be outliers after the first pass,
// their Huber-bounded pull is too small to be worth a second one; they leave the map all the same.
constexpr double kNegligibleOutliers = 0.005;

// Limit of vagueness in a job whose landmarks settle first. A landmark with a larger share of its
// distance as standard deviation sits out: a step of three sigmas takes it behind a camera, and the
// solver, which has one step length for all, then shortens that of the whole map a thousandfold.
constexpr double kTooVague = 1.0 / 3;
// Where every landmark sits in its own minimum, whole Gauss-Newton steps are good; shorter ones
// hold back the soft bends of the map, which are all that is left to mend.
constexpr double kWholeSteps = 1e8;  // trust region radius

// What counts of an observation.
enum class Use : uint8_t { kNothing, kPixel, kPixelAndDepth };

// The variables of a solve, and what of each observation still counts.
struct State {
  std::vector<PoseBlock> poses;
  std::vector<Eigen::Vector3d> points;
  Eigen::Vector2d dr_scale_error = Eigen::Vector2d::Zero();
  std::vector<Use> use;  // one per observation
};

std::vector<SE3> InversePoses(const State& state) {
  std::vector<SE3> T_CW;
  T_CW.reserve(state.poses.size());
  for (const PoseBlock& pose : state.poses) T_CW.push_back(FromBlock(pose.data()).inverse());
  return T_CW;
}

// Keeps what is within its chi-square gate, or with `gate` false everything that is in front of its
// camera.
void Classify(const LocalBaJob& job, bool gate, State& state) {
  const std::vector<SE3> T_CW = InversePoses(state);
  for (size_t i = 0; i < job.observations.size(); ++i) {
    const auto& s = job.observations[i];
    const Eigen::Vector3d p_C = T_CW[s.keyframe] * state.points[s.landmark];
    state.use[i] = Use::kNothing;
    if (!(p_C.z() > kMinProjectionDepth)) continue;
    const ObservationFit fit = FitOf(job.camera, s.pixel, p_C);
    if (gate && !fit.pixel_ok()) continue;
    const bool depth = s.pixel.has_depth && (!gate || fit.depth_ok());
    state.use[i] = depth ? Use::kPixelAndDepth : Use::kPixel;
  }
}

// Puts every landmark where its observations fit best by themselves, poses as they are. With
// `leave_out`, those that are too vague there count no more.
void SettleLandmarks(const LocalBaJob& job, bool leave_out, State& state) {
  const std::vector<SE3> T_CW = InversePoses(state);
  std::vector<PosedObservation> observations;
  size_t end = 0;
  for (size_t l = 0; l < state.points.size(); ++l) {
    const size_t begin = end;
    observations.clear();
    for (; end < job.observations.size() && std::cmp_equal(job.observations[end].landmark, l);
         ++end) {
      if (state.use[end] == Use::kNothing) continue;
      const auto& s = job.observations[end];
      observations.push_back({T_CW[s.keyframe], s.pixel});
      if (state.use[end] == Use::kPixel) observations.back().pixel.has_depth = false;
    }
    const LandmarkFit fit = FitLandmark(job.camera, observations, state.points[l]);
    state.points[l] = fit.p_W;
    if (!leave_out || fit.vagueness <= kTooVague) continue;
    std::fill(state.use.begin() + static_cast<std::ptrdiff_t>(begin),
              state.use.begin() + static_cast<std::ptrdiff_t>(end), Use::kNothing);
  }
}

class StopWhenAsked final : public ceres::IterationCallback {
 public:
  explicit StopWhenAsked(const StopCondition& stop) : stop_(stop) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& /*summary*/) override {
    return stop_() ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
  }

 private:
  const StopCondition& stop_;
};

// The costs of dead reckoning in a job, and what they share.
struct DrCosts {
  ceres::CauchyLoss loss = ceres::CauchyLoss(std::sqrt(kDrRadius2));
  std::deque<HeightCost> heights;
  std::deque<RelativePoseCost> relative;  // deques: the costs cannot be moved
  std::deque<ScaledMotionCost> scaled;
  std::optional<ScalePrior> scale_prior;
};

// One pass over the used observations of a window. False when it was stopped.
bool SolveWindow(const LocalBaJob& job, const StopCondition& stop, State& state,
                 LocalBaResult& result) {
  WindowSolver solver(job.camera);
  for (size_t i = 0; i < state.poses.size(); ++i) {
    solver.AddPose(&state.poses[i], job.keyframes[i].fixed);
  }
  DrCosts costs;
  int scale = -1;
  if (job.dr_scale_sigma > 0 && !job.dr_edges.empty()) {
    scale = solver.AddVariable(state.dr_scale_error.data(), 2);
    costs.scale_prior.emplace(job.dr_scale_sigma);
    solver.AddCost(&*costs.scale_prior, nullptr, {scale});
  }
  ceres::LossFunction* const dr_loss = job.robust_dr ? &costs.loss : nullptr;
  for (const auto& edge : job.dr_edges) {
    if (scale >= 0) {
      costs.scaled.emplace_back(edge.T_FromTo, edge.lever, edge.sqrt_information);
      solver.AddCost(&costs.scaled.back(), dr_loss, {edge.from, edge.to, scale});
    } else {
      costs.relative.emplace_back(edge.T_FromTo, edge.sqrt_information);
      solver.AddCost(&costs.relative.back(), dr_loss, {edge.from, edge.to});
    }
  }
  for (const auto& height : job.heights) {
    costs.heights.emplace_back(job.camera.T_BC, height.z_W, height.sigma);
    solver.AddCost(&costs.heights.back(), nullptr, {height.keyframe});
  }
  std::vector<WindowSolver::Sight> sights;
  for (size_t i = 0; i < job.observations.size();) {
    const int32_t landmark = job.observations[i].landmark;
    sights.clear();
    for (; i < job.observations.size() && job.observations[i].landmark == landmark; ++i) {
      if (state.use[i] == Use::kNothing) continue;
      sights.push_back({job.observations[i].keyframe, job.observations[i].pixel});
      if (state.use[i] == Use::kPixel) sights.back().pixel.has_depth = false;
    }
    if (!sights.empty()) solver.AddLandmark(&state.points[landmark], sights);
  }
  WindowSolver::Options options;
  options.iterations = job.iterations;
  options.function_tolerance = job.function_tolerance;
  options.stop = stop;
  const WindowSolver::Summary summary = solver.Solve(options);
  result.iterations += summary.iterations;
  return summary.usable;
}

// The same for a whole map, whose reduced system is large and sparse. False when the solver failed
// or was stopped; the state is then unspecified.
bool SolveWhole(const LocalBaJob& job, const ceres::Manifold& manifold, const StopCondition& stop,
                State& state, LocalBaResult& result) {
  std::deque<ReprojectionCost<2>> mono;  // deques: the costs cannot be moved
  std::deque<ReprojectionCost<3>> stereo;
  DrCosts costs;

  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.disable_all_safety_checks = true;
  ceres::Problem problem(ownership);

  auto* ordering = new ceres::ParameterBlockOrdering;  // the solver's options own it
  for (size_t i = 0; i < state.poses.size(); ++i) {
    double* block = state.poses[i].data();
    problem.AddParameterBlock(block, 7, const_cast<ceres::Manifold*>(&manifold));
    if (job.keyframes[i].fixed) problem.SetParameterBlockConstant(block);
    ordering->AddElementToGroup(block, 1);
  }
  for (size_t i = 0; i < job.observations.size(); ++i) {
    if (state.use[i] == Use::kNothing) continue;
    const auto& s = job.observations[i];
    double* pose = state.poses[s.keyframe].data();
    double* point = state.points[s.landmark].data();
    if (state.use[i] == Use::kPixelAndDepth) {
      stereo.emplace_back(&job.camera, s.pixel);
      problem.AddResidualBlock(&stereo.back(), nullptr, pose, point);
    } else {
      mono.emplace_back(&job.camera, s.pixel);
      problem.AddResidualBlock(&mono.back(), nullptr, pose, point);
    }
    ordering->AddElementToGroup(point, 0);
  }
  ceres::LossFunction* const dr_loss = job.robust_dr ? &costs.loss : nullptr;
  for (const auto& edge : job.dr_edges) {
    double* from = state.poses[edge.from].data();
    double* to = state.poses[edge.to].data();
    if (job.dr_scale_sigma > 0) {
      costs.scaled.emplace_back(edge.T_FromTo, edge.lever, edge.sqrt_information);
      problem.AddResidualBlock(&costs.scaled.back(), dr_loss, from, to,
                               state.dr_scale_error.data());
    } else {
      costs.relative.emplace_back(edge.T_FromTo, edge.sqrt_information);
      problem.AddResidualBlock(&costs.relative.back(), dr_loss, from, to);
    }
  }
  for (const auto& height : job.heights) {
    costs.heights.emplace_back(job.camera.T_BC, height.z_W, height.sigma);
    problem.AddResidualBlock(&costs.heights.back(), nullptr, state.poses[height.keyframe].data());
  }
  if (!costs.scaled.empty()) {
    costs.scale_prior.emplace(job.dr_scale_sigma);
    problem.AddResidualBlock(&*costs.scale_prior, nullptr, state.dr_scale_error.data());
    ordering->AddElementToGroup(state.dr_scale_error.data(), 1);
  }
  if (problem.NumResidualBlocks() == 0) {
    delete ordering;
    return true;
  }

  ceres::Solver::Options options;
  options.linear_solver_ordering.reset(ordering);
  options.linear_solver_type = ceres::SPARSE_SCHUR;
  options.num_threads = 1;
  options.max_num_iterations = job.iterations;
  options.function_tolerance = job.function_tolerance;
  options.initial_trust_region_radius = kWholeSteps;
  options.logging_type = ceres::SILENT;
  StopWhenAsked stop_when_asked(stop);
  if (stop) options.callbacks.push_back(&stop_when_asked);
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  result.iterations += static_cast<int>(summary.iterations.size());
  return summary.IsSolutionUsable();
}

// The same with all that belongs to a pass; `gate` as in Classify.
bool Adjust(const LocalBaJob& job, const ceres::Manifold& manifold, const StopCondition& stop,
            bool gate, State& state, LocalBaResult& result) {
  Classify(job, gate, state);
  if (!job.settle_landmarks) return SolveWindow(job, stop, state, result);
  SettleLandmarks(job, /*leave_out=*/true, state);
  if (!SolveWhole(job, manifold, stop, state, result)) return false;
  Classify(job, gate, state);
  SettleLandmarks(job, /*leave_out=*/false, state);  // those that sat out follow
  return true;
}

// Robust cost of what counts of the observations, and of the DR edges.
double Cost(const LocalBaJob& job, const State& state) {
  double cost = 0;
  const std::vector<SE3> T_CW = InversePoses(state);
  for (size_t i = 0; i < job.observations.size(); ++i) {
    if (state.use[i] == Use::kNothing) continue;
    const auto& s = job.observations[i];
    const ObservationFit fit =
        FitOf(job.camera, s.pixel, T_CW[s.keyframe] * state.points[s.landmark]);
    cost += HuberCost(fit.chi2_pixel, kChi2Pixel);
    if (state.use[i] == Use::kPixelAndDepth) cost += HuberCost(fit.chi2_depth, kChi2Depth);
  }
  for (const auto& edge : job.dr_edges) {
    const SE3 T_ab = T_CW[edge.from] * T_CW[edge.to].inverse();
    const SE3 T_FromTo = edge.T_FromTo * SE3::Exp(edge.lever * state.dr_scale_error);
    const double squared =
        (edge.sqrt_information * (T_FromTo.inverse() * T_ab).Log()).squaredNorm();
    cost += job.robust_dr ? CauchyCost(squared, kDrRadius2) : squared;
  }
  for (const auto& height : job.heights) {
    const double* pose = state.poses[height.keyframe].data();
    double sigmas = 0;
    HeightCost(job.camera.T_BC, height.z_W, height.sigma).Evaluate(&pose, &sigmas, nullptr);
    cost += sigmas * sigmas;
  }
  if (job.dr_scale_sigma > 0) {
    cost += (state.dr_scale_error / job.dr_scale_sigma).squaredNorm();
  }
  return 0.5 * cost;
}

}  // namespace

LocalBaResult SolveLocalBa(const LocalBaJob& job, const StopCondition& stop) {
  LocalBaResult result;
  result.revision = job.revision;
  result.newest = job.newest;
  State state;
  for (const auto& keyframe : job.keyframes) state.poses.push_back(ToBlock(keyframe.T_WC));
  for (const auto& landmark : job.landmarks) state.points.push_back(landmark.p_W);
  state.use.resize(job.observations.size());
  const State start = state;

  const PoseManifold manifold;
  if (!Adjust(job, manifold, stop, /*gate=*/false, state, result)) return result;
  Classify(job, /*gate=*/true, state);
  const auto outliers = std::count(state.use.begin(), state.use.end(), Use::kNothing);
  if (static_cast<double>(outliers) > kNegligibleOutliers * static_cast<double>(state.use.size())) {
    if (!Adjust(job, manifold, stop, /*gate=*/true, state, result)) return result;
    Classify(job, /*gate=*/true, state);
  }

  result.usable = state.dr_scale_error.allFinite();
  result.dr_scale_error = state.dr_scale_error;
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
  for (size_t i = 0; i < job.observations.size(); ++i) {
    const auto& s = job.observations[i];
    if (state.use[i] != Use::kNothing) {
      ++result.num_observations;
    } else {
      result.outliers.push_back({job.landmarks[s.landmark].id, job.keyframes[s.keyframe].id});
    }
  }
  for (const auto& edge : job.dr_edges) {
    result.dr_edges.push_back({job.keyframes[edge.from].id, job.keyframes[edge.to].id, edge.alpha});
  }
  State before = start;
  before.use = state.use;
  result.cost_before = Cost(job, before);
  result.cost_after = Cost(job, state);
  result.usable &= std::isfinite(result.cost_after);
  return result;
}

}  // namespace gw::backend
