#include "backend/core/loop/pose_graph.h"

#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>

#include "backend/core/bundle/ceres_blocks.h"

namespace gw::backend {
namespace {

constexpr double kFunctionTolerance = 1e-7;  // 0.1 % of the final cost needs far less
constexpr double kHarder = 2.0;              // growth of the control parameter per round
constexpr int kMaxRounds = 40;

Vector6d Residual(const PoseGraph::Edge& edge, const std::vector<PoseBlock>& poses) {
  const SE3 T_ab = FromBlock(poses[edge.from].data()).inverse() * FromBlock(poses[edge.to].data());
  return edge.sqrt_information * (edge.T_FromTo.inverse() * T_ab).Log();
}

// Mean squared residual of each group's edges.
std::vector<double> GroupResiduals(const PoseGraph& graph, const std::vector<PoseBlock>& poses) {
  std::vector<double> sum(static_cast<size_t>(graph.num_groups), 0.0);
  std::vector<int> count(sum.size(), 0);
  for (const auto& edge : graph.edges) {
    if (edge.group < 0) continue;
    sum[edge.group] += Residual(edge, poses).squaredNorm();
    ++count[edge.group];
  }
  for (size_t g = 0; g < sum.size(); ++g) sum[g] /= std::max(1, count[g]);
  return sum;
}

double Cost(const PoseGraph& graph, const std::vector<PoseBlock>& poses,
            const std::vector<double>& weights) {
  double cost = 0;
  for (const auto& edge : graph.edges) {
    const double w = edge.group < 0 ? 1.0 : weights[edge.group];
    if (w > 0) cost += w * Residual(edge, poses).squaredNorm();
  }
  return 0.5 * cost;
}

// One least-squares solve with the groups weighted. False: no usable solution.
bool Solve(const PoseGraph& graph, const std::vector<double>& weights,
           std::vector<PoseBlock>& poses, int& iterations) {
  const PoseManifold manifold;
  std::deque<RelativePoseCost> relative;  // a deque: the costs cannot be moved
  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.disable_all_safety_checks = true;
  ceres::Problem problem(ownership);
  for (size_t i = 0; i < poses.size(); ++i) {
    problem.AddParameterBlock(poses[i].data(), 7, const_cast<PoseManifold*>(&manifold));
    if (graph.nodes[i].fixed) problem.SetParameterBlockConstant(poses[i].data());
  }
  for (const auto& edge : graph.edges) {
    const double w = edge.group < 0 ? 1.0 : weights[edge.group];
    if (!(w > 0)) continue;
    relative.emplace_back(edge.T_FromTo, std::sqrt(w) * edge.sqrt_information);
    problem.AddResidualBlock(&relative.back(), nullptr, poses[edge.from].data(),
                             poses[edge.to].data());
  }
  if (problem.NumResidualBlocks() == 0) return true;
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  options.num_threads = 1;
  options.max_num_iterations = graph.iterations;
  options.function_tolerance = kFunctionTolerance;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  iterations += static_cast<int>(summary.iterations.size());
  return summary.IsSolutionUsable();
}

// Weight of a group under the surrogate of the truncated square with control parameter mu.
double TruncatedWeight(double squared, double mu) {
  if (squared <= mu / (mu + 1) * kGroupGate) return 1.0;
  if (squared >= (mu + 1) / mu * kGroupGate) return 0.0;
  return std::sqrt(kGroupGate / squared * mu * (mu + 1)) - mu;
}

// Graduated weights may settle without a group that the graph could follow: a drifted chain is far
// from a true loop as long as that weighs little. So each group that is off is tried once at full
// weight, newest first; it stays when that costs less than the gate. False: no usable solution.
bool Readmit(const PoseGraph& graph, std::vector<double>& weights, std::vector<PoseBlock>& poses,
             int& iterations) {
  if (!Solve(graph, weights, poses, iterations)) return false;
  for (size_t g = weights.size(); g-- > 0;) {
    if (weights[g] > 0) continue;
    const auto edges = std::count_if(
        graph.edges.begin(), graph.edges.end(),
        [&](const PoseGraph::Edge& edge) { return edge.group == static_cast<int32_t>(g); });
    const double allowed =
        Cost(graph, poses, weights) + 0.5 * kGroupGate * static_cast<double>(edges);
    std::vector<PoseBlock> tried = poses;
    weights[g] = 1.0;
    if (!Solve(graph, weights, tried, iterations)) return false;
    if (Cost(graph, tried, weights) < allowed) {
      poses = std::move(tried);
    } else {
      weights[g] = 0.0;
    }
  }
  return true;
}

}  // namespace

PoseGraphResult SolvePoseGraph(const PoseGraph& graph) {
  PoseGraphResult out;
  std::vector<PoseBlock> poses;
  poses.reserve(graph.nodes.size());
  for (const auto& node : graph.nodes) poses.push_back(ToBlock(node.T_WC));
  const std::vector<PoseBlock> start = poses;

  std::vector<double> weights(static_cast<size_t>(graph.num_groups), 1.0);
  if (!Solve(graph, weights, poses, out.iterations)) return out;
  std::vector<double> residuals = GroupResiduals(graph, poses);
  const double largest =
      residuals.empty() ? 0.0 : *std::max_element(residuals.begin(), residuals.end());
  if (largest > kGroupGate) {
    double mu = kGroupGate / (2 * largest - kGroupGate);
    for (int round = 0; round < kMaxRounds; ++round, mu *= kHarder) {
      const std::vector<double> before = weights;
      bool decided = true;
      for (size_t g = 0; g < weights.size(); ++g) {
        weights[g] = TruncatedWeight(residuals[g], mu);
        decided &= weights[g] == 0.0 || weights[g] == 1.0;
      }
      if (decided && weights == before) break;
      if (!Solve(graph, weights, poses, out.iterations)) return out;
      residuals = GroupResiduals(graph, poses);
    }
    for (double& w : weights) w = w > 0.5 ? 1.0 : 0.0;
    if (!Readmit(graph, weights, poses, out.iterations)) return out;
  }

  out.usable = true;
  for (const PoseBlock& pose : poses) {
    out.T_WC.push_back(FromBlock(pose.data()));
    out.usable &= out.T_WC.back().IsFinite();
  }
  for (const double w : weights) out.group_kept.push_back(w > 0 ? 1 : 0);
  out.cost_before = Cost(graph, start, weights);
  out.cost_after = Cost(graph, poses, weights);
  out.usable &= std::isfinite(out.cost_after);
  return out;
}

}  // namespace gw::backend
