#!/usr/bin/env python3
"""What gw-view costs the robot: the three estimators on a stereo log in real time, with gw-view and 0, 1 and 5 clients, of which
one stalls, and without gw-view.

usage: cost_study.py BIN LOG CONFIG WORK [SECONDS]
Prints a row per case: latency of the front-end (image received to pose received), CPU of gw-view in percent of a core, its
memory at the begin and the end, messages dropped. Exit 77 where there is no private network.
"""
import os
import socket
import statistics
import subprocess
import sys
import threading
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, f"{HERE}/../../test/multiproc")
from live_system import enter_private_network, rows  # noqa: E402

URL = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=8388608"
HANDSHAKE = ("GET / HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
             "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: foxglove.websocket.v1\r\n\r\n")
TOPICS = 15


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
        while not self.stalled:
            part = self.socket.recv(1 << 16)
            self.received += len(part)
            if not part:
                return
            if time.monotonic() - said > 10:
                self.say('{"op":"getParameters","parameterNames":[]}' + " " * 100)
                said = time.monotonic()


def cpu_s(pid):
    with open(f"/proc/{pid}/stat") as f:
        fields = f.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def memory_mb(pid):
    with open(f"/proc/{pid}/statm") as f:
        return int(f.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def measure(bin_dir, log, config, out, clients, seconds):
    os.makedirs(out, exist_ok=True)
    start = lambda *a: subprocess.Popen(a, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)  # noqa: E731
    monitor = start(f"{bin_dir}/gw-monitor", "--lcm-url", URL, "--out", out)
    estimators = [start(f"{bin_dir}/{p}", "--config", config, "--lcm-url", URL)
                  for p in ("gw-backend", "gw-dr-ekf", "gw-frontend")]
    view, readers = None, []
    if clients is not None:
        view = start(f"{bin_dir}/gw-view", "--config", config, "--lcm-url", URL, "--listen", "127.0.0.1:0")
        port = int(view.stdout.readline().rsplit(":", 1)[1].strip().strip("/"))
        readers = [Client(port, stalled=(i == 1)) for i in range(clients)]
        for reader in readers:
            reader.start()
    time.sleep(2)
    player = start("lcm-logplayer", f"--lcm-url={URL}", "--regexp=^(CAMERA|IMU|WHEEL|GROUND_TRUTH)$", log)
    time.sleep(5)
    before = (cpu_s(view.pid), memory_mb(view.pid), time.monotonic()) if view else None
    try:
        player.wait(timeout=seconds)
    except subprocess.TimeoutExpired:
        player.terminate()
    usage = ""
    if view:
        percent = 100 * (cpu_s(view.pid) - before[0]) / (time.monotonic() - before[2])
        sent = sum(r.received for r in readers) / 1e6 / (time.monotonic() - before[2])
        usage = f" {percent:.1f} % | {before[1]:.0f} -> {memory_mb(view.pid):.0f} MB | {sent:.2f} MB/s |"
    for process in [monitor, *estimators] + ([view] if view else []):
        process.terminate()
        process.wait()
    latencies = sorted(int(f["latency_us"]) / 1e3 for f in rows(f"{out}/frames.csv") if int(f["latency_us"]) > 0)
    p99 = latencies[int(0.99 * (len(latencies) - 1))] if latencies else float("nan")
    median = statistics.median(latencies) if latencies else float("nan")
    name = "without gw-view" if clients is None else f"{clients} clients"
    print(f"| {name} | {len(latencies)} images | median {median:.2f} ms | p99 {p99:.2f} ms |{usage}", flush=True)


def main():
    bin_dir, log, config, work = sys.argv[1:5]
    seconds = float(sys.argv[5]) if len(sys.argv) > 5 else 60
    enter_private_network()
    print("load:", os.getloadavg()[0])
    for clients in (None, 0, 1, 5, None):
        measure(bin_dir, log, config, f"{work}/{clients}", clients, seconds)


if __name__ == "__main__":
    main()
