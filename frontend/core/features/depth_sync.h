// Is the depth image of the instant of the grey one? Where depth is late by tau images, each
// feature has the disparity of what was at its pixel then: beside slanted walls that is off by
// pixels while the camera turns, and consistently so. A map made from it is bent, and looks
// healthy.
//
// By r the disparity at a pixel changes from image to image, which the depth images beside tell. A
// feature's disparity lies beside that of its landmark by
//
//   e = -tau r + c + noise,      r = (d_after - d_before) / 2
//
// with a constant c for each landmark, which was placed from depth that was as late. Both count as
// distances, multiplied by (d_0 / d)^2 with the landmark's disparity at first: an error of distance
// stays as it is when the robot comes nearer, and so does r where it drives straight on. Least
// squares over the last seconds, in which each landmark has means of its own (a panel with fixed
// effects), leave tau. The noise of r is none of e's; it makes tau too small, and is measured by
// how unsteadily disparities change, and taken out (errors in variables):
//
//   q = d - (d_before + d_after) / 2,   variance of r's noise = E[ q^2 ] / 3
//
// The errors of an image and of those beside it are not independent. How certain tau is comes from
// the sums of each image, s = -e r and v = r^2, tau = sum(s) / sum(v): if it were tau_0, then
// sum(s - tau_0 v) / sqrt(sum((s - tau_0 v)^2)) would hardly ever be above 3 (self-normalised
// sums). Where tau is certain by chance it is small, and does little harm.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "common/camera/camera_model.h"
#include "common/core/ids.h"
#include "common/core/image_view.h"
#include "common/core/se3.h"
#include "common/core/time.h"
#include "frontend/core/features/depth_history.h"
#include "frontend/core/features/depth_lookup.h"
#include "frontend/core/features/feature_frame.h"

namespace gw::frontend {

class DepthSync {
 public:
  // A landmark that the newest image shows.
  struct Sight {
    double u = 0, v = 0;  // px, of its feature in the rectified image
    LandmarkId landmark;
    double depth = 0;  // where it should be, m as the camera tells them, > 0
  };

  explicit DepthSync(const CameraGeometry& geometry);

  // The depth image of every image, before the pose of that is sought; empty where its features got
  // no depth from it.
  void Push(Utime utime, const ImageView& depth);

  // There are depth images to be judged.
  bool Asks() const { return !depths_.Before(1).empty(); }
  // What the newest image shows, when its pose is known.
  void Observe(std::vector<Sight> sights) { sights_ = std::move(sights); }

  // By how many images depth is late; negative: early; 0 also until it is certain.
  double Lateness() const;

  // Late, or early, by more than so many images (>= 0), for certain.
  bool IsLate(double images) const { return IsBeyond(images, 1); }
  bool IsEarly(double images) const { return IsBeyond(images, -1); }

  // The disparities of the newest image's features, if depth is late by so many images: they have
  // gone on changing as they did. None at edges. T_ab: the camera's motion since the image before.
  // Lengths of features and motion may both be corrected by a factor.
  void Correct(double lateness, const SE3& T_ab, std::vector<Feature>* features) const;

 private:
  // What is known of a landmark's features.
  struct Track {
    Utime seen;
    double count = 0;
    double disparity = 0;  // where it should be, at first, px
    double e = 0, r = 0;   // means, px
  };

  struct Sums {
    double s = 0, v = 0;
    double ss = 0, sv = 0, vv = 0;  // of their products, image by image
  };

  // Disparity that a depth image shows at a pixel of the rectified image; <= 0: none.
  double DisparityAt(const ImageView& depth, double u, double v) const;
  void Judge(const ImageView& after);
  bool IsBeyond(double images, int sign) const;

  RectifiedCamera camera_;
  PinholeIntrinsics source_;  // of the images as they come
  DepthLookup lookup_;
  DepthHistory depths_;  // with that of the newest image
  Utime utime_;          // of that
  std::vector<Sight> sights_;
  std::unordered_map<int64_t, Track> tracks_;  // by LandmarkId::value
  Utime cleaned_;                              // of those that were not seen for long
  Sums sums_;
};

}  // namespace gw::frontend
