// The reference page of the configuration (docs/configuration.md), from the same field lists that
// the loader uses. `gw-config --doc` prints it; a test keeps the committed page up to date.
#pragma once

#include <string>

#include "common/config/describe.h"

namespace gw {

// Markdown: for each section a table of key, type, unit, default, range and meaning.
std::string ConfigReference();

// "1 to 100", "at least 0", "rgbd or stereo"; empty when anything of the type is legal.
std::string LegalValues(const FieldInfo& field);
std::string LegalRange(const FieldSpec& spec);

// "a, b or c".
std::string JoinChoices(const std::vector<std::string>& choices);

}  // namespace gw
