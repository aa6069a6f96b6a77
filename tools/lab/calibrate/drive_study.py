"""drive_study.py BIN [--drives N] [--first SEED] [--seconds S] [--keep DIR]: gw-calibrate drive on simulated drives with random errors.

Each drive (40 s through an office, stereo, another way and another seed) is spoilt by errors that are known: the camera's rotation and
place in the configuration (3 deg, 5 cm), scales of way, turn (as a track that is x0.4 to x2.5) and gyro (3 %), delays of wheels and IMU
(50 ms). The base, the gyro and the camera's bracket of the simulator have no scale, stamp or mounting errors of their own here; wheel
slip, side slip, shake, noise and biases stay. Prints a line for
each drive and a table: how many errors are within what is wanted (0.1 deg, 5 mm, 0.2 %, 3 ms), of those that are said to be known as well
as that and of those that are said not to be ("not yet to", * in the line of the drive), how many quantities were said to be undetermined,
and how many errors are inside the covariance (90 % are meant to be within 1.645 standard deviations). Exit 1 when fewer than 80 % of the
errors that are said to be known are within what is wanted, or fewer than 80 % of all inside the covariance.
"""
import argparse
import os
import re
import subprocess
import sys
import tempfile

import numpy as np

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "check"))
from faults_test import ROOT, each, later, read, scaled, write  # pylint: disable=wrong-import-position

SCENARIO = """name: calibrate
seed: {seed}
map: {root}/config/scenarios/maps/office/map.yaml
waypoints: [[9.5, 2.0, 0.0], [12.5, 2.0, 0.0], [12.8, 4.5, 1.57], [11.0, 4.5, 3.14], [11.0, 2.5, -1.57], [7.5, 2.0, 0.0]]
visit: [{visit}]
drive: {{max_m_s: 0.6, max_deg_s: 60, turn_at_waypoints: {turn}, pause_s: 0}}
world: {{walls: textured, floor: wood}}
camera: {{rate_hz: 10, mode: stereo, width: 320, height: 240, focal_px: 190}}
base: {{scale_error: 0, wheel_difference: 0, track_error: 0, odometry_hz: 0}}
mounting: {{camera_deg: 0, camera_m: 0}}
imu: {{gyro_scale_error: 0}}
"""
QUANTITIES = ["camera roll", "camera pitch", "camera yaw", "camera x", "camera y", "wheel way scale", "wheel turn scale",
              "gyro turn scale", "wheel delay", "gyro delay"]
WANTED = [0.1, 0.1, 0.1, 0.005, 0.005, 0.002, 0.002, 0.002, 0.003, 0.003]  # scales: of the true one
T_BC = re.compile(r"T_BC: \{p: \[([^\]]*)\], q_wxyz: \[([^\]]*)\]\}")


def multiply(a, b):
    w, v, x, u = a[0], a[1:], b[0], b[1:]
    return np.concatenate([[w * x - v @ u], w * u + x * v + np.cross(v, u)])


def turn(degrees):
    vector = np.radians(degrees)
    angle = np.linalg.norm(vector)
    return np.concatenate([[np.cos(angle / 2)], np.sin(angle / 2) * vector / angle])


def misplace(text, degrees, metres):
    """The configuration whose T_BC has to be turned by `degrees` (body axes) and moved by `metres` to be right again."""
    p, q = (np.array([float(v) for v in part.split(",")]) for part in T_BC.search(text).groups())
    p, q = p - metres, multiply(turn(-degrees), q)
    return T_BC.sub(f"T_BC: {{p: {p.tolist()}, q_wxyz: {q.tolist()}}}", text, count=1)


def parse(text):
    """name -> (value, sigma, said to be known as well as is wanted), None where it was said to be undetermined."""
    found = {}
    for name in QUANTITIES:
        line = next(line for line in text.splitlines() if line.strip().startswith(name + " "))
        numbers = re.search(r"(-?[\d.]+) \+- ([\d.]+)", line)
        found[name] = (*(float(v) for v in numbers.groups()), "not yet" not in line) if numbers else None
    return found


def record(binaries, folder, seed, seconds, visit):
    with open(f"{folder}/s.yaml", "w", encoding="utf-8") as f:
        f.write(SCENARIO.format(root=ROOT, seed=seed + 1, visit=", ".join(map(str, visit * 3)),
                                turn="true" if seed % 2 else "false"))
    subprocess.run([f"{binaries}/gw-sim", "--scenario", f"{folder}/s.yaml", "--duration", str(seconds), "--log",
                    f"{folder}/good.lcm", "--config-out", f"{folder}/good.yaml"], check=True, capture_output=True)


class Errors:
    """What a robot is off by: rotation (deg) and place (m) of its camera, scales (true over measured), delays (us)."""

    def __init__(self, degrees, metres, way, gyro, track, wheel_us, gyro_us):
        self.degrees, self.metres, self.way, self.gyro, self.track = degrees, metres, way, gyro, track
        self.wheel_us, self.gyro_us = int(wheel_us), int(gyro_us)


def draw(rng):
    degrees, metres = rng.uniform(-3, 3, 3), np.append(rng.uniform(-0.05, 0.05, 2), 0)
    way, gyro = rng.uniform(0.97, 1.03, 2)
    track = np.exp(rng.uniform(np.log(0.4), np.log(2.5)))
    return Errors(degrees, metres, way, gyro, track, *rng.integers(-50_000, 50_000, 2))


def spoil(events, errors):
    """The events as the wheels and the gyro with these errors tell them."""
    events = scaled("WHEEL", 1 / errors.way, "dx", "dy")(scaled("WHEEL", 1 / errors.track, "dyaw")(events))
    events = later("IMU", errors.gyro_us)(scaled("IMU", 1 / errors.gyro, "wx", "wy", "wz")(later("WHEEL", errors.wheel_us)(events)))
    return each("WHEEL", lambda m, _: setattr(m, "has", False))(events)


def calibrate(binaries, folder):
    """(what was found in spoilt.lcm, None), or (None, what gw-calibrate says where it refuses)."""
    done = subprocess.run([f"{binaries}/gw-calibrate", "drive", f"{folder}/spoilt.lcm", "--config", f"{folder}/spoilt.yaml",
                           "--config-out", f"{folder}/out.yaml"], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        return None, f"exit {done.returncode}: {done.stderr.strip().replace(folder + '/', '')}"
    return parse(done.stdout), None


def run_drive(binaries, folder, seed, seconds, keep):
    """(true values, what was found), or None where the drive could not be made or gw-calibrate refused."""
    rng = np.random.default_rng(seed)
    visit = list(range(6))
    rng.shuffle(visit)
    os.makedirs(folder, exist_ok=True)
    if not keep or not os.path.exists(f"{folder}/good.lcm"):
        try:
            record(binaries, folder, seed, seconds, visit)
        except subprocess.CalledProcessError as error:
            print(f"drive {seed}: {error.stderr.decode().strip().splitlines()[-1]}", flush=True)
            return None
    errors = draw(rng)
    write(f"{folder}/spoilt.lcm", spoil(read(f"{folder}/good.lcm"), errors))
    with open(f"{folder}/good.yaml", encoding="utf-8") as f:
        text = f.read()
    with open(f"{folder}/spoilt.yaml", "w", encoding="utf-8") as f:
        f.write(misplace(text, errors.degrees, errors.metres))
    stated = re.search(r"wheel:.*?time_offset_s: ([\d.]+)", text, re.DOTALL)
    truth = [*errors.degrees, *errors.metres[:2], errors.way, errors.track, errors.gyro,
             (float(stated.group(1)) if stated else 0) + errors.wheel_us * 1e-6, errors.gyro_us * 1e-6]
    found, refusal = calibrate(binaries, folder)
    if found is None:
        print(f"drive {seed}: {refusal}", flush=True)
        return None
    return truth, found


class Tally:
    """Of one quantity, over all drives."""

    def __init__(self):
        self.exact = self.exact_within = self.coarse = self.coarse_within = self.inside = self.silent = 0
        self.errors = []

    def add(self, error, sigma, exact, wanted):
        self.errors.append(error)
        self.exact += exact
        self.exact_within += exact and abs(error) <= wanted
        self.coarse += not exact
        self.coarse_within += not exact and abs(error) <= wanted
        self.inside += abs(error) <= 1.645 * sigma

    def row(self, name, wanted):
        rmse = np.sqrt(np.mean(np.square(self.errors))) if self.errors else float("nan")
        return (f"| {name} | {rmse:.4f} ({wanted}) | {self.exact_within} of {self.exact} | {self.coarse_within} of {self.coarse} | "
                f"{self.silent} | {self.inside} of {len(self.errors)} |")


def add_drive(tallies, truth, found):
    """The drive's line: errors, with standard deviations."""
    line = []
    for name, wanted, tally, true in zip(QUANTITIES, WANTED, tallies, truth):
        if found[name] is None:
            tally.silent += 1
            line.append("-")
            continue
        value, sigma, exact = found[name]
        relative = true if "scale" in name else 1
        tally.add((value - true) / relative, sigma / relative, exact, wanted)
        line.append(f"{(value - true) / relative:+.4f}({sigma / relative:.4f}){'' if exact else '*'}")
    return " ".join(line)


def print_table(tallies):
    """Prints the table and its sum; the exit code."""
    print("| quantity | RMSE (wanted) | within, said to be known | within, said to be coarse | undetermined | inside 90 % |")
    print("| --- | --- | --- | --- | --- | --- |")
    for name, wanted, tally in zip(QUANTITIES, WANTED, tallies):
        print(tally.row(name, wanted))
    exact, within, coarse, coarse_within, inside, silent = (
        sum(getattr(t, k) for t in tallies) for k in ("exact", "exact_within", "coarse", "coarse_within", "inside", "silent"))
    print(f"{within} of {exact} that are said to be known are within what is wanted, {coarse_within} of {coarse} of the coarse ones; "
          f"{inside} of {exact + coarse} inside 90 %, {silent} said to be undetermined")
    return 1 if exact == 0 or within < 0.8 * exact or inside < 0.8 * (exact + coarse) else 0


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("binaries")
    parser.add_argument("--drives", type=int, default=20)
    parser.add_argument("--first", type=int, default=0, help="seed of the first drive")
    parser.add_argument("--seconds", type=int, default=40)
    parser.add_argument("--keep", help="folder for the recordings, a subfolder a drive; those that are there are used again")
    arguments = parser.parse_args()
    tallies = [Tally() for _ in QUANTITIES]
    with tempfile.TemporaryDirectory() as temporary:
        for seed in range(arguments.first, arguments.first + arguments.drives):
            folder = f"{arguments.keep}/{seed}" if arguments.keep else temporary
            result = run_drive(arguments.binaries, folder, seed, arguments.seconds, bool(arguments.keep))
            if result is not None:
                print(f"drive {seed}: {add_drive(tallies, *result)}", flush=True)
    sys.exit(print_table(tallies))


if __name__ == "__main__":
    main()
