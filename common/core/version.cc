#include "common/core/version.h"

namespace gw {

const char* Version() {
  return GW_VERSION;
}

}  // namespace gw
