#!/usr/bin/env python3
"""What gw-view costs the robot, on a stereo log played live through the three estimators.

usage: cost_study.py pairs  BIN LOG CONFIG WORK [ROUNDS]    default 10
       cost_study.py memory BIN LOG CONFIG WORK [LAPS]      one gw-view with 5 clients over all laps
A round of `pairs` plays the log four times: without gw-view, and with it and 0, 1 or 5 clients, of which one reads nothing; their
order changes from round to round. The p99 of each is divided by that without gw-view of the same round, over the same images, so that
what else happens on the machine is nearly the same for both. The latency is from the arrival of an image to that of its pose, at a
third process. Exit 77 where there is no private network.
"""
import json
import os
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
STATES = (None, 0, 1, 5)  # clients; None: no gw-view
STALLED = 1  # which of five clients reads nothing
SETTLE_S = 3.0  # at the begin of a lap, not counted: clients connect, a map begins
NAMES = {None: "without gw-view", 0: "no client", 1: "1 client", 5: "5 clients, one stalled"}


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


def start(*command):
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)


def end(*processes):
    for process in processes:
        process.terminate()
        process.wait()


class View:
    """gw-view with clients, and what it takes from `begin` on."""

    def __init__(self, bin_dir, config):
        self.process = start(f"{bin_dir}/gw-view", "--config", config, "--lcm-url", URL, "--listen", "127.0.0.1:0")
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
        with open(f"/proc/{self.process.pid}/statm", encoding="utf-8") as f:
            return int(f.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6

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


def run_lap(arguments, clients, seconds, found):
    """One lap; latencies after SETTLE_S in ms."""
    bin_dir, log, config, work = arguments
    view = None
    if clients is not None:
        view = View(bin_dir, config)
        view.connect(clients)
    lap = Lap(bin_dir, log, config, f"{work}/lap")
    lap.wait(SETTLE_S)
    if view:
        view.begin()
    lap.wait(seconds - 0.5)
    if view:
        found["cpu"][clients].append(100 * view.share_of_a_core())
        found["memory"][clients].append(view.memory_mb())
    latencies = [latency for arrived, latency in lap.end() if arrived > SETTLE_S]
    if view:
        view.end()
    return latencies


def pairs(arguments, seconds, rounds):
    found = {"cpu": {s: [] for s in STATES}, "memory": {s: [] for s in STATES}}
    everything = {s: [] for s in STATES}
    ratios = {s: [] for s in STATES}
    for number in range(rounds):
        p99 = {}
        for k in range(len(STATES)):
            state = STATES[(k * (1 if number % 2 else -1) + number) % len(STATES)]
            latencies = run_lap(arguments, state, seconds, found)
            everything[state] += latencies
            p99[state] = quantile(latencies, 0.99)
        for state in STATES[1:]:
            ratios[state].append(p99[state] / p99[None])
        print(f"after round {number + 1}, load {os.getloadavg()[0]:.1f}", flush=True)
        for state in STATES:
            print_state(state, everything[state], ratios[state], found)


def print_state(state, latencies, ratios, found):
    line = f"| {NAMES[state]} | {len(latencies)} images | {quantile(latencies, 0.5):.2f}, {quantile(latencies, 0.99):.2f} ms |"
    if state is not None:
        line += (f" p99 ratio: median {statistics.median(ratios):.3f}, quartiles {quantile(ratios, 0.25):.3f} to"
                 f" {quantile(ratios, 0.75):.3f} of {len(ratios)} | {statistics.median(found['cpu'][state]):.1f} % of a core |"
                 f" {statistics.median(found['memory'][state]):.0f} MB |")
    print(line, flush=True)


def memory(arguments, seconds, laps):
    bin_dir, log, config, work = arguments
    view = View(bin_dir, config)
    begin = time.monotonic()
    for _ in range(laps):
        view.connect(5 if not view.clients else 0)
        if len(view.clients) > STALLED:  # the stalled one was cut off in the lap before
            view.clients.pop(STALLED).socket.close()
            view.clients.insert(STALLED, Client(view.port, stalled=True))
        lap = Lap(bin_dir, log, config, f"{work}/memory")
        view.begin()
        lap.wait(seconds)
        print(f"| after {(time.monotonic() - begin) / 60:.1f} min | {view.memory_mb():.1f} MB | {100 * view.share_of_a_core():.1f} % of a core |",
              flush=True)
        lap.end()
    view.end()


def log_seconds(bin_dir, log):
    text = subprocess.run([f"{bin_dir}/gw-log", "info", log, "--json"], capture_output=True, text=True, check=True).stdout
    return float(json.loads(text)["duration_s"])


def main():
    mode, *arguments = sys.argv[1:6]
    repeats = int(sys.argv[6]) if len(sys.argv) > 6 else 10
    enter_private_network()
    seconds = log_seconds(arguments[0], arguments[1])
    {"pairs": pairs, "memory": memory}[mode](arguments, seconds, repeats)


if __name__ == "__main__":
    main()
