#!/usr/bin/env python3
"""gw-dr-ekf with the live wheels and IMU of a simulated robot on a bus of its own: kill -9 costs no pose
but those of the time it was dead.

usage: dr_kill_test.py BIN_DIR MAPS_DIR WORK_DIR
Prints what it measured. Exit 0 ok, 1 failed, 77 skipped (says why).
"""
import os
import subprocess
import sys

from live_system import URL, System, busy, enter_private_network, rows

DOWN_S = 0.3
# The camera is as small as it may be: rendering must not disturb the clock.
SCENARIO = """
name: dr_kill
map: {maps}/office/map.yaml
waypoints: [[2.0, 2.0, 0.0], [13.0, 1.9, 1.57]]
camera: {{width: 64, height: 64, focal_px: 40, rate_hz: 1}}
"""


def main():
    bin_dir, maps, work = sys.argv[1:4]
    enter_private_network()
    os.makedirs(work, exist_ok=True)
    scenario, config = f"{work}/scenario.yaml", f"{work}/robot.yaml"
    with open(scenario, "w") as f:
        f.write(SCENARIO.format(maps=os.path.abspath(maps)))
    sim = [f"{bin_dir}/gw-sim", "--scenario", scenario]
    subprocess.run(sim + ["--duration", "0.5", "--log", f"{work}/config.lcm", "--config-out", config],
                   check=True, stderr=subprocess.DEVNULL)
    host_is_busy = busy()
    failures = 0
    for kill in (None, "gw-dr-ekf"):
        out = f"{work}/{kill or 'undisturbed'}"
        system = System(bin_dir, config, out, names=("gw-dr-ekf",))
        system.play_and_kill(sim + ["--duration", "10", "--realtime", "--lcm-url", URL], kill, down_s=DOWN_S)
        codes, _ = system.stop()
        times = [int(row["utime"]) * 1e-6 for row in rows(f"{out}/pose_times.csv")]
        gap = max(b - a for a, b in zip(times, times[1:]))
        # 0.3 s to start a process and hear its first samples; without a death, wheels and IMU at 50 Hz and more.
        bar = DOWN_S + 0.3 if kill else 0.1
        lasted = times[-1] - times[0]
        print(f"{kill or 'undisturbed'}: {len(times)} poses in {lasted:.1f} s, largest gap {gap:.3f} s (bar {bar}), "
              f"exit codes {codes}")
        if any(codes.values()) or lasted < 8:
            print("  FAILED: it lives to the end of the run, and SIGTERM ends it with 0")
            failures += 1
        elif gap > bar:
            print("  not judged: the gap" if host_is_busy else "  FAILED: no gap above the bar")
            failures += not host_is_busy
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
