#include "tools/lab/study/growth.h"

#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <utility>

#include "tools/lab/measure/measures.h"

namespace gw::study {
namespace {

double P99Milliseconds(const std::vector<int64_t>& us, size_t begin, size_t end) {
  std::vector<double> ms;
  for (size_t i = begin; i < end; ++i) ms.push_back(static_cast<double>(us[i]) * 1e-3);
  return ms.empty() ? 0 : measure::Quantile(std::move(ms), 0.99);
}

double MedianMilliseconds(const std::vector<tools::MeasuredTime>& times, size_t begin, size_t end) {
  std::vector<double> ms;
  for (size_t i = begin; i < end; ++i) ms.push_back(static_cast<double>(times[i].us) * 1e-3);
  return ms.empty() ? std::numeric_limits<double>::quiet_NaN() : measure::Median(std::move(ms));
}

}  // namespace

void GrowthMeter::Observe(const tools::SlamSession& session) {
  const std::vector<FramePose>& frames = session.frames();
  if (frames.size() == frames_) return;
  const DurationUs since_begin = frames.back().utime - frames.front().utime;
  if (since_begin.us < kPeriod.us * (std::ssize(samples_) + 1)) return;
  GrowthSample sample;
  sample.t_s = since_begin.seconds();
  sample.keyframes = std::ssize(session.mapper().map().keyframes());
  sample.landmarks = static_cast<int64_t>(session.mapper().map().num_landmarks());
  sample.resident_mb = resident_mb_();
  sample.tracking_p99_ms = P99Milliseconds(session.tracking_us(), frames_, frames.size());
  sample.local_ba_ms =
      MedianMilliseconds(session.local_ba_times(), jobs_, session.local_ba_times().size());
  frames_ = frames.size();
  jobs_ = session.local_ba_times().size();
  samples_.push_back(sample);
}

GrowthSample OfLap(const std::vector<GrowthSample>& samples, const tools::SlamSession& session,
                   const tools::Lap& lap) {
  const std::vector<FramePose>& frames = session.frames();
  const Utime begin = frames[lap.frames_begin].utime;
  const Utime end = frames[lap.frames_end - 1].utime;
  GrowthSample out;
  out.t_s = (end - frames.front().utime).seconds();
  out.keyframes = lap.keyframes;
  out.landmarks = lap.landmarks;
  for (const GrowthSample& sample : samples) {
    if (sample.t_s <= out.t_s) out.resident_mb = sample.resident_mb;
  }
  out.tracking_p99_ms = P99Milliseconds(session.tracking_us(), lap.frames_begin, lap.frames_end);
  const std::vector<tools::MeasuredTime>& times = session.local_ba_times();
  const auto first = std::find_if(times.begin(), times.end(),
                                  [&](const tools::MeasuredTime& t) { return t.utime >= begin; });
  const auto last =
      std::find_if(first, times.end(), [&](const tools::MeasuredTime& t) { return t.utime > end; });
  out.local_ba_ms = MedianMilliseconds(times, static_cast<size_t>(first - times.begin()),
                                       static_cast<size_t>(last - times.begin()));
  return out;
}

std::vector<plot::Panel> GrowthPanels(const std::vector<GrowthRun>& runs) {
  struct Quantity {
    const char* title;
    const char* unit;
    double (*value)(const GrowthSample&);
  };
  constexpr Quantity kQuantities[] = {
      {"keyframes in the map", "count",
       [](const GrowthSample& s) { return static_cast<double>(s.keyframes); }},
      {"landmarks in the map", "count",
       [](const GrowthSample& s) { return static_cast<double>(s.landmarks); }},
      {"resident memory", "MB", [](const GrowthSample& s) { return s.resident_mb; }},
      {"front-end, 99 % of the images take less", "ms, CPU",
       [](const GrowthSample& s) { return s.tracking_p99_ms; }},
      {"local BA, median", "ms, CPU", [](const GrowthSample& s) { return s.local_ba_ms; }}};
  std::vector<plot::Panel> out;
  for (const Quantity& quantity : kQuantities) {
    plot::Panel panel;
    panel.title = quantity.title;
    panel.x_label = "driven, s";
    panel.y_label = quantity.unit;
    double top = 0;
    for (const GrowthRun& run : runs) {
      plot::Series series;
      series.label = run.label;
      for (const GrowthSample& sample : run.samples) {
        series.x.push_back(sample.t_s);
        series.y.push_back(quantity.value(sample));
        if (series.y.back() > top) top = series.y.back();
      }
      panel.series.push_back(std::move(series));
    }
    panel.y_range = {0, top > 0 ? 1.1 * top : 1};
    out.push_back(std::move(panel));
  }
  return out;
}

int64_t ThreadCpuMicroseconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<int64_t>(t.tv_sec) * 1000000 + t.tv_nsec / 1000;
}

double ResidentMegabytes() {
  std::ifstream file("/proc/self/statm");
  int64_t size = 0;
  int64_t resident = 0;
  file >> size >> resident;
  return static_cast<double>(resident * sysconf(_SC_PAGESIZE)) / (1024.0 * 1024.0);
}

}  // namespace gw::study
