"""recordings_study.py BIN DATA [--draws N] [--keep DIR]: gw-calibrate drive on recordings that this project did not make.

DATA is the folder of the shared recordings. Each recording is imported, its extrinsics in the configuration and its wheels and gyro in the
log are spoilt N times by errors that are known (drive_study.py: 3 deg, 5 cm, 3 %, track x0.4 to x2.5, 50 ms), and what is found is
compared with the truth: the camera's place as the recording states it, the scales and the delay of the wheels by least squares of
their increments over the recording's ground truth, the gyro's as 1 and 0. Three of the OpenLORIS recordings, which have no images, are
also driven along with a rendered camera: real odometry, with the simulator's camera and IMU. Prints a line for each draw and a table as
drive_study.py does. Recordings that cannot be calibrated (no images; a corridor without texture) are listed with what gw-calibrate says.
Exit 1 when less than 80 % of what is said to be known is within what is wanted, or less than 80 % of all inside the covariance, or
nothing was found; 77 without DATA.
"""
import argparse
import os
import struct
import subprocess
import sys
import tempfile

import numpy as np

from drive_study import QUANTITIES, Tally, add_drive, calibrate, draw, misplace, print_table, spoil
from faults_test import ROOT, read, write

RECORDINGS = [("night, stereo", "euroc", "rendered_night"), ("night, RGB-D", "openloris", "rendered_night/openloris"),
              ("corridor, stereo", "euroc", "rendered_corridor")]
WITHOUT_IMAGES = ["cafe-1-1", "corridor-1-1", "corridor-1-3", "home-1-1", "home-1-2", "market-1-1"]
REAL_WHEELS = ["cafe-1-1", "home-1-1", "corridor-1-3"]
# Camera and IMU of the simulator, which are where the configuration says, on the way of a recorded robot.
SCENARIO = """name: recorded
map: {root}/config/scenarios/maps/office/map.yaml
waypoints: [[2.0, 2.0, 0.0], [13.0, 1.9, 1.57]]
camera: {{width: 320, height: 240, focal_px: 193, rate_hz: 10}}
world: {{walls: textured, floor: wood}}
mounting: {{camera_deg: 0, camera_m: 0}}
imu: {{gyro_scale_error: 0}}
"""
DELAYS = np.arange(-0.06, 0.0601, 0.002)  # s


def planar_sums(log):
    """Times (s), way along the body's x axis and turn (rad), summed, of the ground truth in a log."""
    rows = []
    with open(log, "rb") as f:
        while head := f.read(28):
            size, length = struct.unpack(">II", head[20:])
            channel, payload = f.read(size), f.read(length)
            if channel == b"GROUND_TRUTH":
                rows.append(struct.unpack_from(">qq7d", payload, 8))
    t, _, x, y, _, qw, qx, qy, qz = np.array(rows).T
    yaw = np.unwrap(np.arctan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz)))
    middle = yaw[:-1] + np.diff(yaw) / 2
    way = np.append(0, np.cumsum(np.diff(x) * np.cos(middle) + np.diff(y) * np.sin(middle)))
    return t * 1e-6, way, yaw - yaw[0]


def wheel_truth(events, truth):
    """Scales of way and turn (true over measured) and delay (s) of the wheels, by least squares over steps of half a second; the delay
    is that of both together, each weighted by what is left of it."""
    wheels = [message for _, channel, message in events if channel == "WHEEL"]
    time = np.array([m.utime for m in wheels]) * 1e-6
    way, turn = np.cumsum([m.dx for m in wheels]), np.cumsum([m.dyaw for m in wheels])
    t, true_way, true_turn = truth
    grid = np.arange(t[0] + 0.1, t[-1] - 0.1, 0.5)

    def fit(delay):
        cost, scales = 0, []
        for measured, true in ((way, true_way), (turn, true_turn)):
            a, b = np.diff(np.interp(grid + delay, time, measured)), np.diff(np.interp(grid, t, true))
            scales.append(a @ b / (a @ a))
            cost += np.log(np.mean(np.square(b - scales[-1] * a)))
        return cost, scales
    costs = [fit(delay)[0] for delay in DELAYS]
    low = int(np.clip(np.argmin(costs), 1, len(DELAYS) - 2))
    curve = np.polyfit(DELAYS[low - 1:low + 2], costs[low - 1:low + 2], 2)
    delay = -curve[1] / (2 * curve[0])
    return *fit(delay)[1], delay


def import_recording(binaries, reader, source, folder):
    os.makedirs(folder, exist_ok=True)
    subprocess.run([f"{binaries}/gw-import", reader, source, "--no-check", "--out", f"{folder}/good.lcm", "--config-out",
                    f"{folder}/good.yaml"], check=True, capture_output=True)


def render_along(binaries, source, folder):
    """The recorded robot's way and odometry, with the simulator's camera and IMU."""
    os.makedirs(folder, exist_ok=True)
    with open(f"{folder}/s.yaml", "w", encoding="utf-8") as f:
        f.write(SCENARIO.format(root=ROOT))
    subprocess.run([f"{binaries}/gw-sim", "--scenario", f"{folder}/s.yaml", "--trajectory", f"{source}/groundtruth.txt", "--odometry",
                    f"{source}/odom.txt", "--duration", "60", "--log", f"{folder}/good.lcm", "--config-out", f"{folder}/good.yaml"],
                   check=True, capture_output=True)


def run_draw(binaries, folder, seed, scales):
    """(true values, what was found), or what gw-calibrate says where it refuses."""
    errors = draw(np.random.default_rng(1000 + seed))
    write(f"{folder}/spoilt.lcm", spoil(read(f"{folder}/good.lcm"), errors))
    with open(f"{folder}/good.yaml", encoding="utf-8") as good, open(f"{folder}/spoilt.yaml", "w", encoding="utf-8") as spoilt:
        spoilt.write(misplace(good.read(), errors.degrees, errors.metres))
    found, refusal = calibrate(binaries, folder)
    if found is None:
        return refusal
    way, turn, delay = scales
    return [*errors.degrees, *errors.metres[:2], errors.way * way, errors.track * turn, errors.gyro, delay + errors.wheel_us * 1e-6,
            errors.gyro_us * 1e-6], found


def run_draws(binaries, name, folder, draws, tallies):
    scales = wheel_truth(read(f"{folder}/good.lcm"), planar_sums(f"{folder}/good.lcm"))
    print("%s: by ground truth, wheels' way %.4f, turn %.4f, delay %.4f s" % (name, *scales), flush=True)
    for seed in range(draws):
        result = run_draw(binaries, folder, seed, scales)
        if isinstance(result, str):
            print(f"{name}: {result}", flush=True)
            return
        print(f"{name}, draw {seed}: {add_drive(tallies, *result)}", flush=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("binaries")
    parser.add_argument("data")
    parser.add_argument("--draws", type=int, default=5)
    parser.add_argument("--keep", help="folder for the imported recordings")
    arguments = parser.parse_args()
    if not os.path.isdir(arguments.data):
        print(f"skipped: {arguments.data} is not there")
        sys.exit(77)
    tallies = [Tally() for _ in QUANTITIES]
    with tempfile.TemporaryDirectory() as temporary:
        for name, reader, source in RECORDINGS:
            folder = os.path.join(arguments.keep or temporary, name.replace(", ", "_"))
            import_recording(arguments.binaries, reader, os.path.join(arguments.data, source), folder)
            run_draws(arguments.binaries, name, folder, arguments.draws, tallies)
        for name in REAL_WHEELS:
            folder = os.path.join(arguments.keep or temporary, f"rendered_{name}")
            render_along(arguments.binaries, os.path.join(arguments.data, "openloris_odometry", name), folder)
            run_draws(arguments.binaries, f"{name}, rendered", folder, arguments.draws, tallies)
        for name in WITHOUT_IMAGES:
            folder = os.path.join(arguments.keep or temporary, name)
            import_recording(arguments.binaries, "openloris", os.path.join(arguments.data, "openloris_odometry", name), folder)
            for end in ("lcm", "yaml"):
                os.replace(f"{folder}/good.{end}", f"{folder}/spoilt.{end}")
            print(f"{name}: {calibrate(arguments.binaries, folder)[1]}", flush=True)
    sys.exit(print_table(tallies))


if __name__ == "__main__":
    main()
