// The line under a cloud of points that only noise from above has moved: the least delay of a
// transport, as a slowly sloping function of the sender's clock.
//
// A delay is a constant plus waiting that is never negative. Averages follow the waiting; the lower
// envelope does not. With the slope, a clock that runs faster or slower by up to `max_slope` is
// followed without delay. Method: the lower convex hull of the least point of each bin, and of it
// the edge under the middle of the window (Moon, Skelly, Towsley 1999; Zhang, Liu, Xia 2002).
#pragma once

#include <cstdint>
#include <deque>

namespace gw {

class LowerEnvelope {
 public:
  struct Options {
    int64_t bin = 250'000;  // width of a bin, in units of x
    int64_t num_bins = 120;
    double max_slope = 0;  // largest slope of the line, dy/dx, either way
  };
  // Precondition: bin > 0, num_bins > 1, max_slope >= 0.
  explicit LowerEnvelope(const Options& options) : options_(options) {}

  // Precondition: x does not decrease. |x|, |y| < 2^52.
  void Add(int64_t x, int64_t y);
  void Clear() { bins_.clear(); }

  bool empty() const { return bins_.empty(); }
  // The width of what is known, in units of x.
  int64_t span() const { return empty() ? 0 : bins_.back().x - bins_.front().x; }
  // The height of the line at x. Precondition: !empty().
  double At(int64_t x) const;

 private:
  struct Point {
    int64_t bin = 0;
    int64_t x = 0;
    int64_t y = 0;
  };
  Options options_;
  std::deque<Point> bins_;  // the lowest point of each bin that has one, in order
};

}  // namespace gw
