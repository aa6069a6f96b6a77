"""A drive that is recorded directly, and the same as the bag of a ROS robot: gw-slam makes the same of both, byte for byte.

A bag holds no encoder counts and no heading of the base beside Odometry, and the importer orders by the time of measurement;
the direct log is made alike in these two things. ROS 1 bags are written by rosbag where python3-rosbag is installed, MCAP by
@mcap/core where node and the npm packages of gw-view's page are; rosbag2's database by its schema.

usage: rosbag_drive_test.py BIN PACKAGES
"""
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

FOLDER = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(FOLDER)))
sys.path.insert(0, f"{ROOT}/tools/data/bag/testing")
from log_to_bag import convert  # noqa: E402

BIN, PACKAGES = "", ""
SCENARIO = """name: bag_drive
map: {root}/config/scenarios/maps/office/map.yaml
waypoints: [[9.5, 2.0, 0.0], [13.0, 1.9, 1.57], [13.0, 4.0, 1.57]]
visit: [0, 1, 2]
drive: {{max_m_s: 0.6, max_deg_s: 70, turn_at_waypoints: false, pause_s: 0}}
world: {{walls: textured, floor: wood}}
camera: {{rate_hz: 10, mode: {mode}, width: 320, height: 240, focal_px: 190}}
"""
RANK = {b"NOTE": -1, b"IMU": 0, b"WHEEL": 1, b"CAMERA": 3, b"GROUND_TRUTH": 4}
OUTPUTS = ["trajectory.tum", "trajectory_final.tum", "keyframes.tum", "dr.tum", "frames.csv"]
HEADING = struct.calcsize(">qqqq?iiddd")  # of a wheel_t, after fingerprint, times and counts
TICKS = struct.calcsize(">qqqq")


def run(*command):
    done = subprocess.run([f"{BIN}/{command[0]}", *command[1:]], capture_output=True, text=True, check=False)
    if done.returncode:
        raise AssertionError(f"{command}: exit {done.returncode}\n{done.stderr}")
    return done


def without_counts(payload):
    """A wheel_t as a ROS base would have told it: the motion alone."""
    data = bytearray(payload)
    data[TICKS:TICKS + 9] = bytes(9)
    data[HEADING:HEADING + 9] = bytes(9)
    return bytes(data)


def make_alike(source, target):
    events = []
    with open(source, "rb") as f:
        while head := f.read(28):
            _, _, _, name_size, size = struct.unpack(">IQQII", head)
            name, payload = f.read(name_size), f.read(size)
            utime = 0 if name == b"NOTE" else struct.unpack_from(">q", payload, 8)[0]
            if name == b"WHEEL":
                payload = without_counts(payload)
            events.append((utime, RANK[name], len(events), name, payload))
    with open(target, "wb") as f:
        for number, (utime, _, _, name, payload) in enumerate(sorted(events)):
            f.write(struct.pack(">IQQII", 0xEDA1DA01, number, utime, len(name), len(payload)) + name + payload)


def read(path):
    with open(path, "rb") as f:
        return f.read()


def containers():
    found = ["mcap", "sqlite"]
    if shutil.which("node") and os.path.isdir(f"{PACKAGES}/node_modules/@mcap/core"):
        found.append("mcap_core")
    else:
        print("node or @mcap/core is not there: MCAP is written by bag_files.py alone", file=sys.stderr)
    try:
        import rosbag  # noqa: F401
        found.append("ros1")
    except Exception:  # not installed, or not usable by this Python
        print("python3-rosbag is not there: no ROS 1 bag is written", file=sys.stderr)
    return found


def write_bag(folder, container):
    bag = f"{folder}/{container}"
    if container == "mcap_core":
        convert(f"{folder}/sim.lcm", f"{folder}/robot.yaml", f"{bag}.plain", "mcap")
        subprocess.run(["node", f"{ROOT}/tools/data/bag/testing/rewrite_mcap.mjs", f"{bag}.plain", bag],
                       env={**os.environ, "GW_PAGE_PACKAGES": PACKAGES}, check=True)
    else:
        convert(f"{folder}/sim.lcm", f"{folder}/robot.yaml", bag, container)
    return bag


def calibration(path):
    """Every number of the cameras' and the IMU's place and of the lenses."""
    with open(path, encoding="utf-8") as f:
        text = f.read()
    rows = re.findall(r"^ +(?:T_BC|T_C0C1|T_BI|fx|fy|cx|cy): (.*?)(?: #.*)?$", text, re.MULTILINE)
    return [float(v) for row in rows for v in re.findall(r"-?[0-9.]+(?:e-?[0-9]+)?", row.replace("q_wxyz", ""))]


class Drive(unittest.TestCase):
    def check(self, mode):
        with tempfile.TemporaryDirectory() as folder:
            with open(f"{folder}/s.yaml", "w", encoding="utf-8") as f:
                f.write(SCENARIO.format(root=ROOT, mode=mode))
            run("gw-sim", "--scenario", f"{folder}/s.yaml", "--duration", "3.5", "--log", f"{folder}/sim.lcm",
                "--config-out", f"{folder}/robot.yaml")
            make_alike(f"{folder}/sim.lcm", f"{folder}/direct.lcm")
            run("gw-slam", f"{folder}/direct.lcm", "--config", f"{folder}/robot.yaml", "--out", f"{folder}/direct")
            for container in containers():
                bag = write_bag(folder, container)
                done = run("gw-import", "rosbag", bag, "--out", f"{bag}.lcm", "--config-out", f"{bag}.yaml")
                self.assertNotIn("warning", done.stderr)
                self.assertEqual(len(calibration(f"{bag}.yaml")), len(calibration(f"{folder}/robot.yaml")))
                for found, stated in zip(calibration(f"{bag}.yaml"), calibration(f"{folder}/robot.yaml")):
                    self.assertAlmostEqual(found, stated, places=6)
                run("gw-slam", f"{bag}.lcm", "--config", f"{folder}/robot.yaml", "--out", f"{bag}.out")
                for output in OUTPUTS:
                    expected = read(f"{folder}/direct/{output}")
                    self.assertGreater(expected.count(b"\n"), 2 if output == "keyframes.tum" else 30, output)
                    self.assertEqual(read(f"{bag}.out/{output}"), expected, f"{mode} {container} {output}")

    def test_stereo(self):
        self.check("stereo")

    def test_rgbd(self):
        self.check("rgbd")


if __name__ == "__main__":
    BIN, PACKAGES = (os.path.abspath(sys.argv.pop(1)) for _ in range(2))
    unittest.main()
