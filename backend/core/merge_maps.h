// Two maps made apart become one, where they show the same places.
#pragma once

#include "backend/core/map/map.h"
#include "common/camera/camera_model.h"
#include "common/config/backend_config.h"
#include "common/config/frontend_config.h"
#include "common/core/result.h"

namespace gw::backend {

struct MergedMap {
  Map map;        // in the frame of the first; ids of the second as PutTogether() makes them
  int views = 0;  // of the second map that agree in where it lies in the first
  int loops = 0;  // closed besides, where the second map shows the first
};

// Locates the keyframes of `b` in `a`, joins the maps where several agree, closes loops along the
// way of `b` as if it were driven again, and optimises the whole. Pieces of the maps that are not
// joined stay pieces. Precondition: both are whole (CheckMap), and were made with this camera and
// pyramid. Errors: kBadConfig; kNotFound, and the text says which: no place in common that several
// keyframes agree on; places that look alike in two ways; views in a row that do not show what they
// should.
Result<MergedMap> MergeMaps(const Map& a, const Map& b, const BackendConfig& config,
                            const FrontendConfig& frontend, const RectifiedCamera& camera);

}  // namespace gw::backend
