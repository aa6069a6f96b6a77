#include "backend/core/bundle/local_ba.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <map>

#include "backend/test/world.h"

namespace gw::backend {
namespace {

// A window of `n` keyframes of the world, the first one fixed, poses and points off their truth.
LocalBaJob MakeJob(World& world, int n, double point_sigma_m = 0.05) {
  LocalBaJob job;
  job.camera = TestCamera();
  job.newest = {n};
  std::map<int, std::vector<LocalBaJob::SeenLandmark>> seen;
  for (int k = 0; k < n; ++k) {
    const Keyframe keyframe = world.Make(k, {});
    job.keyframes.push_back({keyframe.id, keyframe.T_WC, k == 0});
    for (size_t i = 0; i < keyframe.features.size(); ++i) {
      const Feature& f = keyframe.features[i];
      seen[world.PointOf(keyframe.id, static_cast<int>(i))].push_back(
          {k, 0, ObservationOf(f, job.camera, Pyramid(1.2, 8), f.depth)});
    }
  }
  for (auto& [point, observations] : seen) {
    if (observations.size() < 2) continue;
    CounterRng rng(5, 6, static_cast<uint64_t>(point));
    const Eigen::Vector3d error(rng.Normal(), rng.Normal(), rng.Normal());
    for (auto& s : observations) s.landmark = static_cast<int32_t>(job.landmarks.size());
    job.landmarks.push_back({{point + 1}, world.point(point) + point_sigma_m * error});
    job.observations.insert(job.observations.end(), observations.begin(), observations.end());
  }
  return job;
}

double PoseRmse(const World& world, const LocalBaResult& result) {
  double sum = 0;
  for (const auto& moved : result.keyframes) {
    const int k = static_cast<int>(moved.id.value) - 1;
    sum += (moved.T_WC.translation() - world.TruePose(k).translation()).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(result.keyframes.size()));
}

// The same least squares problem, solved densely with numeric derivatives: poses of the free
// keyframes (6 each), then points (3 each). Quadratic cost; no Huber, no outliers.
double DenseReferenceCost(const LocalBaJob& job) {
  std::vector<SE3> poses;
  std::vector<Eigen::Vector3d> points;
  std::vector<int> column(job.keyframes.size(), -1);
  int n = 0;
  for (size_t i = 0; i < job.keyframes.size(); ++i) {
    poses.push_back(job.keyframes[i].T_WC);
    if (!job.keyframes[i].fixed) {
      column[i] = n;
      n += 6;
    }
  }
  const int first_point = n;
  for (const auto& landmark : job.landmarks) points.push_back(landmark.p_W);
  n += 3 * static_cast<int>(points.size());
  const auto residuals = [&](const Eigen::VectorXd& d) {
    std::vector<SE3> moved = poses;
    for (size_t i = 0; i < poses.size(); ++i) {
      if (column[i] >= 0) moved[i] = poses[i] * SE3::Exp(d.segment<6>(column[i]));
    }
    Eigen::VectorXd r(3 * job.observations.size() + 6 * job.dr_edges.size());
    Eigen::Index row = 0;
    for (const auto& s : job.observations) {
      const Eigen::Vector3d p_W = points[s.landmark] + d.segment<3>(first_point + 3 * s.landmark);
      r.segment<3>(row) =
          ReprojectionResidual(job.camera, s.pixel, moved[s.keyframe].inverse() * p_W);
      row += 3;
    }
    for (const auto& edge : job.dr_edges) {
      const SE3 T_ab = moved[edge.from].inverse() * moved[edge.to];
      r.segment<6>(row) = edge.sqrt_information * (edge.T_FromTo.inverse() * T_ab).Log();
      row += 6;
    }
    return r;
  };
  double cost = 0;
  for (int iteration = 0; iteration < 15; ++iteration) {
    const Eigen::VectorXd r = residuals(Eigen::VectorXd::Zero(n));
    cost = 0.5 * r.squaredNorm();
    Eigen::MatrixXd J(r.size(), n);
    for (int i = 0; i < n; ++i) {
      Eigen::VectorXd d = Eigen::VectorXd::Zero(n);
      d[i] = 1e-6;
      J.col(i) = (residuals(d) - residuals(-d)) / 2e-6;
    }
    const Eigen::VectorXd step = -(J.transpose() * J).ldlt().solve(J.transpose() * r);
    for (size_t i = 0; i < poses.size(); ++i) {
      if (column[i] >= 0) poses[i] = poses[i] * SE3::Exp(step.segment<6>(column[i]));
    }
    for (size_t i = 0; i < points.size(); ++i) {
      points[i] += step.segment<3>(first_point + 3 * static_cast<Eigen::Index>(i));
    }
  }
  return cost;
}

LocalBaJob::DrEdge Edge(const World& world, int to, double alpha) {
  const SE3 T_BC = TestCamera().T_BC;
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(0.02), Eigen::Vector3d::Constant(0.005);
  const DrMotion motion = CameraMotion(world.Dr(to), T_BC, {});
  return {to - 1,
          to,
          motion.T_CaCb,
          motion.lever,
          Matrix6d((std::sqrt(alpha) * sigma.cwiseInverse()).asDiagonal()),
          alpha};
}

TEST(LocalBa, ReachesTheCostOfADenseReference) {
  World world({.seed = 3, .num_points = 250, .pixel_sigma = 0.3, .keyframes_per_lap = 160});
  LocalBaJob job = MakeJob(world, 4, 0.02);
  job.iterations = 30;
  job.dr_edges.push_back(Edge(world, 1, 1.0));
  job.dr_edges.push_back(Edge(world, 2, 10.0));
  ASSERT_GT(job.landmarks.size(), 10u);
  const LocalBaResult result = SolveLocalBa(job);
  ASSERT_TRUE(result.usable);
  ASSERT_TRUE(result.outliers.empty());
  const double reference = DenseReferenceCost(job);
  // Less than the reference by what the robust cost of the DR edges takes off.
  EXPECT_NEAR(result.cost_after, reference, 2e-3 * reference);
  EXPECT_GT(result.cost_before, 2 * reference);
}

TEST(LocalBa, CostPerDegreeOfFreedomIsThatOfTheNoise) {
  World world({.keyframes_per_lap = 160});
  const LocalBaJob job = MakeJob(world, 12);
  const LocalBaResult result = SolveLocalBa(job);
  ASSERT_TRUE(result.usable);
  double rows = 0;
  for (const auto& s : job.observations) rows += s.pixel.has_depth ? 3 : 2;
  const double freedom = rows - 3.0 * static_cast<double>(job.landmarks.size()) - 6.0 * 11;
  const double variance = std::pow(world.options().pixel_sigma, 2);
  EXPECT_NEAR(2 * result.cost_after / freedom / variance, 1.0, 0.06);
}

TEST(LocalBa, FindsTheOutliersAndIsNotMovedByThem) {
  World world({.keyframes_per_lap = 160});
  LocalBaJob clean = MakeJob(world, 10);
  LocalBaJob dirty = clean;
  std::vector<size_t> wrong;
  for (size_t i = 0; i < dirty.observations.size(); ++i) {
    CounterRng rng(8, 9, i);
    if (rng.Uniform() >= 0.05) continue;
    dirty.observations[i].pixel.u += rng.Uniform(20, 60);
    dirty.observations[i].pixel.v -= rng.Uniform(20, 60);
    wrong.push_back(i);
  }
  const LocalBaResult result = SolveLocalBa(dirty);
  ASSERT_TRUE(result.usable);
  std::set<std::pair<LandmarkId, KeyframeId>> found;
  for (const auto& o : result.outliers) found.insert({o.landmark, o.keyframe});
  size_t hits = 0;
  for (const size_t i : wrong) {
    const auto& s = dirty.observations[i];
    hits += found.contains({dirty.landmarks[s.landmark].id, dirty.keyframes[s.keyframe].id});
  }
  EXPECT_GT(hits, 0.97 * static_cast<double>(wrong.size()));
  // Honest ones go with them where a landmark has few observations, but not many.
  EXPECT_LT(static_cast<double>(result.outliers.size()), 1.3 * static_cast<double>(wrong.size()));
  EXPECT_LT(PoseRmse(world, result), 1.5 * PoseRmse(world, SolveLocalBa(clean)) + 0.002);
}

TEST(LocalBa, SameJobGivesTheSameBytes) {
  World world({.keyframes_per_lap = 160});
  LocalBaJob job = MakeJob(world, 8);
  job.dr_edges.push_back(Edge(world, 1, 1.0));
  const LocalBaResult a = SolveLocalBa(job);
  const LocalBaResult b = SolveLocalBa(job);
  ASSERT_EQ(a.landmarks.size(), b.landmarks.size());
  for (size_t i = 0; i < a.landmarks.size(); ++i) EXPECT_EQ(a.landmarks[i].p_W, b.landmarks[i].p_W);
  for (size_t i = 0; i < a.keyframes.size(); ++i) {
    EXPECT_EQ(a.keyframes[i].T_WC.matrix(), b.keyframes[i].T_WC.matrix());
  }
  EXPECT_EQ(a.cost_after, b.cost_after);
}

// A landmark 5 m before keyframe 3, which keyframe 4 sees 8 px from where it should: no point in
// front of both cameras has that parallax, and the solver sends it behind them.
void AddVagueLandmark(const World& world, LocalBaJob& job) {
  const Eigen::Vector3d p_W = world.TruePose(3) * Eigen::Vector3d(0.1, 0.1, 5);
  for (const int k : {3, 4}) {
    const Eigen::Vector2d uv = job.camera.Project(world.TruePose(k).inverse() * p_W);
    const double wrong_px = k == 4 ? 8 : 0;
    job.observations.push_back(
        {k, static_cast<int32_t>(job.landmarks.size()), {uv.x() + wrong_px, uv.y()}});
  }
  job.landmarks.push_back({{1'000'000}, p_W});
}

// Both solvers come to the same map, and that of whole maps in whole steps.
TEST(LocalBa, SettledLandmarksLetTheMapMoveInWholeSteps) {
  World world({.seed = 3, .pixel_sigma = 0.3, .keyframes_per_lap = 160});
  LocalBaJob job = MakeJob(world, 10, 0.3);
  for (int to = 1; to < 10; ++to) job.dr_edges.push_back(Edge(world, to, 1.0));
  AddVagueLandmark(world, job);
  job.iterations = 50;
  job.function_tolerance = 1e-6;
  const LocalBaResult plain = SolveLocalBa(job);
  job.settle_landmarks = true;
  const LocalBaResult settled = SolveLocalBa(job);
  ASSERT_TRUE(plain.usable && settled.usable);
  EXPECT_NEAR(settled.cost_after, plain.cost_after, 0.01 * plain.cost_after);
  EXPECT_LE(settled.iterations, 16);  // 24 and more where landmarks do not settle first
  EXPECT_NEAR(PoseRmse(world, settled), PoseRmse(world, plain), 0.1 * PoseRmse(world, plain));
}

TEST(LocalBa, DrEdgesAloneHoldKeyframesThatSeeNothing) {
  World world({.dr_sigma_m = 0, .dr_sigma_rad = 0});
  LocalBaJob job;
  job.camera = TestCamera();
  for (int k = 0; k < 5; ++k) {
    const SE3 T_WC = k == 0
                         ? world.TruePose(0)
                         : world.TruePose(0) * SE3::Exp(Vector6d::Constant(0.02 * k));  // far off
    job.keyframes.push_back({{k + 1}, T_WC, k == 0});
    if (k > 0) job.dr_edges.push_back(Edge(world, k, 1000));
  }
  job.iterations = 30;
  const LocalBaResult result = SolveLocalBa(job);
  ASSERT_TRUE(result.usable);
  EXPECT_LT(PoseRmse(world, result), 1e-5);
}

// A tilt between the first two keyframes, as weak vision leaves it, lifts all that follow; heights
// put it right.
TEST(LocalBa, HeightsOfTheBodyKeepATiltFromLiftingTheMap) {
  const World world({.dr_sigma_m = 0, .dr_sigma_rad = 0});
  LocalBaJob job;
  job.camera = TestCamera();
  for (int k = 0; k < 12; ++k) {
    job.keyframes.push_back({{k + 1}, world.TruePose(k), k == 0});
    if (k > 0) job.dr_edges.push_back(Edge(world, k, 1));
  }
  const SE3 tilt(ExpSO3({0.01, 0.01, 0}), Eigen::Vector3d::Zero());
  job.dr_edges[0].T_FromTo = job.dr_edges[0].T_FromTo * tilt;
  job.iterations = 30;
  const auto height = [&](const SE3& T_WC) {
    return (T_WC * job.camera.T_BC.inverse()).translation().z();
  };
  const auto largest_error = [&](const LocalBaResult& result) {
    double largest = 0;
    for (const auto& k : result.keyframes) {
      const SE3 truth = world.TruePose(static_cast<int>(k.id.value) - 1);
      largest = std::max(largest, std::abs(height(k.T_WC) - height(truth)));
    }
    return largest;
  };
  const LocalBaResult lifted = SolveLocalBa(job);
  for (int k = 1; k < 12; ++k) {
    job.heights.push_back({k, height(world.TruePose(k)), 0.01});
  }
  const LocalBaResult held = SolveLocalBa(job);
  ASSERT_TRUE(lifted.usable && held.usable);
  EXPECT_GT(largest_error(lifted), 0.01);
  EXPECT_LT(largest_error(held), 0.3 * largest_error(lifted)) << largest_error(lifted);
}

// Dead reckoning with wrong scales: strong edges bend the map, unless they may share the errors.
TEST(LocalBa, DrWithScaleErrorsInCommonDoesNotBendTheMap) {
  World world({.dr_sigma_m = 0.001, .dr_sigma_rad = 0.0001, .keyframes_per_lap = 160});
  LocalBaJob job = MakeJob(world, 12);
  const Eigen::Vector2d errors(0.02, -0.03);
  for (int k = 1; k < 12; ++k) {
    LocalBaJob::DrEdge edge = Edge(world, k, 1000);
    edge.T_FromTo = edge.T_FromTo * SE3::Exp(-edge.lever * errors);
    job.dr_edges.push_back(edge);
  }
  const LocalBaResult stiff = SolveLocalBa(job);
  job.dr_scale_sigma = 0.05;
  const LocalBaResult scaled = SolveLocalBa(job);
  ASSERT_TRUE(stiff.usable && scaled.usable);
  EXPECT_EQ(stiff.dr_scale_error.norm(), 0);
  EXPECT_LT((scaled.dr_scale_error - errors).norm(), 0.3 * errors.norm())
      << scaled.dr_scale_error.transpose();
  EXPECT_LT(PoseRmse(world, scaled), 0.5 * PoseRmse(world, stiff));
}

TEST(LocalBa, AnEmptyJobMovesNothing) {
  LocalBaJob job;
  job.camera = TestCamera();
  job.keyframes.push_back({{1}, SE3(), true});
  job.keyframes.push_back({{2}, SE3(), false});
  const LocalBaResult result = SolveLocalBa(job);
  ASSERT_TRUE(result.usable);
  EXPECT_EQ(result.keyframes.at(0).T_WC.translation().norm(), 0);
}

}  // namespace
}  // namespace gw::backend
