#!/usr/bin/env python3
"""gw-preflight on made-up machines: a good one passes; every single defect is named, with a fix, and fails.

usage: preflight_test.py PREFLIGHT BIN_DIR ROBOT.yaml
"""
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

PREFLIGHT, BIN_DIR, ROBOT = sys.argv[1:4]

GOOD = {
    "proc/sys/net/core/rmem_max": "16777216\n",
    "proc/sys/net/core/rmem_default": "4194304\n",
    "proc/net/route": "Iface\tDestination\tGateway\tFlags\tRefCnt\tUse\tMetric\tMask\n"
                      "lo\t434CFFEF\t00000000\t0005\t0\t0\t0\tFFFFFFFF\t0\t0\t0\n",
    "sys/class/net/lo/flags": "0x1049\n",
    "sys/bus/usb/devices/2-1/idVendor": "8086\n",
    "sys/bus/usb/devices/2-1/idProduct": "0b3a\n",
    "sys/bus/usb/devices/2-1/speed": "5000\n",
    "sys/bus/usb/devices/2-1/power/control": "on\n",
    "sys/bus/usb-serial/devices/ttyUSB0/latency_timer": "1\n",
    "dev/video0": "", "dev/iio:device0": "", "dev/ttyUSB0": "",
    "etc/passwd": "root:x:0:0::/root:/bin/sh\ngood-weights:x:990:990::/var/lib/good-weights:/usr/sbin/nologin\n",
    "etc/group": "dialout:x:20:good-weights\nvideo:x:44:x,good-weights\nplugdev:x:46:good-weights\n",
    "etc/default/good-weights": "#GW_CONFIG=/etc/x\nGW_RECORD_GB=0\n",  # whatever this machine has free is enough
    "var/lib/x": "",
}


class Preflight(unittest.TestCase):
    def setUp(self):
        self.root = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.root)
        for name, text in GOOD.items():
            self.put(name, text)
        os.symlink("ttyUSB0", f"{self.root}/dev/kobuki")

    def put(self, name, text):
        path = pathlib.Path(self.root, name)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def remove(self, name):
        os.remove(f"{self.root}/{name}")

    def run_preflight(self, *arguments):
        environment = dict(os.environ, PATH=f"{BIN_DIR}:{os.environ['PATH']}")
        done = subprocess.run([PREFLIGHT, "--root", self.root, "--config", ROBOT, *arguments],
                              capture_output=True, text=True, env=environment)
        return done.returncode, done.stdout

    def expect_failure(self, subject, fix):
        code, said = self.run_preflight()
        self.assertEqual(code, 1, said)
        lines = said.splitlines()
        failures = [i for i, line in enumerate(lines) if line.startswith("FAIL")]
        self.assertEqual(len(failures), 1, said)
        self.assertIn(subject, lines[failures[0]])
        self.assertIn("-> ", lines[failures[0] + 1])
        self.assertIn(fix, lines[failures[0] + 1])

    def test_a_good_machine_passes(self):
        code, said = self.run_preflight()
        self.assertEqual(code, 0, said)
        self.assertNotIn("FAIL", said)

    def test_small_buffers(self):
        self.put("proc/sys/net/core/rmem_max", "212992\n")
        self.expect_failure("rmem_max", "sysctl -w net.core.rmem_max=16777216")

    def test_no_route(self):
        self.put("proc/net/route", "Iface\tDestination\n")
        self.expect_failure("multicast", "good-weights-bus.service")

    def test_multicast_off(self):
        self.put("sys/class/net/lo/flags", "0x49\n")
        self.expect_failure("lo", "good-weights-bus.service")

    def test_camera_absent(self):
        self.put("sys/bus/usb/devices/2-1/idProduct", "0b07\n")
        self.expect_failure("8086:0b3a", "USB 3")

    def test_camera_on_usb2(self):
        self.put("sys/bus/usb/devices/2-1/speed", "480\n")
        self.expect_failure("480 Mbit/s", "another port")

    def test_no_video_node(self):
        self.remove("dev/video0")
        self.expect_failure("/dev/video", "modprobe uvcvideo")

    def test_no_imu(self):
        self.remove("dev/iio:device0")
        self.expect_failure("imu", "modprobe hid_sensor")

    def test_base_absent(self):
        self.remove("dev/kobuki")
        self.expect_failure("/dev/kobuki", "USB cable")

    def test_latency_timer(self):
        self.put("sys/bus/usb-serial/devices/ttyUSB0/latency_timer", "16\n")
        self.expect_failure("16 ms", "echo 1 >")

    def test_no_user(self):
        self.put("etc/passwd", "root:x:0:0::/root:/bin/sh\n")
        self.expect_failure("no user", "systemd-sysusers")

    def test_user_lacks_a_group(self):
        self.put("etc/group", "dialout:x:20:good-weights\nvideo:x:44:\nplugdev:x:46:good-weights\n")
        self.expect_failure("not in: video", "gpasswd -a good-weights")

    def record(self, name, log):
        """A file of the recorder with these bytes."""
        path = pathlib.Path(self.root, "var/lib/good-weights/log", name)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(log)

    def test_nothing_recorded_yet_is_no_failure(self):
        code, said = self.run_preflight()
        self.assertEqual(code, 0)
        self.assertIn("recording      none yet", said)

    def test_what_was_recorded_is_checked(self):
        # The newest file is still being written; the one before holds a message that is none of ours.
        event = struct.pack(">IqqII", 0xEDA1DA01, 0, 1_000_000, 6, 8) + b"CAMERA" + b"no image"
        self.record("2026-01-01T00-00-00.000000.lcm", b"")
        self.record("2026-01-01T00-01-00.000000.lcm", event)
        self.record("2026-01-01T00-02-00.000000.lcm", b"")
        code, said = self.run_preflight()
        self.assertEqual(code, 1, said)
        self.assertIn("FAIL recording      [", said)
        self.assertIn("-> ", said)

    def test_everything_is_reported_at_once(self):
        self.put("proc/sys/net/core/rmem_max", "212992\n")
        self.put("sys/class/net/lo/flags", "0x49\n")
        self.remove("dev/kobuki")
        code, said = self.run_preflight()
        self.assertEqual(code, 1)
        self.assertEqual(said.count("FAIL"), 3, said)

    def test_bad_configuration(self):
        self.put("bad.yaml", "robot: {name: 1.5, nme: x}\n")
        code, said = self.run_preflight("--config", f"{self.root}/bad.yaml")
        self.assertEqual(code, 78, said)
        self.assertIn("bad.yaml:1", said)

    def test_usage(self):
        self.assertEqual(self.run_preflight("--nonsense")[0], 2)
        self.assertEqual(self.run_preflight("--help")[0], 0)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
