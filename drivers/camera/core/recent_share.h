// The share of the newest events of a stream for which something was true.
#pragma once

#include <cstddef>
#include <deque>

namespace gw::camera {

class RecentShare {
 public:
  explicit RecentShare(size_t window) : window_(window) {}

  void Add(bool value) {
    values_.push_back(value);
    true_ += value ? 1 : 0;
    if (values_.size() > window_) {
      true_ -= values_.front() ? 1 : 0;
      values_.pop_front();
    }
  }
  // The share over the window; what was not added yet counts as false.
  double share() const { return static_cast<double>(true_) / static_cast<double>(window_); }

 private:
  size_t window_;
  std::deque<bool> values_;
  size_t true_ = 0;
};

}  // namespace gw::camera
