#include "tools/sim/sim/renderer.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "common/core/random.h"
#include "tools/robot/floorplan/test_room.h"
#include "tools/sim/sim/camera_sensor.h"

namespace gw::sim {
namespace {

const SE3 kCameraOnBody(Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), {0.1, 0, 0.25});

World TexturedRoom() {
  WorldConfig config;
  config.walls = WallStyle::kTextured;
  return World(floorplan::RoomForTest(), config, {1, 1}, {}, 3);
}

// Standing somewhere in the room, not in the pillar.
SE3 RandomView(CounterRng* rng) {
  Eigen::Vector2d p;
  do {
    p = {rng->Uniform(0.8, 5.2), rng->Uniform(0.8, 4.2)};
  } while ((p - Eigen::Vector2d(2.9, 2.5)).norm() < 0.8);
  const SE3 T_WB(ExpSO3({0, 0, rng->Uniform(-3.1, 3.1)}), {p.x(), p.y(), 0});
  return T_WB * kCameraOnBody;
}

float At(const RenderedImage& image, const std::vector<float>& values, int x, int y) {
  return values[static_cast<size_t>(y) * image.width + x];
}

// Inverse depth of the nearest surface by the obvious way: every surface, one ray.
double CastRay(const World& world, const Pinhole& camera, const SE3& T_WC, double x, double y) {
  const Eigen::Vector3d ray = T_WC.rotation() * Eigen::Vector3d((x - camera.cx) / camera.fx,
                                                                (y - camera.cy) / camera.fy, 1);
  double nearest = 0;
  for (const Surface& s : world.surfaces()) {
    const Eigen::Vector3d n = s.Normal();
    const double height = n.dot(T_WC.translation() - s.origin);
    const double approach = -n.dot(ray);
    if (height <= 1e-4 || approach <= 0) continue;
    const double z = height / approach;
    const Eigen::Vector3d p = T_WC.translation() + z * ray - s.origin;
    const double a = s.u.dot(p), b = s.v.dot(p);
    if (a < 0 || b < 0 || a > s.u_length || b > s.v_length) continue;
    nearest = std::max(nearest, 1 / z);
  }
  return nearest;
}

TEST(Renderer, DepthIsThatOfARayThroughThePixel) {
  const World world = TexturedRoom();
  WorkerPool pool(2);
  const Pinhole camera;
  Renderer renderer(world, camera, &pool);
  RenderedImage image;
  int wrong = 0, checked = 0;
  for (uint64_t view = 0; view < 20; ++view) {
    CounterRng rng(1, 1, view);
    const SE3 T_WC = RandomView(&rng);
    renderer.Render(T_WC, 1, &image);
    for (int i = 0; i < 100; ++i) {
      const int x = static_cast<int>(rng.Below(640)), y = static_cast<int>(rng.Below(480));
      const double truth = CastRay(world, camera, T_WC, x, y);
      ++checked;
      // On an outline the pixel holds the nearest of its four samples.
      if (std::abs(At(image, image.inverse_depth, x, y) - truth) > 1e-4 * truth) ++wrong;
    }
  }
  EXPECT_LT(wrong, checked / 50);
}

TEST(Renderer, NoPixelIsEmptyInAClosedRoom) {
  const World world = TexturedRoom();
  WorkerPool pool(1);
  Renderer renderer(world, Pinhole{}, &pool);
  RenderedImage image;
  for (uint64_t view = 0; view < 10; ++view) {
    CounterRng rng(2, 1, view);
    renderer.Render(RandomView(&rng), 1, &image);
    for (const float w : image.inverse_depth) ASSERT_GT(w, 0);
    renderer.Render(RandomView(&rng), 0, &image);
    for (const float r : image.radiance) ASSERT_EQ(r, 0);
  }
}

// Vertex of the parabola through three costs, one step apart.
double Vertex(double before, double at, double after) {
  const double bend = before - 2 * at + after;
  return bend > 0 ? 0.5 * (before - after) / bend : 0.0;
}

// Column at which the patch around (x, y) of `left` is found in the same row of `right`, near
// `guess`: least squares over whole pixels, then a parabola. False at the border of the search.
bool FindInRow(const std::vector<float>& left, const std::vector<float>& right, int x, int y,
               double guess, double* found) {
  constexpr int kWidth = 640, kHeight = 480, kHalf = 5, kSearch = 4;
  const int middle = static_cast<int>(std::lround(guess));
  if (x < kHalf || y < kHalf || x + kHalf >= kWidth || y + kHalf >= kHeight ||
      middle - kSearch - 1 < kHalf || middle + kSearch + 1 + kHalf >= kWidth) {
    return false;
  }
  const auto cost = [&](int offset) {
    double sum = 0;
    for (int dy = -kHalf; dy <= kHalf; ++dy) {
      const float* a = &left[static_cast<size_t>(y + dy) * kWidth + x];
      const float* b = &right[static_cast<size_t>(y + dy) * kWidth + middle + offset];
      for (int dx = -kHalf; dx <= kHalf; ++dx) sum += std::pow(a[dx] - b[dx], 2);
    }
    return sum;
  };
  int best = 0;
  for (int offset = -kSearch; offset <= kSearch; ++offset) {
    if (cost(offset) < cost(best)) best = offset;
  }
  if (std::abs(best) == kSearch) return false;
  *found = middle + best + Vertex(cost(best - 1), cost(best), cost(best + 1));
  return true;
}

bool SmoothDepth(const RenderedImage& image, int x, int y) {
  const float w = At(image, image.inverse_depth, x, y);
  for (const int d : {-7, 7}) {
    if (x + d < 0 || y + d < 0 || x + d >= image.width || y + d >= image.height) return false;
    if (std::abs(At(image, image.inverse_depth, x + d, y) - w) > 0.03f * w) return false;
    if (std::abs(At(image, image.inverse_depth, x, y + d) - w) > 0.03f * w) return false;
  }
  return true;
}

TEST(Renderer, DisparityOfAStereoPairAgreesWithDepthOnTexturedPixels) {
  const World world = TexturedRoom();
  WorkerPool pool(2);
  const Pinhole camera;
  constexpr double kBaseline = 0.05;
  Renderer renderer(world, camera, &pool);
  CameraSensor left_eye(camera, {}, &pool), right_eye(camera, {}, &pool);
  RenderedImage left, right;
  std::vector<uint8_t> left_grey, right_grey;
  double sum2 = 0;
  int count = 0, outliers = 0;
  for (uint64_t view = 0; view < 20; ++view) {
    CounterRng rng(4, 1, view);
    const SE3 T_WC = RandomView(&rng);
    renderer.Render(T_WC, 1, &left);
    renderer.Render(T_WC * SE3(Eigen::Quaterniond::Identity(), {kBaseline, 0, 0}), 1, &right);
    left_eye.Expose(left, {}, {4, 1}, {}, 2 * view, &left_grey);
    right_eye.Expose(right, {}, {4, 1}, {}, 2 * view + 1, &right_grey);
    const std::vector<float> l(left_grey.begin(), left_grey.end());
    const std::vector<float> r(right_grey.begin(), right_grey.end());
    for (int i = 0; i < 600; ++i) {
      const int x = static_cast<int>(rng.Below(640)), y = static_cast<int>(rng.Below(480));
      if (!SmoothDepth(left, x, y)) continue;
      // Textured: gradients well above the noise.
      double texture = 0;
      for (int dy = -4; dy <= 4 && y > 5 && y < 474 && x > 6 && x < 633; ++dy) {
        for (int dx = -4; dx <= 4; ++dx) {
          texture += std::abs(At(left, l, x + dx + 1, y + dy) - At(left, l, x + dx - 1, y + dy));
        }
      }
      if (texture < 81 * 6) continue;
      const double disparity = camera.fx * kBaseline * At(left, left.inverse_depth, x, y);
      double found = 0;
      if (!FindInRow(l, r, x, y, x - disparity, &found)) continue;
      const double error = x - found - disparity;
      if (std::abs(error) > 1.5) {  // repeated structure, as real matchers have it
        ++outliers;
        continue;
      }
      sum2 += error * error;
      ++count;
    }
  }
  ASSERT_GT(count, 500);
  const double rms = std::sqrt(sum2 / count);
  RecordProperty("rms_px", std::to_string(rms));
  std::printf("disparity against depth: RMS %.3f px over %d pixels, %d outliers\n", rms, count,
              outliers);
  EXPECT_LT(rms, 0.25);
  EXPECT_LT(outliers, count / 50);
}

// How far from its predicted place the patch around (x, y) of `a` is found in `b`. Every pixel is
// carried over with its own depth, so that perspective is no error. False without texture.
bool FindWarpedPatch(const Pinhole& camera, const RenderedImage& a, const RenderedImage& b,
                     const SE3& T_BA, int x, int y, Eigen::Vector2d* offset) {
  constexpr int kHalf = 5, kSearch = 4;
  constexpr double kStep = 0.5;  // px
  struct Pixel {
    double value, x, y;
  };
  std::vector<Pixel> pixels;
  double gradient_x = 0, gradient_y = 0;
  for (int dy = -kHalf; dy <= kHalf; ++dy) {
    for (int dx = -kHalf; dx <= kHalf; ++dx) {
      const double z = 1.0 / static_cast<double>(At(a, a.inverse_depth, x + dx, y + dy));
      const Eigen::Vector3d p = T_BA * Eigen::Vector3d((x + dx - camera.cx) / camera.fx * z,
                                                       (y + dy - camera.cy) / camera.fy * z, z);
      const double bx = camera.fx * p.x() / p.z() + camera.cx;
      const double by = camera.fy * p.y() / p.z() + camera.cy;
      if (p.z() < 0.2 || bx < 4 || by < 4 || bx > 634 || by > 474) return false;
      pixels.push_back({static_cast<double>(At(a, a.radiance, x + dx, y + dy)), bx, by});
      gradient_x += std::pow(
          At(a, a.radiance, x + dx + 1, y + dy) - At(a, a.radiance, x + dx - 1, y + dy), 2);
      gradient_y += std::pow(
          At(a, a.radiance, x + dx, y + dy + 1) - At(a, a.radiance, x + dx, y + dy - 1), 2);
    }
  }
  if (gradient_x < 0.1 || gradient_y < 0.1) return false;
  const auto cost = [&](int ox, int oy) {
    double sum = 0;
    for (const Pixel& pixel : pixels) {
      const double px = pixel.x + ox * kStep, py = pixel.y + oy * kStep;
      const int ix = static_cast<int>(px), iy = static_cast<int>(py);
      const double fx = px - ix, fy = py - iy;
      const double value =
          (1 - fy) * ((1 - fx) * At(b, b.radiance, ix, iy) + fx * At(b, b.radiance, ix + 1, iy)) +
          fy * ((1 - fx) * At(b, b.radiance, ix, iy + 1) + fx * At(b, b.radiance, ix + 1, iy + 1));
      sum += std::pow(value - pixel.value, 2);
    }
    return sum;
  };
  double best = 1e30;
  int best_x = 0, best_y = 0;
  for (int oy = -kSearch; oy <= kSearch; ++oy) {
    for (int ox = -kSearch; ox <= kSearch; ++ox) {
      const double c = cost(ox, oy);
      if (c >= best) continue;
      best = c;
      best_x = ox;
      best_y = oy;
    }
  }
  if (std::abs(best_x) == kSearch || std::abs(best_y) == kSearch) return false;
  *offset = kStep * Eigen::Vector2d(
                        best_x + Vertex(cost(best_x - 1, best_y), best, cost(best_x + 1, best_y)),
                        best_y + Vertex(cost(best_x, best_y - 1), best, cost(best_x, best_y + 1)));
  return true;
}

TEST(Renderer, RelativePoseFromDepthAndPixelsEqualsTruth) {
  const World world = TexturedRoom();
  WorkerPool pool(2);
  const Pinhole camera;
  Renderer renderer(world, camera, &pool);
  RenderedImage a, b;
  double worst_m = 0, worst_deg = 0;
  int solved = 0;
  for (uint64_t pair = 0; pair < 200; ++pair) {
    CounterRng rng(5, 1, pair);
    const SE3 T_WA = RandomView(&rng);
    Vector6d motion;
    for (int i = 0; i < 3; ++i) motion[i] = rng.Uniform(-0.06, 0.06);
    for (int i = 3; i < 6; ++i) motion[i] = rng.Uniform(-0.05, 0.05);
    const SE3 T_AB = SE3::Exp(motion);
    renderer.Render(T_WA, 1, &a);
    renderer.Render(T_WA * T_AB, 1, &b);
    std::vector<std::pair<Eigen::Vector3d, Eigen::Vector2d>> matches;
    for (int i = 0; i < 4000 && matches.size() < 300; ++i) {
      const int x = static_cast<int>(rng.Below(640)), y = static_cast<int>(rng.Below(480));
      if (!SmoothDepth(a, x, y)) continue;
      const double z = 1.0 / static_cast<double>(At(a, a.inverse_depth, x, y));
      const Eigen::Vector3d p_A((x - camera.cx) / camera.fx * z, (y - camera.cy) / camera.fy * z,
                                z);
      const Eigen::Vector3d p_B = T_AB.inverse() * p_A;
      const Eigen::Vector2d predicted(camera.fx * p_B.x() / p_B.z() + camera.cx,
                                      camera.fy * p_B.y() / p_B.z() + camera.cy);
      Eigen::Vector2d offset;
      if (FindWarpedPatch(camera, a, b, T_AB.inverse(), x, y, &offset)) {
        matches.emplace_back(p_A, predicted + offset);
      }
    }
    if (matches.size() < 80) continue;  // looks at something without texture
    ++solved;
    // Gauss-Newton with a robust weight, from a start that is not the truth.
    SE3 T_BA = SE3::Exp(-motion * 0.5);
    for (int iteration = 0; iteration < 12; ++iteration) {
      Matrix6d H = Matrix6d::Zero();
      Vector6d g = Vector6d::Zero();
      for (const auto& [p_A, pixel] : matches) {
        const Eigen::Vector3d p = T_BA * p_A;
        const double iz = 1 / p.z();
        const Eigen::Vector2d r(camera.fx * p.x() * iz + camera.cx - pixel.x(),
                                camera.fy * p.y() * iz + camera.cy - pixel.y());
        Eigen::Matrix<double, 2, 3> projection;
        projection << camera.fx * iz, 0, -camera.fx * p.x() * iz * iz, 0, camera.fy * iz,
            -camera.fy * p.y() * iz * iz;
        Eigen::Matrix<double, 3, 6> move;
        move.leftCols<3>() = T_BA.rotation().toRotationMatrix();
        move.rightCols<3>() = -T_BA.rotation().toRotationMatrix() * Skew(p_A);
        const Eigen::Matrix<double, 2, 6> J = projection * move;
        const double scale = iteration < 3 ? 3.0 : 0.3;
        const double weight = 1 / (1 + r.squaredNorm() / (scale * scale));
        H += weight * J.transpose() * J;
        g += weight * J.transpose() * r;
      }
      T_BA = T_BA * SE3::Exp(-H.ldlt().solve(g));
    }
    const Vector6d error = (T_AB * T_BA).Log();
    worst_m = std::max(worst_m, error.head<3>().norm());
    worst_deg = std::max(worst_deg, error.tail<3>().norm() * 180 / 3.141592653589793);
  }
  std::printf("relative pose: worst %.2f mm, %.3f deg of %d pairs\n", worst_m * 1e3, worst_deg,
              solved);
  EXPECT_GE(solved, 150);
  EXPECT_LT(worst_m, 0.005);
  EXPECT_LT(worst_deg, 0.1);
}

}  // namespace
}  // namespace gw::sim
