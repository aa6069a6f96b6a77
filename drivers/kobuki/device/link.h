// Decides when to open and reopen the port, and what to say about it: absent, silent, garbage or
// talking. A base that is switched off while its cable is in leaves the port in place; the two need
// different things from people. No I/O and no clock: events and times go in, decisions come out.
#pragma once

#include <optional>

#include "common/core/time.h"

namespace gw::kobuki {

enum class LinkState {
  kAbsent,      // the port cannot be opened
  kConnecting,  // just opened; the first frame may be on its way
  kSilent,      // the port is open, but nothing comes: the base is switched off
  kGarbage,     // bytes come, but no valid frame: another device, or a broken cable
  kTalking,
};

class Link {
 public:
  bool open() const { return opened_.has_value(); }

  bool ShouldOpen(Utime now) const;
  void OpenFailed(Utime now);
  void Opened(Utime now);
  void Bytes(Utime now);  // something came
  void Frame(Utime now);  // a valid frame came
  // To be called after the port was closed, because the device is gone or was given up.
  void Closed(Utime now);

  // True when the port is open but no frame came for so long that a new try may help: the adapter
  // may hang, or the symbolic link may point elsewhere now. It is tried less and less often while
  // it does not help.
  bool ShouldReopen(Utime now) const;

  LinkState state(Utime now) const;
  int64_t opens() const { return opens_; }

  static constexpr DurationUs kFirstBackoff{250'000};
  static constexpr DurationUs kMaxBackoff{5'000'000};
  static constexpr DurationUs kSilent{500'000};
  static constexpr DurationUs kGiveUp{2'000'000};

 private:
  std::optional<Utime> opened_;
  std::optional<Utime> last_bytes_;
  std::optional<Utime> last_frame_;
  std::optional<Utime> retry_;
  DurationUs backoff_ = kFirstBackoff;
  int64_t opens_ = 0;
};

}  // namespace gw::kobuki
