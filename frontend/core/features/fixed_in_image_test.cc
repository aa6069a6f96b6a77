#include "frontend/core/features/fixed_in_image.h"

#include <gtest/gtest.h>

#include "common/core/random.h"
#include "frontend/core/features/test_camera.h"

namespace gw::frontend {
namespace {

RectifiedCamera Camera() {
  return TestCamera(10);
}

// A camera that drives along its axis past `world` points, with `dots` that stay where they are in
// the image, 15 images a second. Features are found with 0.5 px; ten bits of each descriptor
// change.
class Drive {
 public:
  Drive(int world, int dots) : world_(world), dots_(dots) {}

  // The camera truly moves by `moves`, dead reckoning tells `tells` of each step.
  void Go(int images, const SE3& moves, const std::optional<SE3>& tells) {
    for (int k = 0; k < images; ++k, utime_ = utime_ + Milliseconds(66)) {
      T_WC_ = T_WC_ * moves;
      frame_ = See();
      std::optional<CameraStep> step;
      if (tells) {
        step =
            CameraStep{*tells, Vector6d::Constant(1e-7), Vector6d::Constant(2e-4), sees_, refuted_};
      }
      fixed_.Observe(utime_, frame_, step);
    }
  }

  // Features that are kept, of the world and of the dots.
  std::pair<int, int> Kept() const {
    const FeatureFrame kept = fixed_.Without(frame_);
    std::pair<int, int> out;
    for (const Feature& f : kept.features) ++(f.angle > 0 ? out.second : out.first);
    return out;
  }
  FixedInImage& fixed() { return fixed_; }
  // Vision that carries the pose says this of every step from now on.
  void Sees(const SE3& T_ab) { sees_ = T_ab; }
  // Vision contradicts dead reckoning from now on.
  void Refutes() { refuted_ = true; }
  Utime utime() const { return utime_; }

 private:
  FeatureFrame See() const {
    FeatureFrame frame;
    CounterRng points(7, 1, 0);
    CounterRng chance(7, 2, static_cast<uint64_t>(utime_.us));
    const auto add = [&](const Eigen::Vector2d& uv, double depth, bool dot) {
      Descriptor descriptor;
      for (uint64_t& word : descriptor) word = points.NextU64();
      for (int bit = 0; bit < 10; ++bit) descriptor[chance.Below(4)] ^= 1ULL << chance.Below(64);
      const double du = 0.5 * chance.Normal();
      const double dv = 0.5 * chance.Normal();
      if (!(depth > 0.3) || !Camera().InImage(uv)) return;
      Feature f;
      f.u = static_cast<float>(uv.x() + du);
      f.v = static_cast<float>(uv.y() + dv);
      f.depth = static_cast<float>(depth);
      f.angle = dot ? 1 : 0;  // marks it for the test
      frame.features.push_back(f);
      frame.descriptors.push_back(descriptor);
    };
    for (int i = 0; i < world_; ++i) {
      const Eigen::Vector3d p_W(points.Uniform(-3, 3), points.Uniform(-2, 2), points.Uniform(1, 9));
      const Eigen::Vector3d p_C = T_WC_.inverse() * p_W;
      add(p_C.z() > 0.1 ? Camera().Project(p_C) : Eigen::Vector2d(-1, -1), p_C.z(), false);
    }
    for (int i = 0; i < dots_; ++i) {
      add({points.Uniform(5, 635), points.Uniform(5, 475)}, 2.5, true);
    }
    frame.num_detected = static_cast<int>(frame.features.size());
    return frame;
  }

  int world_, dots_;
  FixedInImage fixed_{Camera(), Pyramid(1.2, 8)};
  FeatureFrame frame_;
  Utime utime_{1'000'000};
  SE3 T_WC_;
  std::optional<SE3> sees_;
  bool refuted_ = false;
};

const SE3 kStep(Eigen::Quaterniond::Identity(), {0, 0, 0.03});  // 0.45 m/s
const SE3 kStill;

TEST(FixedInImage, LeavesAWorldThatMovesAlone) {
  Drive drive(600, 0);
  drive.Go(20, kStill, kStill);
  drive.Go(60, kStep, kStep);
  EXPECT_FALSE(drive.fixed().Prevails());
  EXPECT_LT(drive.Kept().first, 600);  // some are behind the camera by now
  EXPECT_GT(drive.Kept().first, 200);
}

TEST(FixedInImage, FindsDotsOnABlankWall) {
  Drive drive(0, 400);
  drive.Go(20, kStill, kStill);
  EXPECT_FALSE(drive.fixed().any());  // as long as nothing moves
  const Utime begin = drive.utime();
  drive.Go(20, kStep, kStep);
  EXPECT_TRUE(drive.fixed().Prevails());
  EXPECT_EQ(drive.Kept(), std::pair(0, 0));
  EXPECT_LT(drive.fixed().since(), begin + Milliseconds(300));
}

TEST(FixedInImage, KeepsTheWorldBetweenTheDots) {
  Drive drive(300, 400);
  drive.Go(45, kStep, kStep);
  const auto [world, dots] = drive.Kept();
  EXPECT_GT(world, 40);
  EXPECT_LT(dots, 5);
}

TEST(FixedInImage, DoesNotTakeWheelsThatSlipForMotion) {
  Drive drive(600, 0);
  drive.Go(40, kStep, kStep);
  const int before = drive.Kept().first;
  drive.Go(30, kStill, kStep);  // it stands, the wheels turn
  EXPECT_FALSE(drive.fixed().Prevails());
  EXPECT_GT(drive.Kept().first, before * 9 / 10);
}

// What moves, but not as dead reckoning says, is no evidence against the world.
TEST(FixedInImage, DecidesNothingFromDeadReckoningThatIsWrong) {
  for (const SE3& wrong : {SE3(Eigen::Quaterniond::Identity(), {0.03, 0, 0}),
                           SE3(Eigen::Quaterniond::Identity(), {0, 0, -0.03}),
                           SE3(Eigen::Quaterniond::Identity(), {0, 0, 0.06})}) {
    Drive drive(600, 0);
    drive.Go(60, kStep, wrong);
    EXPECT_FALSE(drive.fixed().Prevails()) << wrong.translation().transpose();
  }
}

// The same, where some of the world repeats itself at the same place of the image: vision that
// moves with the rest of it speaks for the world.
TEST(FixedInImage, AsksVisionWhereDeadReckoningIsWrong) {
  const SE3 backwards(Eigen::Quaterniond::Identity(), {0, 0, -0.03});
  Drive drive(600, 60);
  drive.Sees(kStep);
  drive.Go(60, kStep, backwards);
  EXPECT_FALSE(drive.fixed().Prevails());
  Drive captured(0, 400);
  captured.Sees(kStill);
  captured.Go(60, kStep, kStep);
  EXPECT_TRUE(captured.fixed().Prevails());
}

// Vision that is drawn along by the dots moves a little: enough to explain each of them within a
// pixel or two. The world between them says whose motion it is.
TEST(FixedInImage, IsNotMisledByVisionThatIsDrawnAlong) {
  const SE3 drawn(Eigen::Quaterniond::Identity(), {0, 0, 0.004});
  for (const bool refuted : {false, true}) {
    Drive drive(300, 200);
    drive.Sees(drawn);
    if (refuted) drive.Refutes();
    drive.Go(45, kStep, kStep);
    EXPECT_TRUE(drive.fixed().Prevails()) << refuted;
    const auto [world, dots] = drive.Kept();
    EXPECT_GT(world, 40) << refuted;
    EXPECT_LT(dots, 5) << refuted;
  }
}

// Dead reckoning that vision refutes needs features that move as it says.
TEST(FixedInImage, DecidesNothingFromRefutedDeadReckoningWithoutWitnesses) {
  Drive drive(0, 400);
  drive.Sees(kStill);
  drive.Refutes();
  drive.Go(60, kStep, kStep);
  EXPECT_FALSE(drive.fixed().any());
}

// A share that is outvoted by the rest is left out feature by feature.
TEST(FixedInImage, KeepsWhatIsNotKnownWhereLittleIsFixed) {
  Drive drive(600, 30);
  drive.Go(45, kStep, kStep);
  EXPECT_TRUE(drive.fixed().any());
  EXPECT_FALSE(drive.fixed().Prevails());
  EXPECT_LT(drive.Kept().second, 8);
}

// Dead reckoning that comes 150 ms late, or early, at every start and stop.
TEST(FixedInImage, BearsDeadReckoningThatIsLate) {
  Drive drive(600, 0);
  for (int k = 0; k < 5; ++k) {
    drive.Go(2, kStill, kStep);
    drive.Go(13, kStep, kStep);
    drive.Go(2, kStep, kStill);
    drive.Go(10, kStill, kStill);
    EXPECT_FALSE(drive.fixed().Prevails()) << k;
  }
}

TEST(FixedInImage, SaysNothingWithoutDeadReckoning) {
  Drive drive(0, 400);
  drive.Go(60, kStep, std::nullopt);
  EXPECT_FALSE(drive.fixed().any());
}

}  // namespace
}  // namespace gw::frontend
