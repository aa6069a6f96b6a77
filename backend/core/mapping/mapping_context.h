// What every step of the mapper needs to know: configuration and camera, with what follows from
// them.
#pragma once

#include <array>
#include <cmath>

#include "backend/core/bundle/reprojection.h"
#include "backend/core/map/keyframe_check.h"
#include "common/camera/camera_model.h"
#include "common/config/backend_config.h"
#include "common/config/frontend_config.h"
#include "common/contract/map.h"

namespace gw::backend {

struct MappingContext {
  BackendConfig config;
  Variant variant = Variant::kFull;
  DrWeightConfig dr_weight;
  RectifiedCamera camera;
  int num_levels = 8;
  double scale_factor = 1.2;
  std::array<double, kMaxLevel + 1> level_scale{};  // scale_factor^level: size and pixel sigma

  static MappingContext Make(const BackendConfig& backend, const FrontendConfig& frontend,
                             const RectifiedCamera& camera) {
    MappingContext out{backend, frontend.variant,        frontend.dr_weight,
                       camera,  frontend.orb.num_levels, frontend.orb.scale_factor,
                       {}};
    for (size_t level = 0; level < out.level_scale.size(); ++level) {
      out.level_scale[level] = std::pow(out.scale_factor, static_cast<double>(level));
    }
    return out;
  }

  PixelMeasurement Measurement(const Feature& feature) const {
    return {feature.u, feature.v, feature.u_right, feature.has_depth(),
            1.0 / level_scale[feature.level]};
  }

  // Pyramid level at which a landmark with this max_distance appears from `distance` (m).
  int PredictLevel(double max_distance, double distance) const {
    const double level = std::log(max_distance / distance) / std::log(scale_factor);
    return static_cast<int>(std::clamp(std::ceil(level - 0.5), 0.0, num_levels - 1.0));
  }
};

}  // namespace gw::backend
