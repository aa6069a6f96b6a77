#include "drivers/kobuki/core/safety_guard.h"

namespace gw::kobuki {

void SafetyGuard::Sense(const ContactFlags& contact, Utime now) {
  Sense(contact.bumper, now, &bumper_);
  Sense(contact.cliff, now, &cliff_);
  Sense(contact.wheel_drop, now, &drop_);
}

void SafetyGuard::Sense(bool active, Utime now, Block* block) {
  block->active = active;
  if (!active) return;
  stops_ += !block->blocked;
  block->acknowledged = block->blocked && block->acknowledged;
  block->blocked = true;
  block->last_active = now;
}

void SafetyGuard::Release(bool acknowledges, DurationUs clear_for, Utime now, Block* block) {
  if (!block->blocked) return;
  block->acknowledged = block->acknowledged || acknowledges;
  if (!block->active && block->acknowledged && now - block->last_active >= clear_for) *block = {};
}

Twist SafetyGuard::Filter(const Twist& wanted, Utime now) {
  const bool forward = wanted.v_m_s > 0;
  Release(!forward, kClearForContact, now, &bumper_);
  Release(!forward, kClearForContact, now, &cliff_);
  // A stop acknowledges only on the floor: one that was sent while the base was carried says
  // nothing.
  Release(!drop_.active && wanted.v_m_s == 0 && wanted.w_rad_s == 0, kClearForDrop, now, &drop_);
  if (drop_.blocked) return {};
  if ((bumper_.blocked || cliff_.blocked) && forward) return {};
  return wanted;
}

SafetyGuard::Stop SafetyGuard::stop() const {
  if (drop_.blocked) return Stop::kWheelDrop;
  if (cliff_.blocked) return Stop::kCliff;
  if (bumper_.blocked) return Stop::kBumper;
  return Stop::kNone;
}

}  // namespace gw::kobuki
