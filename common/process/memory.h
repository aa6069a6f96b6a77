// Memory of this process.
#pragma once

#include <malloc.h>

namespace gw::process {

// Gives memory that is free back to the system. After a large job glibc keeps it, in pieces between
// what others hold: a hundred MB after a global BA of 300 keyframes, and more with each. Takes
// some ms. Any thread.
inline void ReleaseFreeMemory() {
  malloc_trim(0);
}

}  // namespace gw::process
