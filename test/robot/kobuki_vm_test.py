#!/usr/bin/env python3
"""gw-kobuki on a real kernel: Debian's driver of FTDI adapters in QEMU, whose emulated adapter is
fed by gw-kobuki-emulator outside. Drives there and turns, is unplugged and plugged in again; what
WHEEL says is where the emulated base is.

usage: kobuki_vm_test.py BIN FOLDER    BIN: our programs; FOLDER: holds kernel/ (tools/dev test robot)
"""
import os
import re
import select
import socket
import subprocess
import sys
import threading
import time
import tty

import guest

CONFIG = """
robot: {name: kobuki}
calibration:
  camera:
    kind: rgbd
    width: 640
    height: 480
    rate_hz: 30
    left: {fx: 385, fy: 385, cx: 320, cy: 240}
    T_BC: {p: [0, 0, 0], q_wxyz: [1, 0, 0, 0]}
  imu: {present: false}
  wheel: {present: true}
drivers:
  kobuki: {device: auto}
"""
ADAPTER = {"driver": "usb-serial", "chardev": "line", "id": "base", "serial": "kobuki_TEST",
           "always-plugged": True}


class Base:
    """The emulated robot, and the cable between its terminal and QEMU's adapter."""

    def __init__(self, program, folder):
        self.terminal_link = f"{folder}/kobuki_terminal"
        self.socket_path = f"{folder}/kobuki_line"
        self.process = subprocess.Popen([program, "--link", self.terminal_link], text=True,
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        assert self.process.stdout.readline().strip() == self.terminal_link
        if os.path.exists(self.socket_path):
            os.remove(self.socket_path)
        self.listener = socket.socket(socket.AF_UNIX)
        self.listener.bind(self.socket_path)
        self.listener.listen(1)
        threading.Thread(target=self._carry, daemon=True).start()

    def _carry(self):
        terminal = os.open(self.terminal_link, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(terminal)
        line, _ = self.listener.accept()
        try:
            while True:
                for ready in select.select([terminal, line], [], [])[0]:
                    if ready is line:
                        received = line.recv(4096)
                        if not received:
                            return
                        os.write(terminal, received)
                    else:
                        line.sendall(os.read(terminal, 4096))
        except OSError:
            pass  # QEMU or the emulator has ended

    def where(self):
        """x in m and yaw in rad, since power-on."""
        self.process.stdin.write("where\n")
        self.process.stdin.flush()
        x, yaw = re.search(r"x (\S+) m.*yaw (\S+) rad", self.process.stdout.readline()).groups()
        return float(x), float(yaw)

    def stop(self):
        self.process.kill()
        self.process.wait()


def main(binaries, folder):
    guest.skip_unless_possible(folder)
    begin = time.monotonic()
    with open(f"{folder}/kobuki.yaml", "w", encoding="utf-8") as config:
        config.write(CONFIG)
    base = Base(f"{binaries}/gw-kobuki-emulator", folder)
    try:
        adapter = ",".join(f"{key}={'on' if value is True else value}"
                           for key, value in ADAPTER.items() if key != "driver")
        vm = guest.Guest(folder, "kobuki_vm",
                         programs=[f"{binaries}/gw-kobuki", f"{binaries}/gw-bus-probe"],
                         modules=["uhci-hcd", "ftdi_sio"],
                         files={"/etc/kobuki.yaml": f"{folder}/kobuki.yaml"},
                         extra=["-device", "piix3-usb-uhci",
                                "-chardev", f"socket,id=line,path={base.socket_path}",
                                "-device", f"{ADAPTER['driver']},{adapter}"])
        try:
            check(vm, base)
        finally:
            vm.stop()
    finally:
        base.stop()
    print(f"boot to end: {time.monotonic() - begin:.0f} s")


def check(vm, base):
    health = r"HEALTH gw-kobuki state=(\d) (.*)"
    assert vm.run("modprobe uhci-hcd && modprobe ftdi_sio") == 0
    assert vm.run("until [ -e /dev/ttyUSB0 ]; do sleep 0.1; done", 120) == 0
    vm.type("gw-kobuki --config /etc/kobuki.yaml --check; echo CHECK:$?")
    found = vm.wait_for(r"(/dev/ttyUSB0: Kobuki, .*)").group(1)
    print("--check:", found)
    assert "hardware 1.0.4, firmware 1.2.0" in found
    assert vm.wait_for(r"CHECK:(\d+)").group(1) == "0"

    vm.type(f"gw-bus-probe '{guest.URL}' &")
    vm.type(f"gw-kobuki --config /etc/kobuki.yaml --lcm-url '{guest.URL}' & echo PID:$!")
    pid = vm.wait_for(r"PID:(\d+)").group(1)
    wait_for_state(vm, health, "2")
    vm.type("echo TIMER:$(cat /sys/bus/usb-serial/devices/ttyUSB0/latency_timer)")
    assert vm.wait_for(r"TIMER:(\d+)").group(1) == "1", "low latency was asked of the adapter"

    drive(vm, "0.3 0", lambda: base.where()[0] > 0.5)
    compare(vm, base, "driven straight")

    vm.qmp("device_del", id=ADAPTER["id"])
    vm.wait_for(r"event=kobuki\.gone")
    print("unplugged:", wait_for_state(vm, health, "4").group(2).split("message=")[1])
    vm.qmp("device_add", **ADAPTER)
    again = wait_for_state(vm, health, "2").group(2)
    print("plugged in again: kobuki.port_opens", re.search(r"port_opens=(\d+)", again).group(1))

    drive(vm, "0 0.8", lambda: base.where()[1] > 1)
    n = compare(vm, base, "then turned")

    vm.type(f"kill {pid}; wait {pid}; echo ENDED:$?")
    assert vm.wait_for(r"ENDED:(\d+)").group(1) == "0"
    print(f"WHEEL: {n} samples, none lost")


def wait_for_state(vm, health, state):
    return vm.wait_for(health, accept=lambda match: match.group(1) == state)


def drive(vm, command, until):
    vm.type(f"gw-bus-probe '{guest.URL}' {command} & echo DRIVER:$!")
    pid = vm.wait_for(r"DRIVER:(\d+)").group(1)
    end = time.monotonic() + 300
    while not until():
        assert time.monotonic() < end, "the base does not obey:\n" + vm.text[-2000:]
        time.sleep(0.1)
    assert vm.run(f"kill {pid}; wait {pid}") == 0


def compare(vm, base, what):
    """Once the base stands, the sums of WHEEL are its place. Returns the number of samples."""
    wheel = r"WHEEL n=(\d+) lost=(\d+) ticks=(\S+) dx_m=(\S+) dyaw_rad=(\S+)"
    before, standing = None, vm.wait_for(wheel)
    while before is None or before.group(3) != standing.group(3):
        before, standing = standing, vm.wait_for(wheel)
    x, yaw = base.where()
    dx, dyaw = float(standing.group(4)), float(standing.group(5))
    print(f"{what}: the base is at {x:.3f} m, {yaw:.3f} rad; WHEEL says {dx:.3f} m, {dyaw:.3f} rad")
    assert standing.group(2) == "0", standing.group(0)
    assert abs(dx - x) < 0.002, "a tick is 0.09 mm"
    assert abs(dyaw - yaw) < 0.005, "a tick is 0.4 mrad"
    return int(standing.group(1))


if __name__ == "__main__":
    main(*sys.argv[1:])
