#include "tools/view/own_load.h"

#include <sys/resource.h>
#include <unistd.h>

#include <fstream>

namespace gw::view {
namespace {

double Seconds(const timeval& t) {
  return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_usec) * 1e-6;
}

}  // namespace

double OwnLoad::CpuPercent(Utime now) {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  const double cpu_s = Seconds(usage.ru_utime) + Seconds(usage.ru_stime);
  const double elapsed = (now - last_).seconds();
  const double percent = first_ || elapsed <= 0 ? 0 : 100 * (cpu_s - last_cpu_s_) / elapsed;
  first_ = false;
  last_ = now;
  last_cpu_s_ = cpu_s;
  return percent;
}

double OwnLoad::MemoryMb() {
  std::ifstream statm("/proc/self/statm");
  double total = 0, resident = 0, of_files = 0;
  statm >> total >> resident >> of_files;
  return (resident - of_files) * static_cast<double>(::sysconf(_SC_PAGESIZE)) * 1e-6;
}

}  // namespace gw::view
