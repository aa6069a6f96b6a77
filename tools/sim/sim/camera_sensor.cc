#include "tools/sim/sim/camera_sensor.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tools/sim/sim/noise_hash.h"

namespace gw::sim {
namespace {

constexpr int kRowsPerPiece = 16;
constexpr float kMinBlur = 0.35f;  // px; less is hidden by the pixel's own size
constexpr int kMaxBlurTaps = 16;

float SampleRow(const float* image, int width, int height, float x, float y) {
  x = std::clamp(x, 0.0f, static_cast<float>(width) - 1.001f);
  y = std::clamp(y, 0.0f, static_cast<float>(height) - 1.001f);
  const int ix = static_cast<int>(x);
  const int iy = static_cast<int>(y);
  const float fx = x - static_cast<float>(ix);
  const float fy = y - static_cast<float>(iy);
  const float* p = image + static_cast<size_t>(iy) * width + ix;
  const float top = p[0] + fx * (p[1] - p[0]);
  const float bottom = p[width] + fx * (p[width + 1] - p[width]);
  return top + fy * (bottom - top);
}

}  // namespace

Exposure AutoExposure::exposure() const {
  Exposure e;
  e.time_ms = std::clamp(wanted_ms_, config_.min_exposure_ms, config_.max_exposure_ms);
  e.gain = std::clamp(wanted_ms_ / e.time_ms, 1.0, config_.max_gain);
  return e;
}

void AutoExposure::Observe(double mean_grey) {
  means_.push_back(mean_grey);
  if (static_cast<int>(means_.size()) < config_.exposure_delay_frames) return;
  const double signal = std::max(1.0, means_.front() - config_.black_level);
  means_.pop_front();
  const double error = std::log((config_.target_grey - config_.black_level) / signal);
  const double change = std::clamp(config_.exposure_rate * error, -0.5, 0.5);
  wanted_ms_ = std::clamp(wanted_ms_ * std::exp(change), config_.min_exposure_ms,
                          config_.max_exposure_ms * config_.max_gain);
}

Eigen::Vector2d ImageMotion(const Pinhole& camera, const CameraMotion& motion, double x, double y,
                            double inverse_depth) {
  // Image velocity of a static point X in the moving camera: dX/dt = -v - w x X; then the quotient
  // rule.
  const double nx = (x - camera.cx) / camera.fx;
  const double ny = (y - camera.cy) / camera.fy;
  const Eigen::Vector3d& v = motion.v;
  const Eigen::Vector3d& w = motion.w;
  const double along = v.z() * inverse_depth + w.x() * ny - w.y() * nx;
  return {camera.fx * (-v.x() * inverse_depth - w.y() + w.z() * ny + nx * along),
          camera.fy * (-v.y() * inverse_depth - w.z() * nx + w.x() + ny * along)};
}

CameraSensor::CameraSensor(const Pinhole& camera, const ImagerConfig& config, WorkerPool* pool)
    : camera_(camera),
      config_(config),
      pool_(pool),
      vignette_(static_cast<size_t>(camera.width) * camera.height),
      signal_(vignette_.size()) {
  const double corner2 = std::pow(camera.width / 2.0, 2) + std::pow(camera.height / 2.0, 2);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const double r2 = std::pow(x - camera.width / 2.0, 2) + std::pow(y - camera.height / 2.0, 2);
      vignette_[static_cast<size_t>(y) * camera.width + x] =
          static_cast<float>(1.0 - config.vignetting * r2 / corner2);
    }
  }
}

void CameraSensor::BlurRow(const RenderedImage& scene, const CameraMotion& motion, double seconds,
                           int y) {
  const int width = camera_.width;
  float* out = signal_.data() + static_cast<size_t>(y) * width;
  const float* in = scene.radiance.data() + static_cast<size_t>(y) * width;
  const float* inverse_depth = scene.inverse_depth.data() + static_cast<size_t>(y) * width;
  // ImageMotion in float, with what is the same in the whole row.
  const auto fx = static_cast<float>(camera_.fx * seconds);
  const auto fy = static_cast<float>(camera_.fy * seconds);
  const auto ny = static_cast<float>((y - camera_.cy) / camera_.fy);
  const auto nx_step = static_cast<float>(1 / camera_.fx);
  const auto nx_begin = static_cast<float>(-camera_.cx / camera_.fx);
  const Eigen::Vector3f v = motion.v.cast<float>();
  const Eigen::Vector3f w = motion.w.cast<float>();
  for (int x = 0; x < width; ++x) {
    const float nx = nx_begin + nx_step * static_cast<float>(x);
    const float along = v.z() * inverse_depth[x] + w.x() * ny - w.y() * nx;
    const float mx = fx * (-v.x() * inverse_depth[x] - w.y() + w.z() * ny + nx * along);
    const float my = fy * (-v.y() * inverse_depth[x] - w.z() * nx + w.x() + ny * along);
    const float length = std::sqrt(mx * mx + my * my);
    if (length < kMinBlur) {
      out[x] = in[x];
      continue;
    }
    const int taps = std::min(kMaxBlurTaps, 2 + static_cast<int>(length));
    float sum = 0;
    for (int i = 0; i < taps; ++i) {
      const float t = (static_cast<float>(i) + 0.5f) / static_cast<float>(taps) - 0.5f;
      sum += SampleRow(scene.radiance.data(), width, camera_.height, static_cast<float>(x) + t * mx,
                       static_cast<float>(y) + t * my);
    }
    out[x] = sum / static_cast<float>(taps);
  }
}

void CameraSensor::Expose(const RenderedImage& scene, const CameraMotion& motion,
                          const Exposure& exposure, const Glare& glare, uint64_t noise_key,
                          std::vector<uint8_t>* image) {
  const int width = camera_.width;
  const int height = camera_.height;
  image->resize(static_cast<size_t>(width) * height);
  const double seconds = exposure.time_ms * 1e-3;
  const auto scale =
      static_cast<float>(config_.grey_per_radiance_ms * exposure.time_ms * exposure.gain);
  const auto black = static_cast<float>(config_.black_level);
  const auto read = static_cast<float>(config_.read_noise_grey * exposure.gain);
  const auto shot = static_cast<float>(exposure.gain / config_.electrons_per_grey);
  const auto key = static_cast<uint32_t>(noise_key ^ (noise_key >> 32));
  const int pieces = (height + kRowsPerPiece - 1) / kRowsPerPiece;
  pool_->Run(pieces, [&](int piece, int) {
    const int end = std::min(height, (piece + 1) * kRowsPerPiece);
    for (int y = piece * kRowsPerPiece; y < end; ++y) {
      BlurRow(scene, motion, seconds, y);
      const size_t row = static_cast<size_t>(y) * width;
      float* signal = signal_.data() + row;
      if (glare.strength > 0) {
        for (int x = 0; x < width; ++x) {
          const double d2 = std::pow(x - glare.x, 2) + std::pow(y - glare.y, 2);
          signal[x] += static_cast<float>(
              glare.strength * (std::exp(-d2 / (2 * 60.0 * 60.0)) + 0.25 / (1 + d2 / 4e4)));
        }
      }
      const float* vignette = vignette_.data() + row;
      uint8_t* out = image->data() + row;
      for (int x = 0; x < width; ++x) signal[x] *= scale * vignette[x];
      for (int x = 0; x < width; ++x) {
        const float noise = UnitNoise(HashPixel(static_cast<uint32_t>(row) + x, key));
        const float sigma = std::sqrt(shot * signal[x] + read * read);
        const float grey = signal[x] + black + sigma * noise + 0.5f;
        out[x] = static_cast<uint8_t>(static_cast<int>(std::min(255.0f, std::max(0.0f, grey))));
      }
    }
  });
}

double MeanGrey(const std::vector<uint8_t>& image) {
  const auto sum = std::accumulate(image.begin(), image.end(), uint64_t{0});
  return image.empty() ? 0 : static_cast<double>(sum) / static_cast<double>(image.size());
}

}  // namespace gw::sim
