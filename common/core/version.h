// Version of the project, from the one place that states it: project() in CMakeLists.txt.
#pragma once

namespace gw {

// "MAJOR.MINOR.PATCH", for --version and for reports.
const char* Version();

}  // namespace gw
