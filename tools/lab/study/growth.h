// What a run costs as it goes on: does the map, or the work on it, grow where the robot has been
// before?
//
// Times are CPU time of this thread, so that other work on the machine does not count. Memory is
// that of the whole process, with what the study itself keeps: 1.3 kB per image.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/lab/plot/svg.h"
#include "tools/lab/slam/laps.h"

namespace gw::study {

struct GrowthSample {
  double t_s = 0;  // at its end, since the first image; laps follow one another
  int64_t keyframes = 0, landmarks = 0;
  double resident_mb = 0;
  double tracking_p99_ms = 0;  // front-end time of the images since the sample before
  double local_ba_ms = 0;      // median of those since the sample before; NaN when there was none
};

// Call Observe() after each event of the run, with the session that it measures. Samples every
// kPeriod of the log.
class GrowthMeter {
 public:
  static constexpr DurationUs kPeriod = Milliseconds(10000);

  // resident_mb: of the process, see ResidentMegabytes().
  explicit GrowthMeter(std::function<double()> resident_mb)
      : resident_mb_(std::move(resident_mb)) {}
  void Observe(const tools::SlamSession& session);
  const std::vector<GrowthSample>& samples() const { return samples_; }

 private:
  std::function<double()> resident_mb_;
  std::vector<GrowthSample> samples_;
  size_t frames_ = 0, jobs_ = 0;  // measured in the samples so far
};

// The sample of one lap: map and memory of its last sample, times over all of it.
GrowthSample OfLap(const std::vector<GrowthSample>& samples, const tools::SlamSession& session,
                   const tools::Lap& lap);

struct GrowthRun {
  std::string label;
  std::vector<GrowthSample> samples;
};

// One panel for each quantity, over time.
std::vector<plot::Panel> GrowthPanels(const std::vector<GrowthRun>& runs);

int64_t ThreadCpuMicroseconds();
double ResidentMegabytes();  // 0 where the system does not tell

}  // namespace gw::study
