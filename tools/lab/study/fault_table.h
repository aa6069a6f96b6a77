// The table of a fault matrix: what each fault did, against its bar.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/lab/study/experiment.h"
#include "tools/lab/study/fault_cases.h"
#include "tools/lab/study/fault_measures.h"
#include "tools/lab/study/fault_run.h"

namespace gw::study {

// What the system said because of a fault: not said without it, or only before it.
struct Saying {
  std::string name;
  double after_s = 0;  // since the fault could be seen
  // See Finding.
  int64_t count = 0;
  bool of_dr = false;
  bool in_health = false;
};

// One run of `full` with the fault, with its own seed.
struct FaultOutcome {
  FaultNumbers numbers;
  std::vector<Saying> sayings;  // in the order in which they were said first
};

struct FaultRow {
  std::string name, text;
  std::vector<FaultOutcome> full;  // one per seed; at least one
  // RMSE of the positions, m; of several seeds the mean. Empty: not determined, or not there.
  std::optional<double> none_m;          // vision alone: with a fault of vision, else without
  std::optional<double> dr_m, wheels_m;  // the filter alone, the wheels' own sum: with a fault of
                                         // DR, else without
  std::optional<double> sound_full_m;    // `full` without the fault
};

// The sayings of a run that the run without fault has not. visible: from when on the fault can be
// seen.
std::vector<Saying> SayingsOf(const Findings& findings, const Findings& without_fault,
                              Utime visible);

struct FaultVerdict {
  std::optional<double> full_m;         // mean of the seeds
  std::optional<double> bar_m;          // what full_m may be
  std::optional<double> ratio;          // full_m / bar_m
  std::optional<double> named_after_s;  // slowest of the seeds; empty: one did not name it
  int64_t without_pose = 0;             // images, worst seed
  double too_sure_s = 0;                // worst seed
  std::vector<std::string> misses;      // of the bar; empty: met
};

// The bars. Faults of DR: where vision is healthy at most 1.1 x vision alone, elsewhere at
// most 1.05 x what the faulty wheels give by themselves; a pose for every image; named within 10 s.
// Faults of vision: at most the larger of 1.25 x dead reckoning alone and 1.1 x the run without
// fault; never tracking for more than 2 s with an error over 5 sigma; named, and not as a fault of
// DR.
FaultVerdict Judge(FaultMatrix matrix, bool vision_healthy, const FaultRow& row);

// origin: log, seeds, versions. sound: the longest too sure span of `full` without a fault, s.
StudyFiles RenderFaults(FaultMatrix matrix, bool vision_healthy, const std::string& origin,
                        double sound_too_sure_s, const std::vector<FaultRow>& rows);

}  // namespace gw::study
