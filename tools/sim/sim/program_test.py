"""gw-sim as a program: what cannot be simulated gets one clear message, the documented code, and leaves no log."""
import os
import signal
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
OFFICE = f"{ROOT}/config/scenarios/maps/office/map.yaml"
FAILED, BAD_CONFIGURATION = 1, 78
GW_SIM = ""

DRIVE = "name: t\nwaypoints: [[2.0, 2.0, 0.0], [13.0, 1.9, 1.57]]\n"


def pose_lines(begin, end):
    """A recorded robot at 0.5 m/s, 20 poses a second."""
    times = [begin + 0.05 * i for i in range(int((end - begin) / 0.05))]
    return "".join(f"{1000 + t:.3f} {0.5 * t:.4f} 0 0 0 0 0 1\n" for t in times)


class GwSim(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.log = f"{self.folder}/run.lcm"

    def write(self, name, content):
        path = f"{self.folder}/{name}"
        with open(path, "wb") as f:
            f.write(content.encode() if isinstance(content, str) else content)
        return path

    def map(self, pixels, width, height):
        self.write("map.pgm", f"P5\n{width} {height}\n255\n".encode() + bytes(pixels))
        return self.write("map.yaml", "image: map.pgm\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\n"
                                      "occupied_thresh: 0.65\nfree_thresh: 0.196\n")

    def command(self, scenario, *arguments):
        return [GW_SIM, "--scenario", self.write("s.yaml", scenario), "--log", self.log, *arguments]

    def refused(self, code, message, scenario, *arguments):
        run = subprocess.run(self.command(scenario, *arguments), capture_output=True, text=True)
        self.assertEqual(run.returncode, code, run.stderr)
        self.assertIn(message, run.stderr)
        # OpenCV adds a line of its own about images that it cannot read.
        own = [line for line in run.stderr.splitlines() if line and not line.startswith("imread_")]
        self.assertTrue(own[0].startswith("gw-sim: "), run.stderr)
        self.assertFalse(os.path.exists(self.log))

    def test_map_without_walls(self):
        self.refused(FAILED, "map without walls", DRIVE, "--map", self.map([254] * 10000, 100, 100))

    def test_map_image_cut_short(self):
        self.refused(FAILED, "map.pgm", DRIVE, "--map", self.map([254] * 5000, 100, 100))

    def test_waypoint_inside_a_wall(self):
        self.refused(FAILED, "stop 1 at (0, 0)",
                     "name: t\nwaypoints: [[2.0, 2.0, 0.0], [0.0, 0.0, 0.0]]\n", "--map", OFFICE)

    def test_waypoint_outside_the_map(self):
        self.refused(FAILED, "stop 1 at (500, 2)",
                     "name: t\nwaypoints: [[2.0, 2.0, 0.0], [500.0, 2.0, 0.0]]\n", "--map", OFFICE)

    def test_waypoint_that_no_way_leads_to(self):
        # Two rooms, and no door in the wall between them.
        pixels = [0 if x in (0, 49, 99) or y in (0, 49) else 254 for y in range(50) for x in range(100)]
        self.refused(FAILED, "stop 1 at (7.5, 2.5)",
                     "name: t\nwaypoints: [[2.5, 2.5, 0.0], [7.5, 2.5, 0.0]]\n", "--map", self.map(pixels, 100, 50))

    def test_no_waypoints(self):
        self.refused(FAILED, "waypoint", "name: t\n", "--map", OFFICE)

    def test_unknown_key(self):
        self.refused(BAD_CONFIGURATION, "s.yaml:3: speeed: no such key", DRIVE + "speeed: 3\n", "--map", OFFICE)

    def test_image_of_size_zero(self):
        self.refused(BAD_CONFIGURATION, "s.yaml:3: camera.width: must be a whole number from 64",
                     DRIVE + "camera: {width: 0}\n", "--map", OFFICE)

    def test_trajectory_with_a_gap(self):
        # Without a reference for 3 s the odometry carries on; without odometry for 6 s nothing does.
        truth = self.write("truth.txt", pose_lines(0, 5) + pose_lines(8, 20))
        odometry = self.write("odometry.txt", pose_lines(0, 5) + pose_lines(11, 20))
        self.refused(FAILED, "odometry.txt: gap of", "name: t\n", "--trajectory", truth,
                     "--odometry", odometry)

    def test_no_such_files(self):
        self.refused(FAILED, "nowhere.yaml", DRIVE, "--map", f"{self.folder}/nowhere.yaml")
        self.refused(FAILED, "nowhere.txt", "name: t\n", "--trajectory", f"{self.folder}/nowhere.txt",
                     "--odometry", f"{self.folder}/nowhere.txt")

    def test_a_run_that_is_interrupted_leaves_no_log_that_looks_whole(self):
        command = self.command(DRIVE, "--map", OFFICE)
        run = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        while not os.path.exists(self.log + ".part") and run.poll() is None:
            pass
        run.send_signal(signal.SIGINT)
        _, message = run.communicate()
        self.assertEqual(run.returncode, FAILED, message)
        self.assertIn(f"{self.log}.part", message)
        self.assertFalse(os.path.exists(self.log))


if __name__ == "__main__":
    GW_SIM = sys.argv.pop(1)
    unittest.main()
