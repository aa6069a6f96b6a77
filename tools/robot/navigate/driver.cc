#include "tools/robot/navigate/driver.h"

namespace gw::navigate {

const char* EventName(EventKind kind) {
  switch (kind) {
    case EventKind::kLeg:
      return "leg";
    case EventKind::kReached:
      return "reached";
    case EventKind::kUnreachable:
      return "unreachable";
    case EventKind::kHeld:
      return "held";
    case EventKind::kResumed:
      return "resumed";
    case EventKind::kBumped:
      return "bumped";
    case EventKind::kBlocked:
      return "blocked";
    case EventKind::kFinished:
      return "finished";
  }
  return "";
}

}  // namespace gw::navigate
