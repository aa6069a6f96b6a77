#include "tools/data/fault/vision_faults.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "tools/data/fault/person.h"
#include "tools/data/fault/projector_dots.h"

namespace gw::fault {
namespace {

constexpr double kDepthScale = 1.1;
constexpr double kGains[] = {0.6, 1.4};
// What a finger or tape before half of the lens looks like: even grey with a soft edge.
constexpr double kCoverGrey = 90, kCoverShare = 0.9;
constexpr double kCoverBlur = 1.0 / 40;  // of the width of the image
constexpr double kKeyholeWidth = 0.1;    // of the width of the image

bool IsOfCamera(FaultTarget target) {
  return target == FaultTarget::kCamera || target == FaultTarget::kStereo ||
         target == FaultTarget::kRgbd;
}

void CoverLeftHalf(CameraImages* images) {
  const cv::Rect half(0, 0, images->left.cols / 2, images->left.rows);
  cv::Mat covered = images->left.clone();
  covered(half) = covered(half) * (1 - kCoverShare) + kCoverGrey * kCoverShare;
  cv::GaussianBlur(covered, covered, cv::Size(), kCoverBlur * images->left.cols);
  covered(half).copyTo(images->left(half));
  if (!images->depth.empty()) images->depth(half) = 0;
}

void DarkenButKeyhole(CameraImages* images) {
  const auto keep_middle = [](cv::Mat* image) {
    if (image->empty()) return;
    const int width = static_cast<int>(kKeyholeWidth * image->cols);
    const cv::Rect hole((image->cols - width) / 2, (image->rows - width) / 2, width, width);
    cv::Mat dark = cv::Mat::zeros(image->size(), image->type());
    (*image)(hole).copyTo(dark(hole));
    *image = dark;
  };
  for (cv::Mat* image : {&images->left, &images->right, &images->depth}) keep_middle(image);
}

}  // namespace

VisionFaults::VisionFaults(const std::vector<NamedFault>& faults, const CameraOptics& optics)
    : optics_(optics) {
  for (const NamedFault& fault : faults) {
    if (IsOfCamera(fault.kind().target)) faults_.push_back(fault);
  }
}

std::optional<wire::Bytes> VisionFaults::Apply(DurationUs since_begin, const CameraFrame& frame) {
  CameraImages images = CopyImages(frame);
  CameraImages as_it_came = CopyImages(frame);
  bool edited = false;
  for (const NamedFault& fault : faults_) {
    if (!fault.span.Contains(since_begin)) continue;
    Edit(fault, since_begin, &images);
    edited = true;
  }
  previous_ = std::move(as_it_came);
  ++frames_;
  if (!edited) return std::nullopt;
  return EncodeWith(frame, images);
}

void VisionFaults::Edit(const NamedFault& fault, DurationUs since_begin,
                        CameraImages* images) const {
  const bool stereo = !images->right.empty();
  switch (fault.id) {
    case FaultId::kDots:
      return DrawProjectorDots(optics_, images);
    case FaultId::kRightLate:
      if (stereo && !previous_.right.empty()) images->right = previous_.right;
      return;
    case FaultId::kSameEye:
      if (stereo) images->right = images->left;
      return;
    case FaultId::kEyesSwapped:
      if (stereo) std::swap(images->left, images->right);
      return;
    case FaultId::kDepthLate:
      if (!images->depth.empty() && !previous_.depth.empty()) images->depth = previous_.depth;
      return;
    case FaultId::kDepthScaled:
      if (!images->depth.empty()) images->depth *= kDepthScale;
      return;
    case FaultId::kPerson:
      return DrawPerson(optics_, since_begin - fault.span.begin, images);
    case FaultId::kFlicker:
      for (cv::Mat* image : {&images->left, &images->right}) *image *= kGains[frames_ % 2];
      return;
    case FaultId::kHalfCovered:
      return CoverLeftHalf(images);
    case FaultId::kKeyhole:
      return DarkenButKeyhole(images);
    default:
      return;
  }
}

}  // namespace gw::fault
