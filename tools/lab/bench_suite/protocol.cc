#include "tools/lab/bench_suite/protocol.h"

#include <algorithm>
#include <numeric>
#include <set>

namespace gw::bench {
namespace {

std::vector<double> Values(const std::vector<const CellResult*>& runs, const Value& value) {
  std::vector<double> out;
  for (const CellResult* run : runs) {
    const auto v = run->measures ? value(*run->measures) : std::nullopt;
    if (v) out.push_back(*v);
  }
  return out;
}

// Adds one sequence to its method.
void Count(const std::string& variant, bool failed, std::optional<double> ape_m,
           std::vector<Ranked>* ranked) {
  auto it = std::find_if(ranked->begin(), ranked->end(),
                         [&](const Ranked& r) { return r.variant == variant; });
  if (it == ranked->end()) it = ranked->insert(it, {variant, 0, 0, std::nullopt, std::nullopt});
  ++it->total;
  if (failed) return;
  ++it->finished;
  it->mean_ape_m = it->mean_ape_m.value_or(0) + ape_m.value_or(0);  // their sum, for now
}

}  // namespace

bool RunFailed(const CellResult& run) {
  if (!run.measures || !run.measures->ape_live_m) return true;
  return *run.measures->ape_live_m > kMaxApe || run.measures->tracked_share() < kMinTracked;
}

bool Sequence::failed() const {
  return std::any_of(runs.begin(), runs.end(),
                     [](const CellResult* run) { return RunFailed(*run); });
}

std::optional<double> Sequence::Mean(const Value& value) const {
  const std::vector<double> values = Values(runs, value);
  if (values.empty()) return std::nullopt;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

std::optional<double> Sequence::Min(const Value& value) const {
  const std::vector<double> values = Values(runs, value);
  if (values.empty()) return std::nullopt;
  return *std::min_element(values.begin(), values.end());
}

std::optional<double> Sequence::Max(const Value& value) const {
  const std::vector<double> values = Values(runs, value);
  if (values.empty()) return std::nullopt;
  return *std::max_element(values.begin(), values.end());
}

measure::NeesCount Sequence::Sum(measure::NeesCount measure::Consistency::*which) const {
  measure::NeesCount sum;
  for (const CellResult* run : runs) {
    if (!run->measures) continue;
    const measure::NeesCount& count = run->measures->consistency.*which;
    sum.windows += count.windows;
    sum.inside += count.inside;
    sum.above += count.above;
    sum.undefined += count.undefined;
  }
  return sum;
}

std::vector<Sequence> Sequences(const std::vector<CellResult>& results) {
  std::vector<Sequence> out;
  for (const CellResult& result : results) {
    auto it = std::find_if(out.begin(), out.end(), [&](const Sequence& s) {
      return s.input == result.input && s.variant == result.variant;
    });
    if (it == out.end()) {
      out.push_back({result.input, result.variant, {}});
      it = out.end() - 1;
    }
    it->runs.push_back(&result);
  }
  return out;
}

std::vector<Ranked> Rank(const std::vector<Sequence>& sequences,
                         const std::vector<PublishedRow>& published) {
  std::vector<Ranked> out;
  std::set<std::string> dr_counted;
  for (const Sequence& sequence : sequences) {
    Count(sequence.variant, sequence.failed(),
          sequence.Mean([](const auto& m) { return m.ape_live_m; }), &out);
    const auto dr = sequence.Mean([](const auto& m) { return m.ape_dr_m; });
    if (dr && dr_counted.insert(sequence.input).second) Count(kDrAlone, *dr > kMaxApe, dr, &out);
  }
  for (Ranked& ranked : out) {
    if (ranked.mean_ape_m) *ranked.mean_ape_m /= ranked.finished;
    ranked.completeness = static_cast<double>(ranked.finished) / ranked.total;
  }
  for (const PublishedRow& row : published) {
    out.push_back({row.name + "*", 0, 0, row.ape_m, row.completeness});
  }
  std::stable_sort(out.begin(), out.end(), [](const Ranked& a, const Ranked& b) {
    const double share_a = a.completeness.value_or(-1), share_b = b.completeness.value_or(-1);
    if (share_a != share_b) return share_a > share_b;
    return a.mean_ape_m.value_or(kMaxApe) < b.mean_ape_m.value_or(kMaxApe);
  });
  return out;
}

}  // namespace gw::bench
