#!/usr/bin/env python3
"""The Debian package under a real systemd: a Debian 12 root file system is booted in a container of its own,
the package is installed, the services run on simulated sensors, die in every way, come back, and are purged.

usage: services_test.py PACKAGE_DIR SOURCE_DIR BIN_DIR WORK_DIR
Prints what it measured. Exit 0 ok, 1 failed, 77 skipped (says why). Needs root and Debian's mirror the first time;
the root file system is kept in WORK_DIR/base.
"""
import glob
import os
import re
import shutil
import subprocess
import sys
import time

SKIP = 77
BASE_PACKAGES = "systemd,systemd-sysv,dbus,udev,iproute2,procps"
# A light robot: the simulator has to run beside everything else.
SCENARIO = """\
name: services
map: {scenarios}/maps/office/map.yaml
waypoints: [[2, 2, 0], [3, 2, 0]]
camera: {{mode: rgbd, width: 160, height: 120, focal_px: 100, rate_hz: 5}}
"""


def skip(why):
    print("skipped:", why)
    sys.exit(SKIP)


def run(command, **options):
    return subprocess.run(command, check=True, **options)


def quiet(command, log):
    with open(log, "a") as out:
        run(command, stdout=out, stderr=out)


def make_base(base, package, log):
    """Debian 12 with what the package needs, so that dpkg -i inside needs no network."""
    stamp = f"{base}.ready"
    fields = [subprocess.run(["dpkg-deb", "-f", package, field], capture_output=True, text=True, check=True).stdout
              for field in ("Depends", "Recommends")]
    # "a (>= 1) | b, c": the first alternative of each, without its version.
    names = sorted({entry.split()[0] for field in fields for entry in field.split(",") if entry.strip()})
    if os.path.exists(stamp) and open(stamp).read() == " ".join(names):
        return
    print("making the Debian root file system (a few minutes, once)", flush=True)
    try:
        if not os.path.exists(f"{base}/usr/bin/systemctl"):
            shutil.rmtree(base, ignore_errors=True)
            quiet(["debootstrap", "--variant=minbase", f"--include={BASE_PACKAGES}", "bookworm", base], log)
        environment = dict(os.environ, DEBIAN_FRONTEND="noninteractive")
        with open(log, "a") as out:
            for apt in (["update", "-qq"], ["install", "-y", "-qq", "--no-install-recommends", *names]):
                run(["chroot", base, "apt-get", *apt], stdout=out, stderr=out, env=environment)
    except subprocess.CalledProcessError as error:
        skip(f"no Debian root file system: {error}; see {log}")
    with open(stamp, "w") as out:
        out.write(" ".join(names))


def newer_version(package, work):
    """The same package with a higher version, to upgrade to."""
    tree, newer = f"{work}/newer", f"{work}/test/newer.deb"
    shutil.rmtree(tree, ignore_errors=True)
    run(["dpkg-deb", "-R", package, tree])
    with open(f"{tree}/DEBIAN/control") as control:
        text = re.sub(r"(?m)^Version: .*$", r"\g<0>+next", control.read())
    with open(f"{tree}/DEBIAN/control", "w") as control:
        control.write(text)
    run(["dpkg-deb", "--root-owner-group", "-Znone", "-b", tree, newer], stdout=subprocess.DEVNULL)
    shutil.rmtree(tree)


class Container:
    """The booted system; its file system is an overlay that is thrown away."""

    def __init__(self, base, work, binds):
        self.root, self.upper, scratch = f"{work}/root", f"{work}/upper", f"{work}/scratch"
        self.process = None
        for folder in (self.root, self.upper, scratch):
            shutil.rmtree(folder, ignore_errors=True)
            os.makedirs(folder)
        run(["mount", "-t", "overlay", "gw-test", "-o", f"lowerdir={base},upperdir={self.upper},workdir={scratch}",
             self.root])
        self.name = f"gw-test-{os.getpid()}"
        with open(f"{work}/boot.log", "w") as boot_log:
            self.process = subprocess.Popen(
                ["systemd-nspawn", "-q", "-D", self.root, "--boot", "--register=no", "--keep-unit", "-M", self.name,
                 "--private-network", "--kill-signal=SIGRTMIN+3", *[f"--bind-ro={b}" for b in binds]],
                stdin=subprocess.DEVNULL, stdout=boot_log, stderr=boot_log)
        self.init = self.wait_for_init()

    def wait_for_init(self):
        """The container's PID 1, once its system is up."""
        deadline = time.monotonic() + 120
        while time.monotonic() < deadline:
            if self.process.poll() is not None:
                raise RuntimeError(f"systemd-nspawn ended with {self.process.returncode}")
            children = subprocess.run(["pgrep", "-P", str(self.process.pid)], capture_output=True, text=True).stdout
            for pid in children.split():
                self.init = int(pid)
                if self.systemctl("is-system-running").strip() in ("running", "degraded"):
                    return int(pid)
            time.sleep(0.5)
        raise RuntimeError("the system did not come up")

    def run(self, command, check=True):
        done = subprocess.run(["nsenter", "-t", str(self.init), "-a", "sh", "-c", command],
                              capture_output=True, text=True)
        if check and done.returncode != 0:
            raise RuntimeError(f"{command}: exit {done.returncode}\n{done.stdout}{done.stderr}")
        return done.stdout

    def systemctl(self, arguments):
        return self.run(f"systemctl {arguments}", check=False)

    def show(self, unit, *names):
        out = self.systemctl(f"show {unit} " + " ".join(f"-p {n}" for n in names))
        return dict(line.split("=", 1) for line in out.splitlines() if "=" in line)

    def stop(self):
        if self.process and self.process.poll() is None:
            self.process.terminate()
            try:
                self.process.wait(30)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        subprocess.run(["umount", self.root], check=False)


class Test:
    def __init__(self, container):
        self.container = container
        self.failures = []

    def expect(self, condition, claim):
        print(("  ok: " if condition else "  FAILED: ") + claim, flush=True)
        if not condition:
            self.failures.append(claim)

    def wait_active(self, unit, not_pid, limit_s):
        """Seconds until the unit is active with another main process; None: not within the limit."""
        begin = time.monotonic()
        while time.monotonic() - begin < limit_s:
            state = self.container.show(unit, "ActiveState", "MainPID")
            if state["ActiveState"] == "active" and int(state["MainPID"]) not in (0, not_pid):
                return time.monotonic() - begin
            time.sleep(0.05)
        return None

    def boot_order(self, services):
        """Each of a pair became active before the other began to start."""
        began = {s: int(self.container.show(s, "InactiveExitTimestampMonotonic")["InactiveExitTimestampMonotonic"])
                 for s in services}
        active = {s: int(self.container.show(s, "ActiveEnterTimestampMonotonic")["ActiveEnterTimestampMonotonic"])
                  for s in services}
        pairs = [("good-weights-bus", s) for s in services if s != "good-weights-bus"]
        pairs += [("gw-recorder", s) for s in services if s not in ("good-weights-bus", "gw-recorder")]
        pairs += [("gw-backend", "gw-frontend"), ("gw-dr-ekf", "gw-frontend")]
        wrong = [f"{a} before {b}" for a, b in pairs if not 0 < active[a] <= began[b]]
        self.expect(not wrong, "boot order" + (": wrong " + ", ".join(wrong) if wrong else ""))

    def kill(self, unit, limit_s):
        pid = int(self.container.show(unit, "MainPID")["MainPID"])
        self.container.run(f"kill -9 {pid}")
        took = self.wait_active(unit, pid, 30)
        text = "not back" if took is None else f"back after {took:.2f} s"
        self.expect(took is not None and took <= limit_s, f"kill -9 of {unit}: {text} (limit {limit_s} s)")

    def stall(self, unit, limit_s):
        pid = int(self.container.show(unit, "MainPID")["MainPID"])
        self.container.run(f"kill -STOP {pid}")
        took = self.wait_active(unit, pid, 60)
        text = "not back" if took is None else f"back after {took:.2f} s"
        self.expect(took is not None and took <= limit_s, f"{unit} stalls (watchdog 3 s): {text} (limit {limit_s} s)")

    def too_often(self, unit):
        """Dies at every start until the start limit, then comes back by itself."""
        for _ in range(40):
            state = self.container.show(unit, "ActiveState", "MainPID")
            if state["ActiveState"] == "failed":
                break
            if int(state["MainPID"]):
                self.container.run(f"kill -9 {state['MainPID']}", check=False)
            time.sleep(0.2)
        self.expect(self.container.show(unit, "ActiveState")["ActiveState"] == "failed",
                    f"{unit} is given up after ten deaths")
        took = self.wait_active(unit, 0, 40)
        text = "not back" if took is None else f"back after {took:.1f} s"
        self.expect(took is not None and 5 < took, f"{unit} is tried again later: {text}")


KOBUKI_DROP_IN = """\
[Service]
# The emulator is a pseudo terminal; its base stands still, the simulated one drives: two buses.
DeviceAllow=char-pts rw
ExecStart=
ExecStart=gw-kobuki --config ${GW_CONFIG} --lcm-url udpm://239.255.76.67:7668?ttl=0
"""
SERVICES = ["gw-recorder", "gw-kobuki", "gw-camera", "gw-dr-ekf", "gw-backend", "gw-frontend", "gw-grid", "gw-view"]
# A start takes 0.1 s of waiting and the programs' own: LCM tests its multicast first. The rest is for a busy host.
BACK_LIMIT_S = 3.0
# The limit is the watchdog's 3 s, and the same again.
STALL_LIMIT_S = 3.0 + 5.0 + BACK_LIMIT_S
MAX_EXPOSURE = 5.0  # the score of systemd-analyze security above which it says MEDIUM


def configure(container):
    """The configuration of the simulated robot, with a Kobuki emulator on a pseudo terminal as its base."""
    container.run("systemd-run -q --unit=emulator -p User=good-weights -p RuntimeDirectory=emulator "
                  "sh -c 'sleep infinity | /gw-bin/gw-kobuki-emulator --link /run/emulator/kobuki'")
    container.run("gw-sim --scenario /gw-test/scenario.yaml --fast --duration 0.1 --log /run/sim.lcm --config-out "
                  "/run/sim.yaml 2>&1")
    container.run("{ cat /run/sim.yaml; printf 'drivers:\\n  kobuki: {device: /run/emulator/kobuki}\\n'; } "
                  "> /etc/good-weights/robot.yaml; gw-config --check /etc/good-weights/robot.yaml")
    container.run("mkdir -p /etc/systemd/system/gw-kobuki.service.d && cat > /etc/systemd/system/"
                  f"gw-kobuki.service.d/test.conf <<'END'\n{KOBUKI_DROP_IN}END\nsystemctl daemon-reload")


def simulate(container):
    """Camera, IMU and wheels of a standing robot, on the bus."""
    container.run("systemd-run -q --unit=sim -p Restart=on-failure gw-sim --scenario /gw-test/scenario.yaml --realtime "
                  "--drive external --lcm-url 'udpm://239.255.76.67:7667?ttl=0'")


def check_units(container, test):
    units = "good-weights.target good-weights-bus.service " + " ".join(f"{s}.service" for s in SERVICES)
    said = container.run(f"systemd-analyze verify --man=no {units} 2>&1", check=False).strip()
    test.expect(said == "", f"systemd-analyze verify finds nothing{': ' + said if said else ''}")
    for service in SERVICES:
        said = container.run(f"systemd-analyze security --no-pager {service}.service 2>&1 | tail -n 1", check=False)
        level = re.search(r"level for \S+: ([\d.]+)", said)
        test.expect(level is not None and float(level.group(1)) <= MAX_EXPOSURE,
                    f"security of {service}: {level.group(1) if level else said.strip()} (0 best, 10 worst)")


def watch_bus(container, seconds):
    """The state of the bus as gw-monitor sees it."""
    return container.run(f"timeout -s INT {seconds} gw-monitor --lcm-url 'udpm://239.255.76.67:7667?ttl=0' "
                         "--out /run/monitor 2>/dev/null; true").strip().splitlines()[-1]


def exercise(container, test):
    container.run("dpkg -i /gw-test/good-weights.deb")
    check_units(container, test)
    preflight = container.run("gw-preflight", check=False)
    test.expect("no RealSense D435i" in preflight and "no /dev/kobuki" in preflight and "multicast" in preflight,
                "gw-preflight names what this machine lacks")

    configure(container)
    container.systemctl("start good-weights.target")
    for service in SERVICES:
        took = test.wait_active(service, 0, 30)
        test.expect(took is not None, f"{service} starts")
    test.boot_order(["good-weights-bus", *SERVICES])
    simulate(container)
    time.sleep(3)
    said = watch_bus(container, 6)
    print("  monitor:", said)
    images = re.search(r"images (\d+), poses (\d+)", said)
    test.expect(images is not None and int(images.group(2)) > 0, "images become poses")
    preflight = container.run("gw-preflight", check=False)
    test.expect("no route" not in preflight, "the bus stays on this host")
    page = [line for line in preflight.splitlines() if re.match(r"(ok|warn|FAIL) +page ", line)]
    test.expect(page and page[0].startswith("ok"), f"gw-view serves its page: {' '.join(page)}")

    for service in SERVICES:
        test.kill(service, BACK_LIMIT_S)
    for service in SERVICES:
        test.stall(service, STALL_LIMIT_S)
    test.too_often("gw-recorder")
    said = watch_bus(container, 6)
    print("  monitor:", said)
    images = re.search(r"images (\d+), poses (\d+)", said)
    test.expect(images is not None and int(images.group(2)) > 0, "images become poses after all that")
    events = container.run("ls /var/lib/good-weights/log/events", check=False).split()
    test.expect(events, f"evidence of the stalls is kept: {len(events)} folders")

    before = {s: container.show(s, "MainPID") for s in SERVICES}
    container.run("echo '# mine' >> /etc/good-weights/robot.yaml; dpkg -i /gw-test/newer.deb")
    version = container.run("dpkg-query -W -f '${Version}' good-weights")
    test.expect(version.endswith("+next"), f"upgrade to {version}")
    active = [s for s in SERVICES if test.wait_active(s, 0, 30) is not None]
    restarted = [s for s in SERVICES if container.show(s, "MainPID") != before[s]]
    test.expect(active == restarted == SERVICES, "after an upgrade the services run, from the new programs")
    test.expect("# mine" in container.run("cat /etc/good-weights/robot.yaml"), "an upgrade keeps the configuration")

    container.run("dpkg --purge good-weights")
    left = container.run("find / -xdev \\( -path /proc -o -path /sys -o -path '/gw-*' \\) -prune -o "
                         "\\( -name '*good-weights*' -o -name 'gw-*' \\) -print | grep -v '^/run\\|/sys/\\|test.conf\\|"
                         "gw-kobuki.service.d'", check=False).split()
    test.expect(not left, f"purge leaves nothing{': ' + ' '.join(left) if left else ''}")
    running = container.systemctl("list-units --no-legend --plain 'gw-*.service'")
    test.expect("running" not in running, "purge stops the services")


def main():
    package_dir, source, bin_dir, work = (os.path.abspath(p) for p in sys.argv[1:5])
    if os.geteuid() != 0:
        skip("needs root (systemd-nspawn, overlay mount)")
    for tool, name in (("systemd-nspawn", "systemd-container"), ("debootstrap", "debootstrap")):
        if shutil.which(tool) is None:
            skip(f"{tool} is missing: apt-get install {name}")
    packages = glob.glob(f"{package_dir}/good-weights_*.deb")
    if len(packages) != 1:
        skip(f"no package, or several, in {package_dir}: tools/dev package dev")
    package = packages[0]
    os.makedirs(f"{work}/test", exist_ok=True)
    make_base(f"{work}/base", package, f"{work}/base.log")
    with open(f"{work}/test/scenario.yaml", "w") as out:
        out.write(SCENARIO.format(scenarios="/gw-scenarios"))
    shutil.copy(package, f"{work}/test/good-weights.deb")
    newer_version(package, work)
    container = Container(f"{work}/base", work, [f"{bin_dir}:/gw-bin", f"{source}/config/scenarios:/gw-scenarios",
                                                 f"{work}/test:/gw-test"])
    test = Test(container)
    try:
        exercise(container, test)
    finally:
        container.stop()
    print(f"{len(test.failures)} failed")
    sys.exit(1 if test.failures else 0)


if __name__ == "__main__":
    main()
