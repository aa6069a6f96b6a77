// What to do about a HEALTH message, in the words of deploy/runbook.md.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "common/contract/health.h"

namespace gw::foxglove {

struct Advice {
  std::string_view process;  // "": any
  std::string_view text;     // part of the HEALTH message
  std::string_view action;   // as in the runbook; advice_test.cc compares the two
};

inline constexpr std::array<Advice, 32> kAdvice{{
    {"", "are refused: ",
     "the process that sends CHANNEL (`gw-log check` on a recording names the field)"},
    {"gw-frontend", "waiting for the map", "status of gw-backend"},
    {"gw-frontend", "no images", "gw-camera's HEALTH, USB cable"},
    {"gw-frontend", "no map can be begun",
     "`gw-check` a recording; look at the image in gw-view; drive to where there is texture"},
    {"gw-frontend", "are the same image", "mend the streams; dead reckoning carries on"},
    {"gw-frontend", "are exchanged", "swap them back; dead reckoning carries on"},
    {"gw-frontend", "not of one instant", "synchronise the camera; depth is not used until then"},
    {"gw-frontend", "does not move",
     "switch the projector off, clean the lens; dead reckoning carries on"},
    {"gw-frontend", "does not fit to where dead reckoning is",
     "let them pass; drive on slowly: dead reckoning carries the pose; carried robots are found "
     "again where the map is"},
    {"gw-frontend", "vision sees nothing",
     "clean the lens, light; POSE stays usable, its covariance grows"},
    {"gw-frontend", "neither vision nor dead reckoning",
     "stop driving; gw-dr-ekf, then light and lens"},
    {"gw-frontend", "dead reckoning contradicts",
     "check wheel calibration, axes, signs and units; `gw-slam LOG --dr-only` names more"},
    {"gw-frontend", "wrong by a constant",
     "it goes on, the constant is taken out; set the value it says and restart"},
    {"gw-frontend", "lengths that the camera tells",
     "it goes on, they are corrected; set the value it says and begin a new map"},
    {"gw-frontend", "where in the map is not known",
     "drive to where the map was made, or begin a new map"},
    {"gw-grid", "no images", "gw-camera's HEALTH, USB cable"},
    {"gw-grid", "have no pose", "status of gw-frontend"},
    {"gw-grid", "kind and size", "one YAML for all, restart"},
    {"gw-grid", "cannot be saved", "free space under `/var/lib/good-weights`"},
    {"gw-backend", "",
     "free space under `/var/lib/good-weights`; the map in memory is whole and is written as soon "
     "as "
     "it can be"},
    {"gw-dr-ekf", "no IMU, wheel or DR message", "HEALTH of gw-camera and gw-kobuki"},
    {"gw-dr-ekf", "silent", "cables; base switched on?"},
    {"gw-kobuki", "no such device", "cable; `ls -l /dev/kobuki`"},
    {"gw-kobuki", "no Kobuki found", "cable; `ls -l /dev/kobuki`"},
    {"gw-kobuki", "permission", "`udevadm trigger`; `fuser /dev/kobuki`"},
    {"gw-kobuki", "firmware", "firmware 1.x is needed"},
    {"gw-kobuki", "the base is silent", "switch it on"},
    {"gw-kobuki", "no data from the base", "switch it on"},
    {"gw-kobuki", "bumper", "back off or put it on the floor"},
    {"gw-kobuki", "cliff", "back off or put it on the floor"},
    {"gw-kobuki", "battery low", "charge"},
    {"gw-record", "not recorded", "free space, smaller `GW_RECORD_GB`"},
}};

inline constexpr std::string_view kSilentAction =
    "`systemctl status NAME`; `journalctl -u NAME -n 30`; `ip route get 239.255.76.67` must say "
    "`dev "
    "lo`";

// Empty when the runbook has nothing on it.
std::string AdviceFor(const Health& health);
// For a process whose HEALTH does not come any more.
std::string AdviceForSilent(const std::string& process);

}  // namespace gw::foxglove
