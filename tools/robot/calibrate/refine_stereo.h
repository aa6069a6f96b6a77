// Where the right eye of a stereo camera really looks, from images alone.
//
// A pixel of disparity that the calibration gets wrong makes everything far away too far or too
// near, and the robot's way with it. A moving camera shows the error: the size of things must grow
// as their stereo depth says, and rows must agree between the eyes. Found is the calibration of the
// right eye with which tracks through pairs of stereo images fit best (two-view bundle adjustment
// of all pairs with one calibration in common; robust, least squares of pixels).
//
// The left eye and the length of the baseline are taken as given: the first cannot be told well
// from such motion, the second not at all.
#pragma once

#include <vector>

#include "common/camera/calibration.h"
#include "common/core/result.h"
#include "tools/robot/calibrate/stereo_tracks.h"

namespace gw::tools {

struct StereoRefinement {
  CameraCalibration camera;  // with the refined right eye and T_C0C1
  // How far the right image of a point at infinity moves by the refinement, px along x, at the left
  // edge, the centre and the right edge of the middle row. Positive: disparities were too small.
  double shift_left_px = 0, shift_centre_px = 0, shift_right_px = 0;
  double sigma_shift_px = 0;  // standard deviation of shift_centre_px
  double rms_before_px = 0;   // of all residuals of the tracks used, with the given calibration
  double rms_after_px = 0;
  int num_pairs = 0, num_tracks = 0;  // used
};

// Error kBadConfig: no stereo camera. kBadData: too few tracks, or they do not determine the
// disparity to kMaxSigmaShiftPx: drive past textured things at several distances.
inline constexpr double kMaxSigmaShiftPx = 0.1;
Result<StereoRefinement> RefineStereo(const CameraCalibration& given,
                                      const std::vector<PairTracks>& pairs);

}  // namespace gw::tools
