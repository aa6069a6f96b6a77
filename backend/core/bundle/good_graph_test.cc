#include "backend/core/bundle/good_graph.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "backend/core/mapper.h"
#include "backend/test/world.h"
#include "common/core/random.h"

namespace gw::backend {
namespace {

double LogDeterminant(const Eigen::MatrixXd& M, const std::vector<int>& blocks) {
  const auto n = static_cast<Eigen::Index>(6 * blocks.size());
  Eigen::MatrixXd part(n, n);
  for (size_t i = 0; i < blocks.size(); ++i) {
    for (size_t j = 0; j < blocks.size(); ++j) {
      part.block<6, 6>(static_cast<Eigen::Index>(6 * i), static_cast<Eigen::Index>(6 * j)) =
          M.block<6, 6>(6 * blocks[i], 6 * blocks[j]);
    }
  }
  return Eigen::PartialPivLU<Eigen::MatrixXd>(part)
      .matrixLU()
      .diagonal()
      .cwiseAbs()
      .array()
      .log()
      .sum();
}

Eigen::MatrixXd RandomInformation(int blocks, uint64_t seed) {
  Eigen::MatrixXd A(6 * blocks, 6 * blocks);
  CounterRng rng(seed, 1, 0);
  for (Eigen::Index i = 0; i < A.size(); ++i) A.data()[i] = rng.Normal();
  for (int b = 0; b < blocks; ++b) A.middleRows(6 * b, 6) *= rng.Uniform(0.3, 3.0);
  return A * A.transpose() + 0.1 * Eigen::MatrixXd::Identity(6 * blocks, 6 * blocks);
}

TEST(GoodGraph, EveryStepTakesTheBlockThatRaisesTheDeterminantMost) {
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    const Eigen::MatrixXd M = RandomInformation(12, seed);
    const std::vector<int> chosen = ChooseLargestLogdet(M, 6);
    ASSERT_EQ(chosen.size(), 6u);
    EXPECT_EQ(chosen.front(), 0);
    for (size_t step = 1; step < chosen.size(); ++step) {
      std::vector<int> with(chosen.begin(), chosen.begin() + static_cast<std::ptrdiff_t>(step));
      with.push_back(0);
      double best = -1e300;
      for (int other = 0; other < 12; ++other) {
        if (std::find(with.begin(), with.end() - 1, other) != with.end() - 1) continue;
        with.back() = other;
        best = std::max(best, LogDeterminant(M, with));
      }
      with.back() = chosen[step];
      EXPECT_NEAR(LogDeterminant(M, with), best, 1e-9);
    }
  }
}

class OfAMap : public testing::Test {
 protected:
  OfAMap() : world_({.num_points = 150, .keyframes_per_lap = 200}) {
    Mapper mapper = *Mapper::Create({}, {}, TestCamera());
    for (int k = 0; k < 8; ++k) mapper.Insert(world_.Make(k, mapper.map()));
    map_ = mapper.map();
  }
  MappingContext Context(int size) const {
    BackendConfig config;
    config.local_ba = LocalWindow::kGoodGraph;
    config.local_keyframes = size;
    config.covisibility_min_shared = 1;  // this world has few points
    return {config, {}, TestCamera()};
  }
  World world_;
  Map map_;
};

// The information of all poses and landmarks from numeric derivatives of the residuals, the
// landmarks then eliminated.
TEST_F(OfAMap, InformationIsTheSchurComplementOfTheWholeProblem) {
  const MappingContext context = Context(3);
  const std::vector<KeyframeId> keyframes{{8}, {6}, {5}};
  const std::vector<LandmarkId> ids = map_.SortedLandmarkIds();
  const Eigen::Index poses = 18;
  const auto n = poses + static_cast<Eigen::Index>(3 * ids.size());
  Eigen::MatrixXd H = 1e-5 * Eigen::MatrixXd::Identity(n, n);
  for (size_t l = 0; l < ids.size(); ++l) {
    const Landmark& landmark = *map_.FindLandmark(ids[l]);
    for (const Observation& o : landmark.observations) {
      const Keyframe& frame = map_.FindKeyframe(o.keyframe)->frame;
      const PixelObservation pixel =
          ObservationOf(frame.features[static_cast<size_t>(o.feature_index)], context.camera,
                        context.pyramid, (frame.T_WC.inverse() * landmark.p_W).z());
      const auto at = std::find(keyframes.begin(), keyframes.end(), o.keyframe);
      Eigen::MatrixXd J = Eigen::MatrixXd::Zero(3, n);
      const auto residual = [&](const Vector6d& d_pose, const Eigen::Vector3d& d_point) {
        const SE3 T_CW = (frame.T_WC * SE3::Exp(d_pose)).inverse();
        return ReprojectionResidual(context.camera, pixel, T_CW * (landmark.p_W + d_point));
      };
      constexpr double kStep = 1e-6;
      for (int i = 0; i < 6 && at != keyframes.end(); ++i) {
        const Vector6d d = kStep * Vector6d::Unit(i);
        const Eigen::Vector3d none = Eigen::Vector3d::Zero();
        J.col(6 * (at - keyframes.begin()) + i) =
            (residual(d, none) - residual(-d, none)) / (2 * kStep);
      }
      for (int i = 0; i < 3; ++i) {
        const Eigen::Vector3d d = kStep * Eigen::Vector3d::Unit(i);
        J.col(poses + 3 * static_cast<Eigen::Index>(l) + i) =
            (residual(Vector6d::Zero(), d) - residual(Vector6d::Zero(), -d)) / (2 * kStep);
      }
      H += J.transpose() * J;
    }
  }
  const Eigen::MatrixXd H_pl = H.topRightCorner(poses, n - poses);
  const Eigen::MatrixXd expected =
      H.topLeftCorner(poses, poses) -
      H_pl * H.bottomRightCorner(n - poses, n - poses).inverse() * H_pl.transpose();
  const Eigen::MatrixXd M = MarginalInformation(map_, context, keyframes);
  EXPECT_GT(expected.norm(), 1000);
  EXPECT_LT((M - expected).norm(), 1e-4 * expected.norm());
}

TEST_F(OfAMap, WindowHasTheNewestAndTheAskedSize) {
  for (const int size : {2, 4, 6}) {
    const std::set<KeyframeId> window = GoodGraphWindow(map_, Context(size));
    EXPECT_EQ(window.size(), static_cast<size_t>(size));
    EXPECT_TRUE(window.contains(map_.newest_keyframe()));
  }
  EXPECT_EQ(GoodGraphWindow(map_, Context(100)).size(), 8u) << "all that there are";
}

// Better determined than the keyframes that share most landmarks.
TEST_F(OfAMap, IsBetterConditionedThanTheMostCovisible) {
  const MappingContext context = Context(4);
  std::vector<KeyframeId> pool{map_.newest_keyframe()};
  for (const auto& [id, shared] : map_.Neighbours(pool.front(), 1)) pool.push_back(id);
  const Eigen::MatrixXd M = MarginalInformation(map_, context, pool);
  EXPECT_GT(LogDeterminant(M, ChooseLargestLogdet(M, 4)), LogDeterminant(M, {0, 1, 2, 3}));
}

}  // namespace
}  // namespace gw::backend
