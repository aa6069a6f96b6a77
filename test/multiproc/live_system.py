"""The estimator processes live on a bus of their own, fed by lcm-logplayer: for tests that kill them."""
import csv
import os
import shutil
import signal
import subprocess
import sys
import time

SKIP = 77
NEEDED_RMEM = 4 << 20
URL = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=8388608"


def skip(why):
    print("skipped:", why)
    sys.exit(SKIP)


def enter_private_network():
    """Re-executes this script in a network namespace of its own, with multicast on its loopback."""
    if os.environ.get("GW_PRIVATE_NETWORK"):
        return
    with open("/proc/sys/net/core/rmem_max") as f:
        rmem = int(f.read())
    if rmem < NEEDED_RMEM:
        try:
            with open("/proc/sys/net/core/rmem_max", "w") as f:
                f.write(str(16 << 20))
        except OSError:
            skip(f"net.core.rmem_max is {rmem}: images would get lost; sysctl -w net.core.rmem_max=16777216")
    setup = ("ip link set lo up multicast on && ip route add 239.255.76.67/32 dev lo && "
             "GW_PRIVATE_NETWORK=1 exec \"$@\"")
    command = ["unshare", "-rn", "sh", "-c", setup, "sh", sys.executable] + sys.argv
    if subprocess.run(["unshare", "-rn", "true"], stderr=subprocess.DEVNULL).returncode != 0:
        skip("unshare -rn is not allowed here")
    sys.exit(subprocess.run(command).returncode)


def busy():
    """True when others use this host, so that images get lost in full buffers; prints that less is judged then."""
    load, cores = os.getloadavg()[0], os.cpu_count()
    if load <= cores + 1:
        return False
    print(f"load {load:.1f} on {cores} cores: times and losses are printed, not judged")
    return True


class Claims:
    """The claims of a test about what it measured."""

    def __init__(self):
        self.failures = []

    def expect(self, condition, claim):
        if not condition:
            self.failures.append(claim)
            print("  FAILED:", claim)

    def end(self):
        """Ends the test with its exit code."""
        print(f"{len(self.failures)} failed")
        sys.exit(1 if self.failures else 0)


def player(log, channels="CAMERA|DR|IMU|WHEEL", speed=1.0):
    """The command that plays a log."""
    return ["lcm-logplayer", "--lcm-url=" + URL, f"--speed={speed}", f"--regexp=^({channels})$", log]


def rendered(bin_dir, scenario, work):
    """Log, configuration and reference of a scenario; rendered when they are not in `work` yet (GB)."""
    log, config = f"{work}/log.lcm", f"{work}/log.yaml"
    if not os.path.exists(log):
        subprocess.run([f"{bin_dir}/gw-sim", "--scenario", scenario, "--log", log, "--config-out", config],
                       check=True, stdout=subprocess.DEVNULL)
    return log, config, log


def recorded(bin_dir, data, work):
    """Log, configuration and reference of the recording, with dead reckoning made from its ground truth."""
    recording = f"{data}/tum_fr1_rpy_first400"
    if not os.path.isdir(recording):
        skip(f"no recording at {recording}")
    log, config, truth = f"{work}/log.lcm", f"{work}/log.yaml", f"{work}/truth.tum"
    os.makedirs(work, exist_ok=True)
    subprocess.run([f"{bin_dir}/gw-import", "tum", recording, "--out", log, "--config-out", config,
                    "--ground-truth-out", truth, "--dr-from-groundtruth", "sigma_t=0.004,sigma_r=0.1deg,seed=1"],
                   check=True, stdout=subprocess.DEVNULL)
    return log, config, truth


class System:
    """The processes of the robot, and the monitor."""

    def __init__(self, bin_dir, config, out, names=("gw-backend", "gw-dr-ekf", "gw-frontend")):
        self.bin, self.config, self.out = bin_dir, config, out
        shutil.rmtree(out, ignore_errors=True)
        os.makedirs(out)
        self.processes = {}
        self.monitor = subprocess.Popen([f"{bin_dir}/gw-monitor", "--lcm-url", URL, "--out", out],
                                        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        for name in names:
            self.start(name)
        time.sleep(2)  # LCM's subscribers first test multicast on themselves

    def start(self, name):
        extra = ["--map", f"{self.out}/map"] if name == "gw-backend" else []
        self.processes[name] = subprocess.Popen(
            [f"{self.bin}/{name}", "--config", self.config, "--lcm-url", URL] + extra,
            stderr=open(f"{self.out}/{name}.err", "a"))

    def kill(self, name):
        self.processes[name].send_signal(signal.SIGKILL)
        self.processes[name].wait()

    def play_and_kill(self, source, kill=None, at_s=4.0, down_s=0.1):
        """Runs the command `source`, which feeds the bus; kills one process on the way and starts it again
        down_s later, as its service does. Wall time of the new start, us."""
        feeding = subprocess.Popen(source, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        restarted = None
        if kill:
            time.sleep(at_s)
            self.kill(kill)
            time.sleep(down_s)
            restarted = clock_us()
            self.start(kill)
        feeding.wait()
        time.sleep(1)
        return restarted

    def stop(self):
        """Ends everything; gives the exit codes and the monitor's line."""
        codes = {}
        for name, process in self.processes.items():
            process.send_signal(signal.SIGTERM)
        for name, process in self.processes.items():
            codes[name] = process.wait(timeout=10)
        self.monitor.send_signal(signal.SIGINT)
        summary = self.monitor.communicate(timeout=10)[0]
        return codes, summary.strip()


def clock_us():
    return int(time.time() * 1e6)


def rows(path):
    with open(path) as f:
        return list(csv.DictReader(f))


def ape(bin_dir, truth, estimate):
    out = subprocess.run([f"{bin_dir}/gw-eval", "--ref", truth, "--est", estimate], capture_output=True, text=True)
    return next(float(line.split()[3]) for line in out.stdout.splitlines() if line.startswith("APE translation"))
