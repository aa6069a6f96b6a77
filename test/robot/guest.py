"""A small Linux in QEMU: a Debian kernel, busybox, the modules and programs of a test.

Needs no KVM, no network and no disk. The test types commands into the guest's shell and waits for
what appears on its console.
"""
import glob
import json
import os
import re
import shutil
import socket
import subprocess
import sys
import threading
import time

SKIPPED = 77
# The bus inside the guest.
URL = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304"
# depmod and modprobe are not on everybody's path.
TOOLS = {**os.environ, "PATH": os.environ["PATH"] + ":/sbin:/usr/sbin"}

# The guest's time follows its instructions (2 ns each) and skips idling, so that a busy host does
# not look like a camera that stalls. Not for guests that talk to a device outside.
VIRTUAL_TIME = ("-smp", "1", "-icount", "shift=1,sleep=off", "-rtc", "clock=vm")


def skip_unless_possible(folder):
    """Says why and ends with 77 where this machine cannot run the test."""
    for tool, package in [("qemu-system-x86_64", "qemu-system-x86"), ("busybox", "busybox-static"),
                          ("cpio", "cpio"), ("depmod", "kmod"), ("modprobe", "kmod")]:
        if shutil.which(tool, path=TOOLS["PATH"]) is None:
            skip(f"{tool} is not installed (package {package}); `tools/dev test robot` installs it")
    if not glob.glob(f"{folder}/kernel/boot/vmlinuz-*"):
        skip(f"no kernel in {folder}/kernel; `tools/dev test robot` unpacks one")


def skip(why):
    print(f"SKIPPED: {why}")
    sys.exit(SKIPPED)


def shared_libraries(program):
    """Paths of all libraries that it needs, the loader too."""
    text = subprocess.run(["ldd", program], capture_output=True, text=True, check=True).stdout
    if "not found" in text:
        raise RuntimeError(f"{program}: {text}")
    return sorted(set(re.findall(r"(/\S+)", text)))


class Guest:
    """folder: holds kernel/ and gets everything else. programs: copied to /bin of the guest.
    modules: kernel modules with their dependencies, to be loaded by modprobe. files: {path in the
    guest: path here}. extra: more arguments of QEMU."""

    def __init__(self, folder, name, programs, modules, files, extra=()):
        self.folder = folder
        self.work = f"{folder}/{name}"
        shutil.rmtree(self.work, ignore_errors=True)
        os.makedirs(self.work)
        self.text = ""
        self.seen = 0
        self.changed = threading.Condition()
        kernel = sorted(glob.glob(f"{folder}/kernel/boot/vmlinuz-*"))[-1]
        self._make_initramfs(kernel.split("vmlinuz-")[1], programs, modules, files)
        self.qmp_path = f"{self.work}/qmp"
        command = ["qemu-system-x86_64", "-accel", "tcg", "-cpu", "max", "-smp", "2", "-m", "768",
                   "-display", "none", "-no-reboot", "-nic", "none", "-kernel", kernel,
                   "-initrd", f"{self.work}/initramfs",
                   "-append", "console=ttyS0 quiet loglevel=1 panic=-1 no_timer_check",
                   "-qmp", f"unix:{self.qmp_path},server=on,wait=off", "-serial", "stdio", *extra]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        stderr=subprocess.STDOUT)
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()
        try:
            self.wait_for("GUEST READY", 300)
        except AssertionError:
            self.stop()
            raise

    def _make_initramfs(self, version, programs, modules, files):
        root = f"{self.work}/root"
        for path in ["bin", "proc", "sys", "dev", "tmp", "run/gw", "etc"]:
            os.makedirs(f"{root}/{path}")
        shutil.copy(shutil.which("busybox"), f"{root}/bin/busybox")
        source = f"{self.folder}/kernel/lib/modules/{version}"
        subprocess.run(["depmod", "-b", f"{self.folder}/kernel", version], check=True, env=TOOLS)
        for module in modules:
            shown = subprocess.run(["modprobe", "-d", f"{self.folder}/kernel", "-S", version,
                                    "--show-depends", module], capture_output=True, text=True,
                                   check=True, env=TOOLS)
            for path in re.findall(r"insmod (\S+)", shown.stdout):
                inside = os.path.join(root, "lib/modules", version, os.path.relpath(path, source))
                os.makedirs(os.path.dirname(inside), exist_ok=True)
                shutil.copy(path, inside)
        for index in glob.glob(f"{source}/modules.builtin*") + [f"{source}/modules.order"]:
            shutil.copy(index, f"{root}/lib/modules/{version}")
        subprocess.run(["depmod", "-b", root, version], check=True, env=TOOLS)
        wanted = dict(files)
        for program in programs:
            wanted[f"/bin/{os.path.basename(program)}"] = program
            for library in shared_libraries(program):
                wanted[library] = library
        for inside, outside in wanted.items():
            os.makedirs(os.path.dirname(root + inside), exist_ok=True)
            shutil.copy(outside, root + inside)
        for program in programs:
            subprocess.run(["strip", f"{root}/bin/{os.path.basename(program)}"], check=False)
        with open(f"{root}/init", "w", encoding="utf-8") as init:
            init.write("#!/bin/busybox sh\n"
                       "/bin/busybox --install -s /bin\n"
                       "export PATH=/bin\n"
                       "mount -t proc none /proc; mount -t sysfs none /sys\n"
                       "mount -t devtmpfs none /dev\n"
                       "ip link set lo up; ip link set lo multicast on\n"
                       "ip route add 239.255.76.67/32 dev lo\n"
                       "echo 8388608 > /proc/sys/net/core/rmem_max\n"
                       "stty -echo\n"
                       "echo GUEST READY\n"
                       "exec sh 2>&1\n")
        os.chmod(f"{root}/init", 0o755)
        with open(f"{self.work}/initramfs", "wb") as out:
            files_of_root = subprocess.Popen(["find", "."], cwd=root, stdout=subprocess.PIPE)
            subprocess.run(["cpio", "-o", "-H", "newc", "--quiet"], cwd=root,
                           stdin=files_of_root.stdout, stdout=out, check=True)
        shutil.rmtree(root)

    def _read(self):
        with open(f"{self.work}/console.txt", "w", encoding="utf-8") as log:
            for line in iter(self.process.stdout.readline, b""):
                text = line.decode(errors="replace").replace("\r", "")
                log.write(text)
                log.flush()
                with self.changed:
                    self.text += text
                    self.changed.notify_all()

    def type(self, command):
        self.process.stdin.write((command + "\n").encode())
        self.process.stdin.flush()

    def wait_for(self, pattern, seconds=120, accept=lambda match: True):
        """The next match, after what earlier calls found, for which accept is true."""
        end = time.monotonic() + seconds
        regex = re.compile(pattern)
        with self.changed:
            while True:
                for match in regex.finditer(self.text, self.seen):
                    if "\n" not in self.text[match.end():]:
                        break  # the line may not be complete yet
                    if accept(match):
                        self.seen = match.end()
                        return match
                left = end - time.monotonic()
                if left <= 0 or self.process.poll() is not None:
                    raise AssertionError(f"not seen on the console: {pattern}; it ends with:\n"
                                         + self.text[-3000:])
                self.changed.wait(min(left, 1))

    def run(self, command, seconds=60):
        """Runs a command to its end; gives its exit code."""
        self.type(f"{command}; echo EXIT:$?")
        return int(self.wait_for(r"EXIT:(\d+)", seconds).group(1))

    def qmp(self, execute, **arguments):
        """A command to QEMU itself, e.g. device_del."""
        with socket.socket(socket.AF_UNIX) as connection:
            connection.connect(self.qmp_path)
            lines = connection.makefile("rw")
            lines.readline()
            for request in [{"execute": "qmp_capabilities"},
                            {"execute": execute, "arguments": arguments}]:
                lines.write(json.dumps(request) + "\n")
                lines.flush()
                answer = json.loads(lines.readline())
                while "event" in answer:
                    answer = json.loads(lines.readline())
                if "error" in answer:
                    raise AssertionError(f"{execute}: {answer['error']}")

    def stop(self):
        self.process.kill()
        self.process.wait()
