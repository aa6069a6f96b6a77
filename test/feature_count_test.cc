// Tests how much the front-end's detector finds in what gw-sim renders: a textured office, blank
// walls, the dark. A wall that a scenario calls blank must give as little as a painted one.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/core/random.h"
#include "frontend/core/features/orb_extractor.h"
#include "tools/sim/sim/renderer.h"
#include "tools/sim/sim/scenario.h"

namespace gw {
namespace {

constexpr int kViews = 60;
constexpr double kClearance = 0.6;  // distance of a view from the nearest obstacle, m
const SE3 kCameraOnBody(Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), {0.1, 0, 0.25});

struct View {
  Eigen::Vector2d position;
  double yaw = 0;
};

class SimulatedPlace {
 public:
  explicit SimulatedPlace(const std::string& name)
      : scenario_(sim::LoadScenario(GW_SOURCE_DIR "/config/scenarios/" + name + ".yaml").value()),
        map_(floorplan::LoadFloorMap(scenario_.map).value()),
        world_(map_, scenario_.world, start(), {}, static_cast<uint64_t>(scenario_.seed)),
        distance_(floorplan::DistanceToOccupied(world_.obstacles(), 5.0)),
        reachable_(floorplan::ReachableCells(map_, start())),
        renderer_(world_, scenario_.pinhole, &pool_),
        eye_(scenario_.pinhole, scenario_.imager, &pool_),
        extractor_(
            frontend::OrbExtractor::Create({}, scenario_.pinhole.width, scenario_.pinhole.height)
                .value()) {}

  // A view from anywhere in the rooms, in any direction.
  View Anywhere(CounterRng* rng) const {
    const double half_turn = std::numbers::pi;
    for (;;) {
      const Eigen::Vector2i cell(static_cast<int>(rng->Below(static_cast<uint32_t>(map_.width))),
                                 static_cast<int>(rng->Below(static_cast<uint32_t>(map_.height))));
      const int index = map_.index(cell.x(), cell.y());
      if (reachable_[index] == 0 || distance_[index] < kClearance) continue;
      return {map_.CentreOf(cell.x(), cell.y()), rng->Uniform(-half_turn, half_turn)};
    }
  }

  // A view in a blank region, within 20 degrees of facing the nearest wall.
  View BlankWall(CounterRng* rng) const {
    for (;;) {
      View view = Anywhere(rng);
      const auto& blank = scenario_.world.blank_regions;
      if (std::none_of(blank.begin(), blank.end(),
                       [&](const auto& region) { return region.Contains(view.position); })) {
        continue;
      }
      const auto near = [&](double dx, double dy) {
        return floorplan::DistanceAt(world_.obstacles(), distance_,
                                     view.position + Eigen::Vector2d(dx, dy));
      };
      const Eigen::Vector2d to_wall(near(-0.1, 0) - near(0.1, 0), near(0, -0.1) - near(0, 0.1));
      if (to_wall.norm() < 0.1) continue;  // this place is as far from two walls
      view.yaw = std::atan2(to_wall.y(), to_wall.x()) + rng->Uniform(-0.35, 0.35);
      return view;
    }
  }

  int CountFeatures(const View& view, double light, uint64_t noise_key) {
    const SE3 T_WB(ExpSO3({0, 0, view.yaw}), {view.position.x(), view.position.y(), 0});
    sim::RenderedImage scene;
    renderer_.Render(T_WB * kCameraOnBody, light, &scene);
    sim::AutoExposure exposure(scenario_.imager);
    std::vector<uint8_t> image;
    for (int i = 0; i < 20; ++i) {  // the exposure settles in these images
      eye_.Expose(scene, {}, exposure.exposure(), {}, noise_key, &image);
      exposure.Observe(sim::MeanGrey(image));
    }
    std::vector<frontend::OrbKeypoint> keypoints;
    std::vector<Descriptor> descriptors;
    extractor_.Extract({image.data(), scene.width, scene.height, scene.width, PixelFormat::kGray8},
                       nullptr, &keypoints, &descriptors);
    return static_cast<int>(keypoints.size());
  }

 private:
  Eigen::Vector2d start() const { return scenario_.waypoints.front().position; }

  sim::Scenario scenario_;
  floorplan::FloorMap map_;
  sim::World world_;
  std::vector<float> distance_;
  std::vector<uint8_t> reachable_;
  sim::WorkerPool pool_{2};
  sim::Renderer renderer_;
  sim::CameraSensor eye_;
  frontend::OrbExtractor extractor_;
};

struct Spread {
  int least = 0, median = 0, most = 0;
};

template <typename Count>
Spread Over(const char* what, const Count& count) {
  std::vector<int> counts;
  for (uint64_t i = 0; i < kViews; ++i) {
    CounterRng rng(9, 1, i);
    counts.push_back(count(&rng, i));
  }
  std::sort(counts.begin(), counts.end());
  const Spread out{counts.front(), counts[kViews / 2], counts.back()};
  std::printf("%s: %d to %d features, median %d\n", what, out.least, out.most, out.median);
  return out;
}

TEST(FeatureCount, ATexturedOfficeHasPlenty) {
  SimulatedPlace office("easy_office");
  const Spread counts = Over("office", [&](CounterRng* rng, uint64_t i) {
    return office.CountFeatures(office.Anywhere(rng), 1, i);
  });
  EXPECT_GE(counts.median, 700);
}

TEST(FeatureCount, ABlankWallHasFew) {
  SimulatedPlace corridor("blank_corridor");
  const Spread counts = Over("blank walls", [&](CounterRng* rng, uint64_t i) {
    return corridor.CountFeatures(corridor.BlankWall(rng), 1, i);
  });
  EXPECT_LE(counts.most, 150);
}

TEST(FeatureCount, TheDarkHasNone) {
  SimulatedPlace office("easy_office");
  const Spread counts = Over("dark", [&](CounterRng* rng, uint64_t i) {
    return office.CountFeatures(office.Anywhere(rng), 0, i);
  });
  EXPECT_EQ(counts.most, 0);
}

}  // namespace
}  // namespace gw
