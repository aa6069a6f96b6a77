// The camera section of a recording without images.
#pragma once

#include <string>

#include "tools/data/import/recording.h"

namespace gw::importer {

// A robot's YAML needs a camera; nothing reads its values where there are no images. Sets a D435i's
// nominal colour camera at 848 x 480, and warns that it is nominal, after `why`.
void SetNominalCamera(const std::string& why, Recording& recording);

}  // namespace gw::importer
