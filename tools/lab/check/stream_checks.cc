#include <algorithm>
#include <cmath>

#include "common/core/median.h"
#include "common/wire/channels.h"
#include "tools/data/files/format.h"
#include "tools/lab/check/checks.h"

namespace gw::check {
namespace {

using tools::Format;

// Stamps outside of these years were written in another unit, or never.
constexpr int64_t kYear2000 = 946'684'800'000'000, kYear2100 = 4'102'444'800'000'000;  // us
// A rate that differs from the stated one by more than this is another mode of the sensor.
constexpr double kRateTolerance = 0.2;

struct Expected {
  const char* channel;
  const char* name;  // of what is sent
  bool present;      // in the configuration
  double rate_hz;
  double longest_gap_s;  // that dead reckoning or tracking bridges without a doubt
};

struct Steps {
  double median_s = 0;
  double jitter_s = 0;  // robust standard deviation of the steps
  double largest_s = 0;
  Utime largest_at;
  int64_t backward = 0, repeated = 0;
  double missing_share = 0;  // of the messages that the median step lets expect
};

Steps MeasureSteps(const std::vector<Utime>& times) {
  Steps steps;
  std::vector<double> forward;
  for (size_t i = 1; i < times.size(); ++i) {
    const double step = (times[i] - times[i - 1]).seconds();
    if (step < 0) ++steps.backward;
    if (step == 0) ++steps.repeated;
    if (step > steps.largest_s) {
      steps.largest_s = step;
      steps.largest_at = times[i - 1];
    }
    if (step > 0) forward.push_back(step);
  }
  if (forward.empty()) return steps;
  steps.median_s = MedianOf(&forward);
  double missing = 0;
  std::vector<double> deviations;
  for (const double step : forward) {
    missing += std::max(0.0, std::round(step / steps.median_s) - 1);
    deviations.push_back(std::abs(step - steps.median_s));
  }
  steps.missing_share = missing / (missing + static_cast<double>(forward.size()));
  steps.jitter_s = kSigmaOverMedian * MedianOf(&deviations);
  return steps;
}

class StreamChecker {
 public:
  StreamChecker(const LogFacts& facts, const RobotConfig& config) : facts_(facts) {
    const Calibration& c = config.calibration;
    expected_ = {{{wire::kCamera, "images", true, c.camera.rate_hz, 0.5},
                  {wire::kImu, "IMU samples", c.imu.present, c.imu.rate_hz, 0.1},
                  {wire::kWheel, "wheel samples", c.wheel.present, c.wheel.rate_hz, 0.3}}};
  }

  Findings Check() {
    if (facts_.truncated || facts_.skipped_bytes > 0) {
      Warn("file-damaged",
           Format("the file %s, %d bytes in it are no messages",
                  facts_.truncated ? "ends inside a message" : "is whole", facts_.skipped_bytes),
           "gw-log cut writes the good part anew");
    }
    for (const tools::TimeStep& step : facts_.time_steps) {
      Warn("clock-step", "of the recorder: " + Describe(step),
           "keep the clock from being set while recording (NTP), or cut the log there with gw-log");
    }
    for (const Expected& expected : expected_) CheckStream(expected);
    CheckClocks();
    return std::move(findings_);
  }

 private:
  void Add(Severity severity, const char* id, std::string text, std::string fix) {
    findings_.push_back({severity, id, std::move(text), std::move(fix)});
  }
  void Fail(const char* id, std::string text, std::string fix) {
    Add(Severity::kError, id, std::move(text), std::move(fix));
  }
  void Warn(const char* id, std::string text, std::string fix) {
    Add(Severity::kWarning, id, std::move(text), std::move(fix));
  }

  void CheckStream(const Expected& e) {
    const auto found = facts_.streams.find(e.channel);
    const bool absent = found == facts_.streams.end() || found->second.times.empty();
    if (found != facts_.streams.end() && found->second.undecodable > 0) {
      Fail("undecodable",
           Format("%d messages of %s cannot be read; the first: %s", found->second.undecodable,
                  e.channel, found->second.why_undecodable),
           "write them as the channel's type says (docs/channels.md)");
    }
    if (absent && e.present) {
      Fail("stream-missing", Format("the configuration has %s, the recording has none", e.name),
           e.channel == wire::kCamera
               ? "record the channel CAMERA; without it there is only gw-slam --dr-only"
               : Format("record the channel %s, or set `present: false`", e.channel));
    }
    if (absent) return;
    if (!e.present) {
      Warn("stream-unused",
           Format("the recording has %s, the configuration says there are none", e.name),
           "set `present: true` in the section of the sensor, with its calibration");
    }
    const std::vector<Utime>& times = found->second.times;
    const Steps steps = MeasureSteps(times);
    if (times.front().us < kYear2000 || times.front().us > kYear2100) {
      // A clock that starts at zero is no fault; a step that is a power of ten off is.
      const double off = steps.median_s * e.rate_hz;
      if (times.front().us > kYear2100 || off > 100 || off < 0.01) {
        Fail("stamp-unit",
             Format("the stamps of the %s are no microseconds since 1970 (%d; steps of %.6g s "
                    "where %.6g s are expected)",
                    e.name, times.front().us, steps.median_s, 1 / e.rate_hz),
             "write microseconds; a power of ten too large are nanoseconds, too small seconds");
        return;
      }
    }
    CheckSteps(e, times.size(), steps);
  }

  void CheckSteps(const Expected& e, size_t count, const Steps& steps) {
    if (count < 10 || steps.median_s <= 0) return;
    const double rate_hz = 1 / steps.median_s;
    // A quarter of a step is no rounding to a scheduler's tick; below 4 ms nothing is noticed.
    const bool regular = steps.jitter_s <= std::max(0.25 * steps.median_s, 0.004);
    if (steps.backward > 0) {
      Fail("order",
           Format("%d of %d %s are stamped before the one in front of them", steps.backward, count,
                  e.name),
           "sort the recording by stamps, or find who sends twice");
    }
    if (steps.repeated > 0) {
      Warn("stamp-doubled",
           Format("%d of %d %s repeat the stamp before", steps.repeated, count, e.name),
           "stamp each sample when it is measured; only the first of each is used");
    }
    if (regular && std::abs(rate_hz / e.rate_hz - 1) > kRateTolerance) {
      Warn(
          "rate",
          Format("the %s come at %.1f Hz, the configuration says %.1f", e.name, rate_hz, e.rate_hz),
          "set rate_hz, or find what slows the sensor down");
    }
    if (steps.largest_s > std::max(e.longest_gap_s, 2.5 * steps.median_s)) {
      Warn("gap",
           Format("no %s for %.2f s from %.3f on", e.name, steps.largest_s,
                  steps.largest_at.seconds()),
           "see whether the recorder or the bus lost them (gw-log check, queue sizes)");
    }
    if (regular && steps.missing_share > 0.05) {
      Warn("lost",
           Format("%.0f %% of the %s are missing between the others", 100 * steps.missing_share,
                  e.name),
           "see whether the recorder or the bus lost them (disk, queue sizes, USB)");
    }
    if (!regular) {
      Warn("jitter",
           Format("the steps between %s scatter by %.1f ms around %.1f ms", e.name,
                  1e3 * steps.jitter_s, 1e3 * steps.median_s),
           "stamp at the time of measurement, not of arrival");
    }
  }

  // Streams of one robot begin and end together.
  void CheckClocks() {
    for (size_t a = 0; a < expected_.size(); ++a) {
      for (size_t b = a + 1; b < expected_.size(); ++b) {
        CheckPair(expected_[a], expected_[b]);
      }
    }
  }

  void CheckPair(const Expected& a, const Expected& b) {
    const auto one = facts_.streams.find(a.channel), two = facts_.streams.find(b.channel);
    if (one == facts_.streams.end() || two == facts_.streams.end()) return;
    if (one->second.times.size() < 2 || two->second.times.size() < 2) return;
    const auto [begin_a, end_a] =
        std::minmax_element(one->second.times.begin(), one->second.times.end());
    const auto [begin_b, end_b] =
        std::minmax_element(two->second.times.begin(), two->second.times.end());
    const double common = (std::min(*end_a, *end_b) - std::max(*begin_a, *begin_b)).seconds();
    const double shorter = std::min((*end_a - *begin_a).seconds(), (*end_b - *begin_b).seconds());
    if (common >= 0.5 * shorter) return;
    Fail("clock",
         Format("%s and %s have %.1f s in common of %.1f s: their clocks differ by about "
                "%.1f s",
                a.name, b.name, std::max(0.0, common), shorter, (*begin_b - *begin_a).seconds()),
         "set both clocks alike (chrony), or shift one stream (gw-import --imu-time-offset)");
  }

  const LogFacts& facts_;
  std::array<Expected, 3> expected_;
  Findings findings_;
};

}  // namespace

Findings CheckStreams(const LogFacts& facts, const RobotConfig& config) {
  return StreamChecker(facts, config).Check();
}

}  // namespace gw::check
