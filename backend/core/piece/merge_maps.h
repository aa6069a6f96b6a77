// Two maps made apart become one, where they show the same places.
#pragma once

#include "backend/core/map/map.h"
#include "common/camera/camera_model.h"
#include "common/config/backend_config.h"
#include "common/config/frontend_config.h"
#include "common/core/result.h"

namespace gw::backend {

struct MergedMap {
  Map map;  // in the frame of the first; ids of the second as PutTogether() makes them
  int keyframes_joined = 0;  // of the second map; what could not be joined stays a piece
  int loops = 0;             // closed besides, where the second map shows the first
};

// Locates the keyframes of `b` in `a` until several agree (PieceJoiner), joins the maps there,
// closes loops along the way of `b` as if it were driven again, and optimises the whole.
// Precondition: both are whole (CheckMap), and were made with this camera and pyramid.
// Errors: kNotFound, the maps show no place in common that several keyframes agree on; kBadConfig.
Result<MergedMap> MergeMaps(const Map& a, const Map& b, const BackendConfig& config,
                            const FrontendConfig& frontend, const RectifiedCamera& camera);

}  // namespace gw::backend
