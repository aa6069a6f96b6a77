#include "backend/core/loop/pose_graph.h"

#include <gtest/gtest.h>

#include <Eigen/SparseCholesky>
#include <chrono>
#include <filesystem>
#include <numbers>

#include "backend/test/g2o.h"
#include "common/core/random.h"

namespace gw::backend {
namespace {

Vector6d Noise(CounterRng& rng, double sigma_m, double sigma_rad) {
  Vector6d out;
  for (int i = 0; i < 6; ++i) out[i] = rng.Normal() * (i < 3 ? sigma_m : sigma_rad);
  return out;
}

Matrix6d SqrtInformation(double sigma_m, double sigma_rad) {
  Vector6d s;
  s << Eigen::Vector3d::Constant(1 / sigma_m), Eigen::Vector3d::Constant(1 / sigma_rad);
  return s.asDiagonal();
}

constexpr double kSigmaM = 0.02;
constexpr double kSigmaRad = 0.01;

// A robot on a circle, one and a bit times around, whose odometry drifts.
struct Ring {
  static constexpr int kNodes = 60;
  std::vector<SE3> truth;
  PoseGraph graph;

  Ring() {
    for (int i = 0; i < kNodes; ++i) {
      const double a = 2 * std::numbers::pi * i / 50;
      truth.push_back(SE3(ExpSO3({0, 0, a}), {5 * std::sin(a), 5 - 5 * std::cos(a), 0}));
    }
    SE3 T = truth[0];
    for (int i = 0; i < kNodes; ++i) {
      if (i > 0) {
        CounterRng rng(1, 1, static_cast<uint64_t>(i));
        const SE3 step =
            truth[i - 1].inverse() * truth[i] * SE3::Exp(Noise(rng, kSigmaM, kSigmaRad));
        T = T * step;
        graph.edges.push_back({i - 1, i, step, SqrtInformation(kSigmaM, kSigmaRad), -1});
      }
      graph.nodes.push_back({T, i == 0});
    }
  }
  void AddLoop(int from, int to, const SE3& error = SE3()) {
    graph.edges.push_back({from, to, truth[from].inverse() * truth[to] * error,
                           SqrtInformation(kSigmaM, kSigmaRad), graph.num_groups++});
  }
  double Rmse(const std::vector<SE3>& poses) const {
    double sum = 0;
    for (int i = 0; i < kNodes; ++i) {
      sum += (poses[i].translation() - truth[i].translation()).squaredNorm();
    }
    return std::sqrt(sum / kNodes);
  }
  double StartRmse() const {
    std::vector<SE3> poses;
    for (const auto& node : graph.nodes) poses.push_back(node.T_WC);
    return Rmse(poses);
  }
};

TEST(PoseGraph, ALoopTakesTheDriftOut) {
  Ring ring;
  for (int i = 50; i < 58; ++i) ring.AddLoop(i - 50, i);
  const PoseGraphResult out = SolvePoseGraph(ring.graph);
  ASSERT_TRUE(out.usable);
  EXPECT_LT(ring.Rmse(out.T_WC), 0.5 * ring.StartRmse());
  EXPECT_LT(out.cost_after, 0.01 * out.cost_before);
  for (const uint8_t kept : out.group_kept) EXPECT_EQ(kept, 1);
}

TEST(PoseGraph, WrongLoopsAreSwitchedOffAndTrueOnesKept) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    Ring ring;
    for (int i = 50; i < 58; ++i) ring.AddLoop(i - 50, i);
    CounterRng rng(seed, 9, 0);
    const int num_wrong = 1 + static_cast<int>(rng.Below(4));
    for (int k = 0; k < num_wrong; ++k) {
      const int from = static_cast<int>(rng.Below(20));
      ring.AddLoop(from, from + 20 + static_cast<int>(rng.Below(15)),
                   SE3::Exp(Noise(rng, 2.0, 0.5)));
    }
    const PoseGraphResult out = SolvePoseGraph(ring.graph);
    ASSERT_TRUE(out.usable);
    for (int g = 0; g < 8; ++g) EXPECT_EQ(out.group_kept[g], 1) << seed << " " << g;
    for (int g = 8; g < ring.graph.num_groups; ++g) EXPECT_EQ(out.group_kept[g], 0) << seed;
    EXPECT_LT(ring.Rmse(out.T_WC), 0.5 * ring.StartRmse()) << seed;
  }
}

TEST(PoseGraph, SameGraphSameBytes) {
  Ring ring;
  ring.AddLoop(2, 52);
  ring.AddLoop(5, 30, SE3(Eigen::Quaterniond::Identity(), {3, 0, 0}));
  const PoseGraphResult a = SolvePoseGraph(ring.graph);
  const PoseGraphResult b = SolvePoseGraph(ring.graph);
  for (int i = 0; i < Ring::kNodes; ++i) EXPECT_EQ(a.T_WC[i].matrix(), b.T_WC[i].matrix());
}

TEST(PoseGraph, AGraphWithoutEdgesStaysAsItIs) {
  PoseGraph graph;
  graph.nodes.push_back({SE3(), true});
  const PoseGraphResult out = SolvePoseGraph(graph);
  EXPECT_TRUE(out.usable);
  EXPECT_EQ(out.T_WC.size(), 1u);
}

// Independent reference: Gauss-Newton with numeric Jacobians of g2o's own error, our manifold, and
// Eigen's factorisation instead of Ceres and CHOLMOD.
std::vector<SE3> ReferenceSolution(const PoseGraph& graph) {
  std::vector<SE3> T;
  for (const auto& node : graph.nodes) T.push_back(node.T_WC);
  const auto error = [](const PoseGraph::Edge& edge, const SE3& a, const SE3& b) {
    const SE3 E = edge.T_FromTo.inverse() * a.inverse() * b;
    Vector6d e;
    e << E.translation(), (E.rotation().w() < 0 ? -2 : 2) * E.rotation().vec();
    return Vector6d(edge.sqrt_information * e);
  };
  const int n = static_cast<int>(T.size());
  constexpr double kStep = 1e-6;
  for (int iteration = 0; iteration < 12; ++iteration) {
    std::vector<Eigen::Triplet<double>> H;
    H.reserve(6 + 144 * graph.edges.size());
    Eigen::VectorXd g = Eigen::VectorXd::Zero(6 * n);
    for (int i = 0; i < 6; ++i) H.emplace_back(i, i, 1e12);  // node 0 is fixed
    for (const auto& edge : graph.edges) {
      const Vector6d e = error(edge, T[edge.from], T[edge.to]);
      Eigen::Matrix<double, 6, 12> J;
      for (int k = 0; k < 6; ++k) {
        const Vector6d d = kStep * Vector6d::Unit(k);
        J.col(k) = (error(edge, T[edge.from] * SE3::Exp(d), T[edge.to]) -
                    error(edge, T[edge.from] * SE3::Exp(-d), T[edge.to])) /
                   (2 * kStep);
        J.col(6 + k) = (error(edge, T[edge.from], T[edge.to] * SE3::Exp(d)) -
                        error(edge, T[edge.from], T[edge.to] * SE3::Exp(-d))) /
                       (2 * kStep);
      }
      const Eigen::Matrix<double, 12, 12> JJ = J.transpose() * J;
      const Eigen::Matrix<double, 12, 1> Je = J.transpose() * e;
      const int at[2] = {6 * edge.from, 6 * edge.to};
      for (int r = 0; r < 12; ++r) {
        g[at[r / 6] + r % 6] += Je[r];
        for (int c = 0; c < 12; ++c) {
          H.emplace_back(at[r / 6] + r % 6, at[c / 6] + c % 6, JJ(r, c));
        }
      }
    }
    Eigen::SparseMatrix<double> A(6 * n, 6 * n);
    A.setFromTriplets(H.begin(), H.end());
    const Eigen::VectorXd d = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(A).solve(-g);
    for (int i = 1; i < n; ++i) T[i] = T[i] * SE3::Exp(d.segment<6>(6 * i));
    if (d.norm() < 1e-9) break;
  }
  return T;
}

TEST(PoseGraph, ParkingGarageReachesTheReferenceCost) {
  const std::string path = GW_SOURCE_DIR "/../shared/data/pose_graphs/parking-garage.g2o";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  const auto graph = ReadG2o(path);
  ASSERT_TRUE(graph.ok()) << graph.error().message;
  const auto begin = std::chrono::steady_clock::now();
  const PoseGraphResult out = SolvePoseGraph(*graph);
  const double ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  ASSERT_TRUE(out.usable);
  std::vector<SE3> start;
  for (const auto& node : graph->nodes) start.push_back(node.T_WC);
  const double ours = G2oCost(*graph, out.T_WC);
  const double reference = G2oCost(*graph, ReferenceSolution(*graph));
  std::printf("parking-garage: %zu poses, %zu edges, cost %.6g -> %.6g, reference %.6g, %.0f ms\n",
              graph->nodes.size(), graph->edges.size(), G2oCost(*graph, start), ours, reference,
              ms);
  EXPECT_NEAR(ours, reference, 1e-3 * reference);
}

}  // namespace
}  // namespace gw::backend
