// The protocol of Du, Peng, Vela, "Good Weights", arXiv 2509.22910, section IV-A: a sequence counts
// as failed for a method when any of its runs has an APE RMSE above 10 m or tracked less than half
// of the images. Completeness is the share of sequences that did not fail; methods are ranked by
// it, ties by the mean RMSE over the sequences they finished.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tools/lab/bench_suite/cells.h"

namespace gw::bench {

inline constexpr double kMaxApe = 10.0;  // m
inline constexpr double kMinTracked = 0.5;

bool RunFailed(const CellResult& run);

// All runs of one input with one variant.
using Value = std::function<std::optional<double>(const measure::Measures&)>;

struct Sequence {
  std::string input;
  std::string variant;
  std::vector<const CellResult*> runs;  // by seed; not empty

  bool failed() const;
  // Over the runs that have it; empty when none has.
  std::optional<double> Mean(const Value& value) const;
  std::optional<double> Min(const Value& value) const;
  std::optional<double> Max(const Value& value) const;
  measure::NeesCount Sum(measure::NeesCount measure::Consistency::*which) const;
};

struct Ranked {
  std::string variant;
  int finished = 0;
  int total = 0;                       // 0: a row of the literature
  std::optional<double> mean_ape_m;    // of the means of the finished sequences
  std::optional<double> completeness;  // 0 to 1; empty: not published

  bool complete() const { return completeness.value_or(1) >= 1; }
};

// Dead reckoning alone as if it were a variant, for comparison.
inline constexpr char kDrAlone[] = "DR alone";

// In the order of the results. They must outlive the sequences.
std::vector<Sequence> Sequences(const std::vector<CellResult>& results);

// Best first, with dead reckoning alone among them where the logs have any, and rows of the
// literature, starred; those without a completeness come last.
std::vector<Ranked> Rank(const std::vector<Sequence>& sequences,
                         const std::vector<PublishedRow>& published);

}  // namespace gw::bench
