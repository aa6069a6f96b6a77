#include "frontend/core/features/view_watch.h"

#include <algorithm>
#include <cmath>

namespace gw::frontend {
namespace {

// What a column has shown counts for about so many images that show something.
constexpr double kMemory = 300;
// A covered column shows again less than this share of what others do; so many landmarks tell.
constexpr double kFoundShare = 0.5;
constexpr double kTelling = 100;
// A side counts from a quarter of the image; beyond the column that loses landmarks it shows less
// than this share of the features that the rest does, column by column.
constexpr size_t kSide = 8;
constexpr double kEmptyShare = 0.05;

// Brightness that is beside the middle of its neighbours by this share, in most images of so long.
constexpr double kJump = 0.1;
constexpr DurationUs kLightSpan = Milliseconds(2000);
constexpr size_t kFewestImages = 10;

}  // namespace

size_t ViewWatch::ColumnOf(double u) const {
  const double column = std::floor(static_cast<double>(kColumns) * u / width_);
  return static_cast<size_t>(std::clamp(column, 0.0, static_cast<double>(kColumns - 1)));
}

void ViewWatch::Expect(double u, bool found) {
  Column& column = columns_[ColumnOf(u)];
  column.expected += 1;
  column.found += found;
}

void ViewWatch::Observe(Utime utime, const FeatureFrame& seen) {
  if (!seen.features.empty()) {
    for (Column& c : columns_) {
      const double kept = 1 - 1 / kMemory;
      c = {kept * c.features, kept * c.expected, kept * c.found};
    }
  }
  for (const Feature& f : seen.features) columns_[ColumnOf(f.u)].features += 1;
  light_.push_back({utime, seen.brightness});
  while (utime - light_.front().utime > kLightSpan) light_.pop_front();
  fault_ = Judge();
}

bool ViewWatch::Flickers() const {
  if (light_.size() < kFewestImages) return false;
  size_t jumps = 0;
  for (size_t i = 1; i + 1 < light_.size(); ++i) {
    const double middle = (light_[i - 1].brightness + light_[i + 1].brightness) / 2;
    jumps += std::abs(light_[i].brightness - middle) > kJump * middle;
  }
  return 2 * jumps > light_.size();
}

bool ViewWatch::IsCovered(const Columns& from_side) {
  Column all;
  for (const Column& c : from_side) {
    all = {all.features + c.features, all.expected + c.expected, all.found + c.found};
  }
  const double usual = all.expected > 0 ? all.found / all.expected : 0;
  double beyond = 0;  // features
  for (size_t i = 0; i < kColumns / 2 + kSide; ++i) {
    beyond += from_side[i].features;
    const double rest = (all.features - beyond) / static_cast<double>(kColumns - i - 1);
    if (beyond > kEmptyShare * rest * static_cast<double>(i + 1)) return false;
    const Column& c = from_side[i];
    if (i + 1 >= kSide && c.expected >= kTelling && c.found < kFoundShare * usual * c.expected)
      return true;
  }
  return false;
}

ViewFault ViewWatch::Judge() const {
  if (Flickers()) return ViewFault::kFlickers;
  if (IsCovered(columns_)) return ViewFault::kLeftCovered;
  Columns from_right = columns_;
  std::reverse(from_right.begin(), from_right.end());
  return IsCovered(from_right) ? ViewFault::kRightCovered : ViewFault::kNone;
}

}  // namespace gw::frontend
