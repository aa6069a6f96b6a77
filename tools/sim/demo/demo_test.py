"""tools/sim/demo/demo before anything drives: what cannot work is refused with one message, and nothing is deleted."""
import os
import subprocess
import sys
import tempfile
import unittest

DEMO = f"{os.path.dirname(os.path.abspath(__file__))}/demo"
FAILED, USAGE = 1, 2
BIN = ""


class Demo(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.out = f"{folder.name}/out"

    def refused(self, code, message, *arguments, programs=None):
        run = subprocess.run([DEMO, "--bin", programs or BIN, "--out", self.out, *arguments], capture_output=True,
                             text=True)
        self.assertEqual(run.returncode, code, run.stderr)
        self.assertIn(message, run.stderr)
        self.assertNotIn("Traceback", run.stderr)

    def test_programs_that_are_not_built(self):
        self.refused(USAGE, "/nowhere has no gw-sim", programs="/nowhere")

    def test_a_map_that_is_not_there_also_the_second_time(self):
        for _ in range(2):
            self.refused(FAILED, "/nowhere/map.yaml: no such map", "--map", "/nowhere/map.yaml")

    def test_a_folder_with_something_else_in_it_is_left_alone(self):
        os.makedirs(self.out)
        with open(f"{self.out}/thesis.tex", "w") as f:
            f.write("years of work")
        self.refused(USAGE, "not an earlier demo")
        self.assertEqual(os.listdir(self.out), ["thesis.tex"])


if __name__ == "__main__":
    BIN = sys.argv.pop(1)
    unittest.main()
