#include "drivers/camera/core/image_statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "common/core/random.h"
#include "drivers/camera/core/exposure_control.h"
#include "test/emulators/camera/dot_projector.h"
#include "tools/robot/floorplan/test_room.h"
#include "tools/sim/sim/camera_sensor.h"
#include "tools/sim/sim/renderer.h"

namespace gw::camera {
namespace {

namespace fs = std::filesystem;

ImageView View(const std::vector<uint8_t>& image, int width = 640, int height = 480) {
  return {image.data(), width, height, width, PixelFormat::kGray8};
}

// Renders views from random places of a room, exposed as the simulated imager does.
class Room {
 public:
  explicit Room(sim::WallStyle walls) : world_(MakeWorld(walls)), pool_(2) {}

  std::vector<uint8_t> Image(int view, bool projector, double laser = 1) {
    CounterRng rng(11, 2, static_cast<uint64_t>(view));
    const SE3 T_WB(ExpSO3({0, 0, rng.Uniform(-3.1, 3.1)}),
                   {rng.Uniform(0.8, 2.0), rng.Uniform(0.8, 4.2), 0});
    const SE3 T_BC(Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), {0.1, 0, 0.25});
    const sim::Pinhole camera;
    sim::Renderer renderer(world_, camera, &pool_);
    sim::RenderedImage scene;
    renderer.Render(T_WB * T_BC, 1.0, &scene);
    if (projector) {
      DotProjector dots;
      dots.radiance_at_1m *= laser;
      ProjectDots(dots, 5, camera.width, camera.height, scene.inverse_depth, &scene.radiance);
    }
    sim::CameraSensor sensor(camera, sim::ImagerConfig{}, &pool_);
    std::vector<uint8_t> image;
    sensor.Expose(scene, {}, {4, 1}, {}, static_cast<uint64_t>(view), &image);
    return image;
  }

 private:
  static sim::World MakeWorld(sim::WallStyle walls) {
    sim::WorldConfig config;
    config.walls = walls;
    return {floorplan::RoomForTest(), config, {1, 1}, {}, 3};
  }
  sim::World world_;
  sim::WorkerPool pool_;
};

struct Tally {
  int lit = 0, images = 0;
  double least_covered = 1, most_covered = 0, least_ratio = 1e9, most_ratio = 0;
  double least_density = 1e9, most_density = 0;

  void Add(const DotPattern& dots) {
    const double ratio = static_cast<double>(dots.bright) / std::max(dots.dark, 1);
    ++images;
    lit += dots.lit() ? 1 : 0;
    least_covered = std::min(least_covered, dots.covered);
    most_covered = std::max(most_covered, dots.covered);
    least_ratio = std::min(least_ratio, ratio);
    most_ratio = std::max(most_ratio, ratio);
    least_density = std::min(least_density, dots.density);
    most_density = std::max(most_density, dots.density);
  }
  void Print(const char* name) const {
    std::printf(
        "%-28s %3d of %3d lit, covered %.2f - %.2f, density %.1f - %.1f, bright/dark %.1f - %.1f\n",
        name, lit, images, least_covered, most_covered, least_density, most_density, least_ratio,
        most_ratio);
  }
};

class RenderedDots : public testing::TestWithParam<sim::WallStyle> {};

TEST_P(RenderedDots, LitIsToldFromUnlit) {
  Room room(GetParam());
  Tally lit, weak, unlit;
  for (int view = 0; view < 12; ++view) {
    lit.Add(FindDots(View(room.Image(view, true))));
    weak.Add(FindDots(View(room.Image(view, true, 0.5))));
    unlit.Add(FindDots(View(room.Image(view, false))));
  }
  lit.Print("lit, 150 mW");
  weak.Print("lit, 75 mW");
  unlit.Print("unlit");
  // Dots may hide in a busy pattern: one image of twelve is allowed. The driver looks at many.
  EXPECT_GE(lit.lit, lit.images - 1);
  EXPECT_GE(weak.lit, 5);
  EXPECT_EQ(unlit.lit, 0);
}

INSTANTIATE_TEST_SUITE_P(Walls, RenderedDots,
                         testing::Values(sim::WallStyle::kTextured, sim::WallStyle::kBlank,
                                         sim::WallStyle::kMixed, sim::WallStyle::kFaint,
                                         sim::WallStyle::kRepetitive));

// The images are of cameras without any projector: indoor, laboratory, street, photographs.
TEST(RecordedImages, HaveNoDots) {
  const fs::path data = fs::path(GW_SOURCE_DIR) / "../shared/data";
  if (!fs::exists(data)) GTEST_SKIP() << data << " is not there";
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(data)) {
    const std::string name = entry.path().string();
    const bool depth = name.find("/depth/") != std::string::npos;
    const std::string extension = entry.path().extension();
    if (!depth && (extension == ".png" || extension == ".jpg")) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  Tally all;
  for (size_t i = 0; i < files.size(); i += 5) {
    const cv::Mat image = cv::imread(files[i].string(), cv::IMREAD_GRAYSCALE);
    if (image.cols < 320 || image.rows < 240) continue;
    const DotPattern dots = FindDots(
        {image.data, image.cols, image.rows, static_cast<int>(image.step), PixelFormat::kGray8});
    all.Add(dots);
    EXPECT_FALSE(dots.lit()) << files[i] << ": " << dots.bright << " bright, " << dots.dark
                             << " dark, " << dots.covered << " covered, density " << dots.density;
  }
  all.Print("recordings");
  EXPECT_GT(all.images, 100);
}

TEST(DotPattern, FlatAndNoisyImagesHaveNone) {
  std::vector<uint8_t> image(640 * 480, 120);
  EXPECT_FALSE(FindDots(View(image)).lit());
  for (const double sigma : {2.0, 5.0, 20.0}) {
    for (size_t i = 0; i < image.size(); ++i) {
      CounterRng rng(1, 1, i);
      image[i] = static_cast<uint8_t>(std::clamp(120 + sigma * rng.Normal(), 0., 255.));
    }
    EXPECT_FALSE(FindDots(View(image)).lit()) << sigma;
  }
}

TEST(Brightness, PercentilesAndMean) {
  std::vector<uint8_t> image(640 * 480, 20);
  Brightness dark = MeasureBrightness(View(image));
  EXPECT_EQ(dark.mean, 20);
  EXPECT_EQ(dark.percentile_95, 20);
  EXPECT_TRUE(dark.under_exposed());
  // A lamp in the dark is not light to see by, but a tenth of the image is.
  for (size_t i = 0; i < image.size() / 50; ++i) image[i] = 255;
  EXPECT_TRUE(MeasureBrightness(View(image)).under_exposed());
  EXPECT_NEAR(MeasureBrightness(View(image)).saturated, 0.02, 0.005);
  for (size_t i = 0; i < image.size() / 10; ++i) image[i] = 120;
  EXPECT_FALSE(MeasureBrightness(View(image)).under_exposed());
}

TEST(Brightness, RoomInItsOwnLightAndInTheDark) {
  Room room(sim::WallStyle::kTextured);
  EXPECT_FALSE(MeasureBrightness(View(room.Image(1, false))).under_exposed());
}

// The imager gives a grey level by exposure, gain and light, and reacts three frames late.
TEST(ExposureControl, SettlesAtTheTargetAndKeepsTheCap) {
  struct Light {
    double grey_per_us;
    uint32_t exposure_us;
    int32_t gain;
  };
  // Bright light gives a short exposure, dim light the cap and gain, the dark both at their limits.
  for (const Light& light :
       {Light{0.1, 950, 16}, Light{0.004, 8000, 48}, Light{0.0001, 8000, 248}}) {
    ExposureControl control({});
    std::vector<ExposureSetting> past(4, control.setting());
    double grey = 0;
    for (int frame = 0; frame < 300; ++frame) {
      const ExposureSetting& seen = past[past.size() - 4];
      grey = std::min(255., light.grey_per_us * seen.exposure_us * seen.gain / 16);
      control.Observe(grey);
      past.push_back(control.setting());
      EXPECT_LE(control.setting().exposure_us, 8000U);
    }
    EXPECT_NEAR(control.setting().exposure_us, light.exposure_us, 0.12 * light.exposure_us);
    EXPECT_NEAR(control.setting().gain, light.gain, 0.12 * light.gain);
    if (light.gain < 248) {
      EXPECT_NEAR(grey, ExposureControl::kTargetGrey, 0.12 * ExposureControl::kTargetGrey);
    }
    // A settled control changes nothing more.
    const ExposureSetting settled = control.setting();
    for (int frame = 0; frame < 20; ++frame) control.Observe(grey);
    EXPECT_EQ(control.setting(), settled);
  }
}

}  // namespace
}  // namespace gw::camera
