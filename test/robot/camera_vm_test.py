#!/usr/bin/env python3
"""gw-camera on a real kernel: Debian's vivid driver in QEMU, 640x480 GREY; dropped buffers, a fatal
streaming error and a vanishing device are survived, and counted in HEALTH.

usage: camera_vm_test.py BIN FOLDER    BIN: our programs; FOLDER: holds kernel/ (tools/dev test robot)
"""
import re
import shutil
import sys
import time

import guest

# The webcam input of vivid has 640x480 at up to 25 Hz.
CONFIG = """
robot: {name: vivid}
calibration:
  camera:
    kind: rgbd
    width: 640
    height: 480
    rate_hz: 25
    left: {fx: 385, fy: 385, cx: 320, cy: 240}
    T_BC: {p: [0, 0, 0], q_wxyz: [1, 0, 0, 0]}
  imu: {present: false}
  wheel: {present: false}
drivers:
  camera: {source: uvc, device: /dev/video0, exposure: camera}
"""


def counter(line, name):
    return int(re.search(rf" {re.escape(name)}=(\d+)", line).group(1))


def main(binaries, folder):
    guest.skip_unless_possible(folder)
    if shutil.which("v4l2-ctl") is None:
        guest.skip("v4l2-ctl is not installed (package v4l-utils)")
    begin = time.monotonic()
    with open(f"{folder}/vivid.yaml", "w", encoding="utf-8") as config:
        config.write(CONFIG)
    vm = guest.Guest(folder, "camera_vm",
                     programs=[f"{binaries}/gw-camera", f"{binaries}/gw-bus-probe",
                               shutil.which("v4l2-ctl")],
                     modules=["vivid"], files={"/etc/vivid.yaml": f"{folder}/vivid.yaml"},
                     extra=guest.VIRTUAL_TIME)
    try:
        check(vm)
    finally:
        vm.stop()
    print(f"boot to end: {time.monotonic() - begin:.0f} s")


def check(vm):
    health = r"HEALTH gw-camera (state=.*)"
    assert vm.run("modprobe vivid n_devs=1 node_types=0x1 num_inputs=1 input_types=0") == 0
    print("driver:", "vivid of kernel", end=" ", flush=True)
    vm.type("uname -r")
    print(vm.wait_for(r"(\d+\.\d+\.\d+\S*)").group(1))

    # A mode that the device does not have is named, with those it has.
    vm.type("sed 's/rate_hz: 25/rate_hz: 30/' /etc/vivid.yaml > /tmp/30.yaml; "
            "gw-camera --config /tmp/30.yaml --check; echo CHECK:$?")
    print("30 Hz:", vm.wait_for(r"gw-camera: (.*wanted GREY 640x480 at 30 Hz.*)").group(1)[:120])
    assert vm.wait_for(r"CHECK:(\d+)").group(1) == "1"
    vm.type("gw-camera --config /etc/vivid.yaml --check; echo CHECK:$?")
    print("--check:", vm.wait_for(r"(GREY 640x480.*)").group(1))
    assert vm.wait_for(r"CHECK:(\d+)").group(1) == "0"

    vm.type(f"gw-bus-probe '{guest.URL}' &")
    vm.type(f"gw-camera --config /etc/vivid.yaml --lcm-url '{guest.URL}' & echo PID:$!")
    pid = vm.wait_for(r"PID:(\d+)").group(1)
    camera = r"CAMERA n=(\d+) lost=(\d+) (\S+) 640x480"
    first = vm.wait_for(camera, accept=lambda m: int(m.group(1)) >= 50)
    print("streaming:", first.group(0))
    before = vm.wait_for(health).group(1)
    assert counter(before, "camera.opens") == 1

    control = "v4l2-ctl -d /dev/video0 -c "
    assert vm.run(control + "percentage_of_dropped_buffers=20") == 0
    lossy = vm.wait_for(health, accept=lambda m: counter(m.group(1), "camera.lost") >=
                        counter(before, "camera.lost") + 20).group(1)
    print("a fifth of the buffers dropped: camera.lost", counter(before, "camera.lost"), "->",
          counter(lossy, "camera.lost"), ", images", counter(lossy, "camera.images"))
    vm.wait_for(health + r".*lost: more than one image in twenty")
    assert vm.run(control + "percentage_of_dropped_buffers=0") == 0

    vm.type(control + "inject_fatal_streaming_error=1")
    broken = vm.wait_for(health, accept=lambda m: counter(m.group(1), "camera.opens") == 2).group(1)
    assert counter(broken, "camera.restarts") == 1, broken
    at = int(vm.wait_for(camera).group(1))
    vm.wait_for(camera, accept=lambda m: int(m.group(1)) >= at + 50)
    print("fatal streaming error: restarted once, streams again")

    vm.type(control + "disconnect=1")
    vm.wait_for(r"event=camera.closed .*unplugged")
    vm.wait_for(health, accept=lambda m: counter(m.group(1), "camera.opens") >= 3)
    at = int(vm.wait_for(camera).group(1))
    last = vm.wait_for(camera, accept=lambda m: int(m.group(1)) >= at + 50)
    assert last.group(2) == "0", "what was published arrived"
    print("disconnected: opened again, streams again;", last.group(0))

    vm.type(f"kill {pid}; wait {pid}; echo ENDED:$?")
    assert vm.wait_for(r"ENDED:(\d+)").group(1) == "0"


if __name__ == "__main__":
    main(*sys.argv[1:])
