#include "drivers/kobuki/device/link.h"

#include <algorithm>

namespace gw::kobuki {

bool Link::ShouldOpen(Utime now) const {
  return !open() && (!retry_ || now >= *retry_);
}

void Link::OpenFailed(Utime now) {
  retry_ = now + backoff_;
  backoff_ = std::min(DurationUs{2 * backoff_.us}, kMaxBackoff);
}

void Link::Opened(Utime now) {
  opened_ = now;
  last_bytes_.reset();
  last_frame_.reset();
  ++opens_;
}

void Link::Bytes(Utime now) {
  last_bytes_ = now;
}

void Link::Frame(Utime now) {
  last_frame_ = now;
  backoff_ = kFirstBackoff;
}

void Link::Closed(Utime now) {
  opened_.reset();
  OpenFailed(now);
}

bool Link::ShouldReopen(Utime now) const {
  if (!open()) return false;
  const Utime since = last_frame_ ? *last_frame_ : *opened_;
  return now - since > kGiveUp + backoff_;
}

LinkState Link::state(Utime now) const {
  if (!open()) return LinkState::kAbsent;
  if (last_frame_ && now - *last_frame_ <= kSilent) return LinkState::kTalking;
  if (!last_frame_ && now - *opened_ <= kSilent) return LinkState::kConnecting;
  if (last_bytes_ && now - *last_bytes_ <= kSilent) return LinkState::kGarbage;
  return LinkState::kSilent;
}

}  // namespace gw::kobuki
