#!/usr/bin/env python3
"""Ten faults, shown through the page of gw-view alone: one live run of the whole system for each, and screenshots of it.

usage: fault_screens.py BIN PAGE_WORK OUT KEY [SEED]
OUT/01 to OUT/10 hold 1.png and 2.png each, two moments of one run, in an order that SEED shuffles; the file KEY, which is not in
OUT, says which is which: to be opened after they have been named.
Needs Debian's chromium, node, the npm packages of the page, lcm-logplayer. Exit 77 where there is no private network.
"""
import os
import random
import subprocess
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, f"{HERE}/../../test/multiproc")
from live_system import URL, enter_private_network  # noqa: E402

SCENARIO = """name: faults
map: {root}/config/scenarios/maps/office/map.yaml
waypoints: [[9.5, 2.0, 0.0], [12.5, 2.0, 0.0], [12.8, 4.5, 1.57], [11.0, 4.5, 3.14]]
visit: [0, 1, 2, 3]
drive: {{max_m_s: 0.5, max_deg_s: 60, turn_at_waypoints: false, pause_s: 0}}
world: {{walls: textured, floor: wood}}
camera: {{rate_hz: 10, mode: stereo, width: 320, height: 240, focal_px: 190}}
"""
MOMENTS = (9, 13)  # s of the drive at which pictures are taken; the log goes on
KILLED = 6.5  # s, where the fault is a process that dies
# Name: options of gw-fault, or a process that is killed in the middle and not started again.
FAULTS = {
    "lights out": ["--black", "6:"],
    "camera hangs": ["--drop", "6:"],
    "eyes swapped": ["--fault", "eyes_swapped"],
    "one eye twice": ["--fault", "same_eye"],
    "projector dots": ["--fault", "dots"],
    "wheels reversed": ["--fault", "wheels_reversed"],
    "gyro in degrees": ["--fault", "gyro_deg"],
    "IMU clock an hour ahead": ["--fault", "imu_hour_off"],
    "wheels stand still": ["--fault", "wheels_stuck"],
    "dead reckoning killed": "gw-dr-ekf",
}


class Run:
    """The system on one log, until it is left."""

    def __init__(self, binaries, config):
        self.binaries, self.config = binaries, config
        self.processes = {name: self.start(name) for name in ("gw-backend", "gw-dr-ekf", "gw-frontend")}
        self.view = self.start("gw-view", "--listen", "127.0.0.1:0")
        self.address = self.view.stdout.readline().strip()

    def start(self, name, *options):
        return subprocess.Popen([f"{self.binaries}/{name}", "--config", self.config, "--lcm-url", URL, *options],
                                stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)

    def end(self):
        for process in [*self.processes.values(), self.view]:
            process.kill()
            process.wait()


def show(binaries, config, log, killed, folder):
    os.makedirs(folder, exist_ok=True)
    run = Run(binaries, config)
    pictures = [argument for i, moment in enumerate(MOMENTS, 1) for argument in (str(moment), f"{folder}/{i}.png")]
    shot = subprocess.Popen(["node", f"{HERE}/page/test/screenshot.mjs", run.address, *pictures], stdout=subprocess.PIPE, text=True)
    shot.stdout.readline()
    player = subprocess.Popen(["lcm-logplayer", f"--lcm-url={URL}", "--regexp=^(CAMERA|IMU|WHEEL|GROUND_TRUTH)$", log],
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    if killed:
        time.sleep(KILLED)
        run.processes[killed].kill()
    code = shot.wait()
    player.kill()
    player.wait()
    run.end()
    return code == 0


def main():
    binaries, packages, out, key_file = (os.path.abspath(argument) for argument in sys.argv[1:5])
    enter_private_network()
    os.environ["GW_PAGE_PACKAGES"] = packages
    os.environ.setdefault("GW_CHROMIUM", "/usr/bin/chromium")
    names = list(FAULTS)
    random.Random(sys.argv[5] if len(sys.argv) > 5 else None).shuffle(names)
    with tempfile.TemporaryDirectory() as work:
        shown = show_all(binaries, names, out, key_file, work)
    sys.exit(0 if shown else 1)


def show_all(binaries, names, out, key_file, work):
    with open(f"{work}/scenario.yaml", "w", encoding="utf-8") as f:
        f.write(SCENARIO.format(root=os.path.abspath(f"{HERE}/../..")))
    log, config = f"{work}/sound.lcm", f"{work}/robot.yaml"
    subprocess.run([f"{binaries}/gw-sim", "--scenario", f"{work}/scenario.yaml", "--duration", str(MOMENTS[-1] + 10), "--log", log,
                    "--config-out", config], check=True, capture_output=True)
    shown = True
    with open(key_file, "w", encoding="utf-8") as key:
        for number, name in enumerate(names, 1):
            fault = FAULTS[name]
            killed = fault if isinstance(fault, str) else None
            spoilt = log
            if not killed:
                spoilt = f"{work}/spoilt.lcm"
                subprocess.run([f"{binaries}/gw-fault", log, spoilt, "--config", config, *fault], check=True, capture_output=True)
            shown = show(binaries, config, spoilt, killed, f"{out}/{number:02}") and shown
            key.write(f"{number:02} {name}\n")
    return shown


if __name__ == "__main__":
    main()
