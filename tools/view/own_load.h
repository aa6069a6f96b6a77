// What this process takes of the machine.
#pragma once

#include "common/core/time.h"

namespace gw::view {

class OwnLoad {
 public:
  // Time spent on one core since the call before, percent; 0 at the first call.
  double CpuPercent(Utime now);
  // MB that are this process' own. Not pages of the libraries' files, which are shared, and come
  // and go with what the machine does.
  static double MemoryMb();

 private:
  Utime last_;
  double last_cpu_s_ = 0;
  bool first_ = true;
};

}  // namespace gw::view
