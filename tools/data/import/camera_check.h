// Do intrinsics fit the images?
#pragma once

#include "tools/data/import/recording.h"

namespace gw::importer {

// Warns when a principal point is farther from the image's middle than a lens is mounted off:
// intrinsics of another size, or cx and cy exchanged. Needs images.
void WarnOfPrincipalPoint(Recording& recording);

}  // namespace gw::importer
