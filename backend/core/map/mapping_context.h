// What every step of the mapper needs to know: configuration and camera, with what follows from
// them.
#pragma once

#include "common/camera/camera_model.h"
#include "common/config/backend_config.h"
#include "common/config/frontend_config.h"
#include "common/vision/pyramid.h"

namespace gw::backend {

struct MappingContext {
  MappingContext(const BackendConfig& backend, const FrontendConfig& frontend,
                 const RectifiedCamera& rectified)
      : config(backend),
        variant(frontend.variant),
        dr_weight(frontend.dr_weight),
        camera(rectified),
        pyramid(frontend.orb.scale_factor, frontend.orb.num_levels) {}

  BackendConfig config;
  Variant variant;
  DrWeightConfig dr_weight;
  RectifiedCamera camera;
  Pyramid pyramid;
};

}  // namespace gw::backend
