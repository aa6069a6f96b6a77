#include <algorithm>
#include <cmath>

#include "common/core/median.h"
#include "tools/data/files/format.h"
#include "tools/lab/check/checks.h"

namespace gw::check {
namespace {

using tools::Format;

template <typename Facts, typename Member>
double MedianFact(const std::vector<Facts>& facts, Member member) {
  std::vector<double> values;
  values.reserve(facts.size());
  for (const Facts& fact : facts) values.push_back(fact.*member);
  return values.empty() ? 0 : MedianOf(&values);
}

void CheckExposure(const ImageFacts& facts, Findings& findings) {
  int dark = 0, burnt = 0, same = 0;
  for (const ImageFact& image : facts.images) {
    dark += image.mean_grey < 12;
    burnt += image.burnt_share > 0.4;
    same += image.same_as_last;
  }
  const auto total = static_cast<double>(facts.images.size());
  const auto share = [&](int count) { return 100 * count / total; };
  if (share(dark) > 5) {
    findings.push_back({Severity::kWarning, "dark",
                        Format("%.0f %% of the images are dark (mean below 12 of 255): nothing to "
                               "track in them",
                               share(dark)),
                        "more light, longer exposure, more gain; is the lens covered?"});
  }
  if (share(burnt) > 5) {
    findings.push_back({Severity::kWarning, "burnt",
                        Format("%.0f %% of the images are overexposed (more than 40 %% of the "
                               "pixels at 250 or above)",
                               share(burnt)),
                        "shorter exposure, or automatic exposure on"});
  }
  if (share(same) > 2) {
    findings.push_back(
        {Severity::kError, "frozen",
         Format("%.0f %% of the images are the one before, byte for byte, with a new "
                "stamp",
                share(same)),
         "the driver repeats images; record those of the camera alone"});
  }
  // Half of a lens' own softness in a corner; a finger's breadth out of focus is a tenth.
  if (total > 0 && facts.sharpness < 0.25) {
    findings.push_back({Severity::kWarning, "blur",
                        Format("the images are blurred (fine structure %.2f of the coarse; sharp "
                               "ones have about 1)",
                               facts.sharpness),
                        "focus, clean the lens, shorten the exposure"});
  }
}

// How much later the right eye's images are: while the robot turns, points at infinity have the
// disparity of the turn in between.
struct EyeDelay {
  double delay_s = 0, sigma_s = 0;
};
std::optional<EyeDelay> FindEyeDelay(const ImageFacts& facts, const MotionSources& motion,
                                     double fx) {
  double rate_rate = 0, rate_low = 0, sum_rate = 0, sum_low = 0, low_low = 0;
  int count = 0;
  for (const PairFact& pair : facts.pairs) {
    const auto before = motion.Turned(pair.utime - Milliseconds(40));
    const auto after = motion.Turned(pair.utime + Milliseconds(40));
    if (!before || !after || pair.matches < 20) continue;
    const double rate = (*after - *before) / 0.08;
    // The robot turns to the left, the image to the right: a right image that is late is shifted to
    // the right, and its disparity is smaller.
    const double low = -pair.disparity_low_px / fx;
    rate_rate += rate * rate;
    rate_low += rate * low;
    sum_rate += rate;
    sum_low += low;
    low_low += low * low;
    ++count;
  }
  if (count < 10) return std::nullopt;
  const double n = count;
  const double variance = rate_rate - sum_rate * sum_rate / n;
  if (variance / n < 0.04) return std::nullopt;  // turned by less than 0.2 rad/s: nothing to tell
  const double covariance = rate_low - sum_rate * sum_low / n;
  const double slope = covariance / variance;
  const double rest = std::max(0.0, low_low - sum_low * sum_low / n - slope * covariance);
  return EyeDelay{slope, std::sqrt(rest / (n - 2) / variance)};
}

void CheckEyes(const LogFacts& facts, const RobotConfig& config, const MotionSources& motion,
               Findings& findings) {
  const ImageFacts& images = facts.images;
  const auto fail = [&](const char* id, std::string text, std::string fix) {
    findings.push_back({Severity::kError, id, std::move(text), std::move(fix)});
  };
  if (images.pairs.empty()) {
    fail("no-right-eye",
         "the configuration is of a stereo camera, the recording has no right images",
         "record both eyes, or set kind: rgbd");
    return;
  }
  int same = 0;
  for (const ImageFact& image : images.images) same += image.same_eyes;
  std::vector<PairFact> pairs;
  for (const PairFact& pair : images.pairs) {
    if (pair.matches >= 15) pairs.push_back(pair);
  }
  if (same * 20 > std::ssize(images.images)) {
    fail("one-eye-twice",
         Format("in %d of %d images the right eye is the left one, byte for byte", same,
                images.images.size()),
         "one camera is recorded twice: check the topics or cables");
    return;
  }
  if (pairs.size() < 4) return;  // too dark or too bare to tell; said by others
  const double disparity = MedianFact(pairs, &PairFact::disparity_median_px);
  const double row = MedianFact(pairs, &PairFact::row_offset_px);
  const double spread = MedianFact(pairs, &PairFact::row_spread_px);
  const double low = MedianFact(pairs, &PairFact::disparity_low_px);
  if (disparity < -0.5) {
    fail("eyes-swapped",
         Format("points of the right image lie to the right of those of the left "
                "one (median disparity %.1f px): the eyes are swapped",
                disparity),
         "exchange the topics or cables of the two eyes");
    return;
  }
  if (std::abs(disparity) < 0.3 && std::abs(low) < 0.5) {
    fail("one-eye-twice",
         Format("nothing has a disparity (median %.2f px): both eyes show the same "
                "image",
                disparity),
         "one camera is recorded twice: check the topics or cables");
    return;
  }
  // Half of the pixel that an observation is weighted with (docs/conventions.md, noise).
  if (std::abs(row) > 0.5 || spread > 0.5) {
    fail("rows",
         Format("rows of the two eyes are %.2f px apart (scatter %.2f px) after "
                "rectification: matches are lost, depth is wrong",
                row, spread),
         "calibrate the stereo camera anew (gw-calibrate-stereo refines the right eye)");
  }
  const auto delay = FindEyeDelay(images, motion, config.calibration.camera.left.fx);
  if (delay && std::abs(delay->delay_s) > std::max(0.004, 4 * delay->sigma_s)) {
    fail("eye-late",
         Format("the right eye is %.0f +- %.0f ms later than the left: depth is wrong "
                "whenever the robot turns",
                1e3 * delay->delay_s, 1e3 * delay->sigma_s),
         "trigger both eyes together; pair images by their number, not by arrival");
  }
}

void CheckDepth(const ImageFacts& images, const RobotConfig& config, Findings& findings) {
  const CameraCalibration& camera = config.calibration.camera;
  if (images.depths.empty()) {
    findings.push_back({Severity::kError, "no-depth",
                        "the configuration is of an RGB-D camera, the recording has no depth",
                        "record the depth that is aligned to the image, or set kind: stereo"});
    return;
  }
  const double measured = MedianFact(images.depths, &DepthFact::measured_share);
  const double usable = MedianFact(images.depths, &DepthFact::usable_share);
  const double median_m = MedianFact(images.depths, &DepthFact::median_m);
  if (measured < 0.1) {
    findings.push_back({Severity::kError, "depth-empty",
                        Format("only %.0f %% of the pixels have a depth", 100 * measured),
                        "is the projector on, the range right, the depth aligned?"});
  } else if (usable < 0.3) {
    findings.push_back(
        {Severity::kError, "depth-unit",
         Format("only %.0f %% of the depths are within %.2f to %.2f m; their median is %.3f m with "
                "a unit of %.6g m",
                100 * usable, camera.depth_min_m, camera.depth_max_m, median_m,
                camera.depth_unit_m),
         "state the unit of the depth images (depth_unit_m: 0.001 for millimetres)"});
  }
}

}  // namespace

Findings CheckImages(const LogFacts& facts, const RobotConfig& config,
                     const MotionSources& motion) {
  Findings findings;
  const ImageFacts& images = facts.images;
  if (images.images.empty()) return findings;
  const CameraCalibration& camera = config.calibration.camera;
  const ImageFact& first = images.images.front();
  if (first.width != camera.width || first.height != camera.height) {
    findings.push_back({Severity::kError, "image-size",
                        Format("the images are %d x %d, the configuration says %d x %d",
                               first.width, first.height, camera.width, camera.height),
                        "give the calibration of this size"});
    return findings;
  }
  CheckExposure(images, findings);
  if (camera.kind == CameraKind::kStereo) {
    CheckEyes(facts, config, motion, findings);
  } else {
    CheckDepth(images, config, findings);
  }
  const auto still = images.patterns.StaticShare([&](Utime t) { return motion.Turned(t); });
  if (still && *still > 0.15) {
    findings.push_back(
        {Severity::kError, "static-pattern",
         Format("%.0f %% of the structure stays in place while the robot turns: dots "
                "of a projector, dirt, a part of the robot, or a frozen image",
                100 * *still),
         "switch the emitter off for the images that are tracked, clean the lens"});
  }
  return findings;
}

}  // namespace gw::check
