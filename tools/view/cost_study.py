#!/usr/bin/env python3
"""What gw-view costs the robot, on a stereo log played live through the three estimators.

usage: cost_study.py pairs  BIN LOG CONFIG WORK [ROUNDS]    default 10
       cost_study.py memory BIN LOG CONFIG WORK [LAPS]      one gw-view with 5 clients over all laps
A round of `pairs` plays the log three times, beside gw-view with 0, 1 and 5 clients, of which one reads nothing. Within each, gw-view is
stopped and goes on by turns (SIGSTOP, SIGCONT), two seconds each: what else happens on the machine is then the same with it and
without. Stopped, it takes no CPU time, and its full socket no messages. The latency is from the arrival of an image to that of its
pose, at a third process. Exit 77 where there is no private network.
"""
import json
import os
import signal
import socket
import statistics
import subprocess
import sys
import threading
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, f"{HERE}/../../test/multiproc")
from live_system import URL, enter_private_network, rows  # noqa: E402

HANDSHAKE = ("GET / HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
             "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: foxglove.websocket.v1\r\n\r\n")
TOPICS = 15
STATES = (0, 1, 5)  # clients
STALLED = 1  # which of five clients reads nothing
SETTLE_S = 3.0  # at the begin of a lap, not counted: clients connect, a map begins
# Before whatever else runs on the machine, which needs root; gw-view and its clients far behind the rest, if less far than as a
# service (deploy/systemd: 15 and -10).
ROBOT_NICE, VIEW_NICE = -20, -5
TURN_S = 2.0  # that gw-view is stopped or goes on
CATCH_UP_S = 0.5  # at the begin of a turn, not counted: gw-view reads what waited
NAMES = {0: "no client", 1: "1 client", 5: "5 clients, one stalled"}


class Client(threading.Thread):
    """Subscribes to everything, and reads it; or, stalled, does not. Does not answer pings either, which gw-view
    takes for death after 30 s: a client that reads says something every 10 s."""

    def __init__(self, port, stalled):
        super().__init__(daemon=True)
        self.stalled, self.received = stalled, 0
        self.socket = socket.create_connection(("127.0.0.1", port))
        self.socket.sendall(HANDSHAKE.encode())
        channels = ",".join(f'{{"id":{i},"channelId":{i}}}' for i in range(1, TOPICS + 1))
        self.say(f'{{"op":"subscribe","subscriptions":[{channels}]}}')

    def say(self, text):
        payload = text.encode()
        self.socket.sendall(bytes([0x81, 0xFE]) + len(payload).to_bytes(2, "big") + bytes(4) + payload)

    def run(self):
        prefer(VIEW_NICE)
        said = time.monotonic()
        try:
            while not self.stalled:
                part = self.socket.recv(1 << 16)
                self.received += len(part)
                if not part:
                    return
                if time.monotonic() - said > 10:
                    self.say('{"op":"getParameters","parameterNames":[]}' + " " * 100)
                    said = time.monotonic()
        except OSError:
            return  # gw-view has ended


def prefer(nice):
    """This thread, and what it starts; True where that is allowed: only root may go below 0, and nobody in a private network."""
    try:
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), nice)
    except PermissionError:
        return False
    return True


def start(*command, nice=ROBOT_NICE):
    return subprocess.Popen(command, preexec_fn=lambda: prefer(nice), stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)


def end(*processes):
    for process in processes:
        process.terminate()
        process.wait()


class View:
    """gw-view with clients; what it takes from `begin` on."""

    def __init__(self, bin_dir, config):
        self.process = start(f"{bin_dir}/gw-view", "--config", config, "--lcm-url", URL, "--listen", "127.0.0.1:0", nice=VIEW_NICE)
        self.port = int(self.process.stdout.readline().rsplit(":", 1)[1].strip().strip("/"))
        self.clients = []

    def connect(self, clients):
        for i in range(clients):
            client = Client(self.port, stalled=(i == STALLED))
            client.start()
            self.clients.append(client)

    def begin(self):
        self.before = (self.cpu_s(), time.monotonic(), sum(c.received for c in self.clients))

    def share_of_a_core(self):
        return (self.cpu_s() - self.before[0]) / (time.monotonic() - self.before[1])

    def cpu_s(self):
        with open(f"/proc/{self.process.pid}/stat", encoding="utf-8") as f:
            fields = f.read().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def memory_mb(self):
        """Its own, and pages of files: those of the libraries are shared, and come and go with what the machine does."""
        with open(f"/proc/{self.process.pid}/statm", encoding="utf-8") as f:
            resident, of_files = (int(pages) * os.sysconf("SC_PAGE_SIZE") / 1e6 for pages in f.read().split()[1:3])
        return resident - of_files, of_files

    def end(self):
        end(self.process)
        for client in self.clients:
            client.socket.close()


class Lap:
    """The estimators and gw-monitor on the log, from its begin to its end."""

    def __init__(self, bin_dir, log, config, out):
        os.makedirs(out, exist_ok=True)
        self.out = out
        self.programs = [start(f"{bin_dir}/gw-monitor", "--lcm-url", URL, "--out", out)]
        self.programs += [start(f"{bin_dir}/{p}", "--config", config, "--lcm-url", URL)
                          for p in ("gw-backend", "gw-dr-ekf", "gw-frontend")]
        time.sleep(2)
        self.player = start("lcm-logplayer", f"--lcm-url={URL}", "--regexp=^(CAMERA|IMU|WHEEL|GROUND_TRUTH)$", log)
        self.begin = time.time()

    def wait(self, seconds):
        """Until so many seconds of the lap are over, or the log is."""
        try:
            self.player.wait(timeout=max(0.01, self.begin + seconds - time.time()))
        except subprocess.TimeoutExpired:
            pass

    def end(self):
        """Arrival of every image since the begin of the lap (s), and the latency of its pose (ms)."""
        end(self.player)
        time.sleep(0.5)
        end(*self.programs)
        arrivals = rows(f"{self.out}/pose_times.csv")
        offset = statistics.median(int(a["received"]) - int(a["utime"]) for a in arrivals) * 1e-6
        return [(int(f["utime"]) * 1e-6 + offset - self.begin, int(f["latency_us"]) / 1e3)
                for f in rows(f"{self.out}/frames.csv") if int(f["latency_us"]) > 0]


def quantile(values, q):
    ordered = sorted(values)
    return ordered[int(q * (len(ordered) - 1))]


def run_lap(arguments, clients, seconds, off_first, found):
    """One lap. Adds latencies (ms) after SETTLE_S to found[clients][whether gw-view ran]."""
    bin_dir, log, config, work = arguments
    view = View(bin_dir, config)
    view.connect(clients)
    lap = Lap(bin_dir, log, config, f"{work}/lap")
    lap.wait(SETTLE_S)
    turns, at = [], SETTLE_S  # (begin, whether gw-view runs)
    while at + TURN_S <= seconds:
        runs = (len(turns) + off_first) % 2 == 0
        view.process.send_signal(signal.SIGCONT if runs else signal.SIGSTOP)
        turns.append((time.time() - lap.begin, runs))
        lap.wait(at + CATCH_UP_S)
        cpu = view.cpu_s()
        at += TURN_S
        lap.wait(at)
        if runs:
            found[clients]["cpu"].append(100 * (view.cpu_s() - cpu) / (TURN_S - CATCH_UP_S))
    view.process.send_signal(signal.SIGCONT)
    for arrived, latency in lap.end():
        for begin, runs in turns:
            if begin + CATCH_UP_S < arrived < begin + TURN_S:
                found[clients][runs].append(latency)
    view.end()


def pairs(arguments, seconds, rounds):
    found = {s: {True: [], False: [], "ratios": [], "cpu": []} for s in STATES}
    for number in range(rounds):
        for state in STATES:
            before = {runs: len(found[state][runs]) for runs in (True, False)}
            run_lap(arguments, state, seconds, number % 2, found)
            p99 = {runs: quantile(found[state][runs][before[runs]:], 0.99) for runs in (True, False)}
            found[state]["ratios"].append(p99[True] / p99[False])
        print(f"after round {number + 1}, load {os.getloadavg()[0]:.1f}", flush=True)
        for state in STATES:
            print_state(state, found[state])


def print_state(state, f):
    p = {(runs, q): quantile(f[runs], q) for runs in (True, False) for q in (0.5, 0.99)}
    print(f"| {NAMES[state]} | {len(f[True])}, {len(f[False])} images | median {p[True, 0.5]:.2f}, without {p[False, 0.5]:.2f} ms |"
          f" p99 {p[True, 0.99]:.2f}, without {p[False, 0.99]:.2f} ms, ratio {p[True, 0.99] / p[False, 0.99]:.3f};"
          f" by lap: median {statistics.median(f['ratios']):.3f}, quartiles {quantile(f['ratios'], 0.25):.3f},"
          f" {quantile(f['ratios'], 0.75):.3f} | {statistics.mean(f['cpu']):.1f} % of a core |", flush=True)


def memory(arguments, seconds, laps):
    bin_dir, log, config, work = arguments
    view = View(bin_dir, config)
    begin = time.monotonic()
    print("| | its own | pages of files | CPU time |", flush=True)
    for _ in range(laps):
        view.connect(5 if not view.clients else 0)
        if len(view.clients) > STALLED:  # the stalled one was cut off in the lap before
            view.clients.pop(STALLED).socket.close()
            view.clients.insert(STALLED, Client(view.port, stalled=True))
        lap = Lap(bin_dir, log, config, f"{work}/memory")
        view.begin()
        lap.wait(seconds)
        own, of_files = view.memory_mb()
        print(f"| after {(time.monotonic() - begin) / 60:.1f} min | {own:.1f} MB | {of_files:.1f} MB | "
              f"{100 * view.share_of_a_core():.1f} % of a core | load {os.getloadavg()[0]:.1f} |", flush=True)
        lap.end()
    view.end()


def log_seconds(bin_dir, log):
    text = subprocess.run([f"{bin_dir}/gw-log", "info", log, "--json"], capture_output=True, text=True, check=True).stdout
    return float(json.loads(text)["duration_s"])


def main():
    mode, *arguments = sys.argv[1:6]
    repeats = int(sys.argv[6]) if len(sys.argv) > 6 else 10
    if not os.environ.get("GW_PRIVATE_NETWORK") and not prefer(ROBOT_NICE):
        print("without root's priority: other work on this machine is measured too")
    enter_private_network()
    seconds = log_seconds(arguments[0], arguments[1])
    {"pairs": pairs, "memory": memory}[mode](arguments, seconds, repeats)


if __name__ == "__main__":
    main()
