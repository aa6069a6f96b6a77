"""The newest demo or replay that still runs is found; those that ended are forgotten."""
import os
import subprocess
import sys
import tempfile
import unittest

PROGRAM = f"{os.path.dirname(os.path.abspath(__file__))}/running_bus.py"


class RunningBus(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.environment = dict(os.environ, XDG_RUNTIME_DIR=folder.name)

    def run_it(self, *arguments):
        return subprocess.run([sys.executable, PROGRAM, *arguments], capture_output=True, text=True, env=self.environment)

    def test_nothing_runs(self):
        self.assertEqual(self.run_it("find").returncode, 1)

    def test_the_newest_that_runs(self):
        first = self.run_it("announce", "udpm://first", str(os.getpid())).stdout.strip()
        os.utime(first, (1, 1))
        self.run_it("announce", "udpm://second", str(os.getppid()))
        self.assertEqual(self.run_it("find").stdout, "udpm://second\n")
        ended = subprocess.Popen(["true"])
        ended.wait()
        gone = self.run_it("announce", "udpm://gone", str(ended.pid)).stdout.strip()
        self.assertEqual(self.run_it("find").stdout, "udpm://second\n")
        self.assertFalse(os.path.exists(gone))


if __name__ == "__main__":
    unittest.main()
