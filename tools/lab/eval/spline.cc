#include "tools/lab/eval/spline.h"

#include <algorithm>

#include "tools/lab/eval/spline_math.h"

namespace gw::eval {

PoseSpline::PoseSpline(Utime begin, Utime end, DurationUs spacing)
    : begin_(begin), end_(end), spacing_(spacing) {
  const int64_t spans = std::max<int64_t>(1, ((end - begin).us + spacing.us - 1) / spacing.us);
  controls_.resize(static_cast<size_t>(spans) + 3);
}

PoseSpline::Place PoseSpline::At(Utime t) const {
  const int64_t since = (std::clamp(t, begin_, end_) - begin_).us;
  const int64_t last = static_cast<int64_t>(controls_.size()) - 4;
  const int64_t span = std::min(since / spacing_.us, last);
  return {static_cast<size_t>(span),
          static_cast<double>(since - span * spacing_.us) / static_cast<double>(spacing_.us)};
}

Utime PoseSpline::TimeOf(size_t control) const {
  return begin_ + DurationUs{(static_cast<int64_t>(control) - 1) * spacing_.us};
}

SE3 PoseSpline::Pose(Utime t) const {
  const Place place = At(t);
  std::array<spline_math::Motion<double>, 4> controls;
  for (size_t i = 0; i < 4; ++i) {
    const SE3& T = controls_[place.first + i];
    controls[i] = {T.rotation(), T.translation()};
  }
  const auto pose = spline_math::Pose(controls, place.u);
  return SE3(pose.q, pose.p);
}

Eigen::Vector3d PoseSpline::Rate(Utime t) const {
  const Place place = At(t);
  std::array<Eigen::Quaterniond, 4> controls;
  for (size_t i = 0; i < 4; ++i) controls[i] = controls_[place.first + i].rotation();
  return spline_math::Rate(controls, place.u, spacing_s());
}

}  // namespace gw::eval
