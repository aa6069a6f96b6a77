#include "frontend/core/features/view_fault.h"

namespace gw::frontend {

std::string_view Describe(ViewFault fault) {
  switch (fault) {
    case ViewFault::kNone:
      break;
    case ViewFault::kFlickers:
      return "the image's brightness jumps from image to image: check exposure control, and lamps "
             "that flicker";
    case ViewFault::kLeftCovered:
      return "what moves to the left of the image is lost there: is the lens covered or dirty?";
    case ViewFault::kRightCovered:
      return "what moves to the right of the image is lost there: is the lens covered or dirty?";
    case ViewFault::kDepthLate:
      return "depth images are late: of the moment before that of the grey ones that they come "
             "with, which is measured and corrected: check the camera's synchronisation, and how "
             "driver or bag pair images";
    case ViewFault::kDepthEarly:
      return "depth images are early: of the moment after that of the grey ones that they come "
             "with, which is measured and corrected: check the camera's synchronisation, and how "
             "driver or bag pair images";
  }
  return "";
}

}  // namespace gw::frontend
