#include "tools/sim/sim/renderer.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "common/core/check.h"

namespace gw::sim {
namespace {

constexpr int kSub = 2;         // samples a pixel in each direction
constexpr int kBandRows = 16;   // pixel rows worked on together; their samples fit the L2 cache
constexpr double kNear = 0.03;  // m
constexpr int kMaxAnisotropy = 4;

// log2 with an error below 0.09: good enough to choose a mip level, and the same everywhere.
float RoughLog2(float x) {
  const auto bits = std::bit_cast<uint32_t>(x);
  const int exponent = static_cast<int>(bits >> 23) - 127;
  const float mantissa = std::bit_cast<float>((bits & 0x7FFFFFu) | 0x3F800000u);
  return static_cast<float>(exponent) + mantissa - 1.0f;
}

}  // namespace

Renderer::Renderer(const World& world, const Pinhole& camera, WorkerPool* pool)
    : world_(world), camera_(camera), pool_(pool), scratch_(pool->num_threads()) {
  GW_CHECK(camera.width > 0 && camera.height > 0);
  for (Band& band : scratch_) {
    const size_t samples = static_cast<size_t>(camera.width) * kSub * kBandRows * kSub;
    band.w.resize(samples);
    band.id.resize(samples);
  }
}

void Renderer::Project(const SE3& T_WC) {
  visible_.clear();
  const Eigen::Matrix3d R_WC = T_WC.rotation().toRotationMatrix();
  const Eigen::Matrix3d R_CW = R_WC.transpose();
  const Eigen::Vector3d& eye = T_WC.translation();
  const double max_x = camera_.width * kSub;
  const double max_y = camera_.height * kSub;
  for (const Surface& s : world_.surfaces()) {
    const Eigen::Vector3d normal = s.Normal();
    const double height = normal.dot(eye - s.origin);  // of the eye above the surface
    if (height <= 1e-4) continue;
    // Corners in the camera; clipped at the near plane.
    Eigen::Vector3d corners[4];
    const Eigen::Vector3d origin = R_CW * (s.origin - eye);
    const Eigen::Vector3d du = R_CW * s.u * s.u_length;
    const Eigen::Vector3d dv = R_CW * s.v * s.v_length;
    corners[0] = origin;
    corners[1] = origin + du;
    corners[2] = origin + du + dv;
    corners[3] = origin + dv;
    Visible visible;
    double x_low = 1e9, x_high = -1e9, y_low = 1e9, y_high = -1e9;
    for (int i = 0; i < 4; ++i) {
      const Eigen::Vector3d& a = corners[i];
      const Eigen::Vector3d& b = corners[(i + 1) % 4];
      const auto add = [&](const Eigen::Vector3d& p) {
        const double iz = 1.0 / p.z();
        // Sample i of a pixel x lies at x + (i + 0.5) / kSub - 0.5.
        const double x = (camera_.fx * p.x() * iz + camera_.cx + 0.5) * kSub - 0.5;
        const double y = (camera_.fy * p.y() * iz + camera_.cy + 0.5) * kSub - 0.5;
        visible.vertices[visible.num_vertices++] = {static_cast<float>(x), static_cast<float>(y),
                                                    static_cast<float>(iz)};
        x_low = std::min(x_low, x);
        x_high = std::max(x_high, x);
        y_low = std::min(y_low, y);
        y_high = std::max(y_high, y);
      };
      if (a.z() >= kNear) add(a);
      if ((a.z() >= kNear) != (b.z() >= kNear)) {
        const double t = (kNear - a.z()) / (b.z() - a.z());
        Eigen::Vector3d p = a + t * (b - a);
        p.z() = kNear;
        add(p);
      }
    }
    if (visible.num_vertices < 3 || x_high < 0 || y_high < 0 || x_low > max_x || y_low > max_y) {
      continue;
    }
    visible.y_min = static_cast<float>(std::max(y_low, -1.0));
    visible.y_max = static_cast<float>(std::min(y_high, max_y));
    // The ray of a pixel is d = R_WC * (dx x + dy y + d0) with depth 1: all below is linear in it.
    const Eigen::Vector3d dx = R_WC.col(0) / camera_.fx;
    const Eigen::Vector3d dy = R_WC.col(1) / camera_.fy;
    const Eigen::Vector3d d0 = R_WC.col(2) - camera_.cx * dx - camera_.cy * dy;
    const Eigen::Vector3d rays[3] = {d0, dx, dy};
    const double eye_u = s.u.dot(eye - s.origin);
    const double eye_v = s.v.dot(eye - s.origin);
    for (int i = 0; i < 3; ++i) {
      visible.w[i] = -normal.dot(rays[i]) / height;
      visible.u[i] = eye_u * visible.w[i] + s.u.dot(rays[i]);
      visible.v[i] = eye_v * visible.w[i] + s.v.dot(rays[i]);
    }
    for (int i = 0; i < 3; ++i) {
      visible.u[i] *= s.u_texels_per_m;
      visible.v[i] *= s.v_texels_per_m;
    }
    visible.gradients = {static_cast<float>(visible.w[1]), static_cast<float>(visible.w[2]),
                         static_cast<float>(visible.u[1]), static_cast<float>(visible.u[2]),
                         static_cast<float>(visible.v[1]), static_cast<float>(visible.v[2])};
    visible.texture = &world_.textures().texture(s.texture);
    visible.u_offset = static_cast<float>(s.u_offset);
    visible.v_offset = static_cast<float>(s.v_offset);
    visible.emission = s.emission;
    visible.light = world_.light().data() + s.light_begin;
    visible.light_width = s.light_width;
    visible.light_per_u = static_cast<float>((s.light_width - 1) / (s.u_length * s.u_texels_per_m));
    visible.light_per_v =
        static_cast<float>((s.light_height - 1) / (s.v_length * s.v_texels_per_m));
    visible.light_x_max = static_cast<float>(s.light_width) - 1.001f;
    visible.light_y_max = static_cast<float>(s.light_height) - 1.001f;
    visible_.push_back(visible);
  }
}

void Renderer::Fill(const Visible& visible, int32_t id, int first_row, int rows,
                    Band* scratch) const {
  const int width = camera_.width * kSub;
  const int begin = std::max(first_row, static_cast<int>(std::ceil(visible.y_min)));
  const int end = std::min(first_row + rows - 1, static_cast<int>(std::floor(visible.y_max)));
  // Linear in sub-samples.
  const double step = 1.0 / kSub;
  const double origin = 0.5 * step - 0.5;
  for (int row = begin; row <= end; ++row) {
    const auto y = static_cast<float>(row);
    float left = 1e9f, right = -1e9f;
    for (int i = 0; i < visible.num_vertices; ++i) {
      const Vertex& a = visible.vertices[i];
      const Vertex& b = visible.vertices[i + 1 == visible.num_vertices ? 0 : i + 1];
      if ((a.y <= y) == (b.y <= y)) continue;
      const float x = a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x);
      left = std::min(left, x);
      right = std::max(right, x);
    }
    if (left > right) continue;
    const int x0 = left <= 0 ? 0 : static_cast<int>(std::ceil(std::min(left, 1e6f)));
    const int x1 = right >= static_cast<float>(width) ? width : static_cast<int>(std::ceil(right));
    const double py = origin + step * row;
    const double w_step = visible.w[1] * step;
    const auto w_row = static_cast<float>(visible.w[0] + visible.w[2] * py + visible.w[1] * origin);
    const auto w_dx = static_cast<float>(w_step);
    float* w = scratch->w.data() + static_cast<size_t>(row - first_row) * width;
    int32_t* ids = scratch->id.data() + static_cast<size_t>(row - first_row) * width;
    for (int x = x0; x < x1; ++x) {
      const float value = w_row + w_dx * static_cast<float>(x);
      const bool nearer = value > w[x];
      w[x] = nearer ? value : w[x];
      ids[x] = nearer ? id : ids[x];
    }
  }
}

float Renderer::Shade(const Visible& visible, double x, double y) const {
  // Positions in double, so that far texels do not jump; the rest in float.
  const double w = visible.w[0] + visible.w[1] * x + visible.w[2] * y;
  const double z = 1.0 / std::max(w, 1e-6);
  const double u = (visible.u[0] + visible.u[1] * x + visible.u[2] * y) * z;  // texels
  const double v = (visible.v[0] + visible.v[1] * x + visible.v[2] * y) * z;
  const auto zf = static_cast<float>(z);
  const auto uf = static_cast<float>(u);
  const auto vf = static_cast<float>(v);
  // Texels per pixel along x and along y of the image.
  const Gradients& g = visible.gradients;
  const float ux = (g.u_x - uf * g.w_x) * zf, vx = (g.v_x - vf * g.w_x) * zf;
  const float uy = (g.u_y - uf * g.w_y) * zf, vy = (g.v_y - vf * g.w_y) * zf;
  const float x2 = ux * ux + vx * vx;
  const float y2 = uy * uy + vy * vy;
  const bool along_x = x2 > y2;
  const float major2 = along_x ? x2 : y2;
  const float minor2 = std::max(along_x ? y2 : x2, 1e-6f);
  const int taps = major2 <= 2 * minor2    ? 1
                   : major2 <= 8 * minor2  ? 2
                   : major2 <= 18 * minor2 ? 3
                                           : kMaxAnisotropy;
  const float share = 1.0f / static_cast<float>(taps);
  const float footprint2 = std::max(minor2, major2 * share * share);
  const float lod = footprint2 <= 1.0f ? 0.0f : 0.5f * RoughLog2(footprint2);
  const Texture& texture = *visible.texture;
  const float tu = uf + visible.u_offset;
  const float tv = vf + visible.v_offset;
  float reflectance = 0;
  if (taps == 1) {
    reflectance = texture.Sample(tu, tv, lod);
  } else {
    // Each sample reads one level, the finer or the coarser one: together they are between the two.
    const float mu = along_x ? ux : uy;
    const float mv = along_x ? vx : vy;
    for (int i = 0; i < taps; ++i) {
      const float at = (static_cast<float>(i) + 0.5f) * share;
      reflectance += texture.SampleLevel(tu + (at - 0.5f) * mu, tv + (at - 0.5f) * mv,
                                         static_cast<int>(lod + at));
    }
    reflectance *= share;
  }
  // Baked light, bilinear.
  const float lx = std::clamp(uf * visible.light_per_u, 0.0f, visible.light_x_max);
  const float ly = std::clamp(vf * visible.light_per_v, 0.0f, visible.light_y_max);
  const int ix = static_cast<int>(lx);
  const int iy = static_cast<int>(ly);
  const float fx = lx - static_cast<float>(ix);
  const float fy = ly - static_cast<float>(iy);
  const float* light = visible.light + iy * visible.light_width + ix;
  const float* below = light + visible.light_width;
  const float top = light[0] + fx * (light[1] - light[0]);
  const float bottom = below[0] + fx * (below[1] - below[0]);
  return reflectance * (top + fy * (bottom - top) + visible.emission);
}

void Renderer::RenderBand(int band, Band* scratch, double light, RenderedImage* out) const {
  const int first = band * kBandRows;
  const int rows = std::min(kBandRows, camera_.height - first);
  const int width = camera_.width * kSub;
  std::fill(scratch->w.begin(), scratch->w.end(), 0.0f);
  std::fill(scratch->id.begin(), scratch->id.end(), -1);
  const auto band_low = static_cast<float>(first * kSub);
  const auto band_high = static_cast<float>((first + rows) * kSub);
  for (size_t i = 0; i < visible_.size(); ++i) {
    const Visible& visible = visible_[i];
    if (visible.y_max < band_low || visible.y_min > band_high) continue;
    Fill(visible, static_cast<int32_t>(i), first * kSub, rows * kSub, scratch);
  }
  const auto gain = static_cast<float>(light);
  for (int row = 0; row < rows; ++row) {
    const int32_t* top = scratch->id.data() + static_cast<size_t>(row) * kSub * width;
    const int32_t* bottom = top + width;
    const int y = first + row;
    float* radiance = out->radiance.data() + static_cast<size_t>(y) * camera_.width;
    float* inverse_depth = out->inverse_depth.data() + static_cast<size_t>(y) * camera_.width;
    for (int x = 0; x < camera_.width; ++x) {
      const int32_t ids[4] = {top[2 * x], top[2 * x + 1], bottom[2 * x], bottom[2 * x + 1]};
      if (ids[0] == ids[1] && ids[0] == ids[2] && ids[0] == ids[3]) {
        if (ids[0] < 0) {
          radiance[x] = inverse_depth[x] = 0;
          continue;
        }
        const Visible& visible = visible_[ids[0]];
        radiance[x] = gain * Shade(visible, x, y);
        inverse_depth[x] = static_cast<float>(visible.w[0] + visible.w[1] * x + visible.w[2] * y);
        continue;
      }
      float sum = 0;
      float nearest = 0;
      for (int i = 0; i < 4; ++i) {
        if (ids[i] < 0) continue;
        const double sx = x + (i % 2 == 0 ? -0.25 : 0.25);
        const double sy = y + (i < 2 ? -0.25 : 0.25);
        const Visible& visible = visible_[ids[i]];
        sum += Shade(visible, sx, sy);
        nearest = std::max(
            nearest, static_cast<float>(visible.w[0] + visible.w[1] * sx + visible.w[2] * sy));
      }
      radiance[x] = gain * 0.25f * sum;
      inverse_depth[x] = nearest;
    }
  }
}

void Renderer::Render(const SE3& T_WC, double light, RenderedImage* out) {
  out->width = camera_.width;
  out->height = camera_.height;
  out->radiance.resize(static_cast<size_t>(camera_.width) * camera_.height);
  out->inverse_depth.resize(out->radiance.size());
  Project(T_WC);
  const int bands = (camera_.height + kBandRows - 1) / kBandRows;
  pool_->Run(bands, [&](int band, int thread) { RenderBand(band, &scratch_[thread], light, out); });
}

}  // namespace gw::sim
