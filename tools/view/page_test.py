#!/usr/bin/env python3
"""The page of gw-view and a report in a browser, gw-view's protocol by Foxglove's own client, MCAP files by @mcap/core.

usage: page_test.py BIN PAGE_WORK CONFIG WORK
Exit 0 ok, 1 failed, 77 skipped (says why): Debian's chromium, node and the npm packages of the page are needed.
"""
import os
import shutil
import signal
import subprocess
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, f"{HERE}/../../test/multiproc")
from live_system import URL, enter_private_network, skip  # noqa: E402

TOPICS = ("/tf /pose /trajectory /map/keyframes /map/landmarks /camera/image /camera/features /weights /dead_reckoning "
          "/error /health /log /viewer").split()


def protocol(bin_dir, log):
    """True when Foxglove's client gets every topic, and each message fits its schema."""
    view = subprocess.Popen([f"{bin_dir}/gw-view", log, "--listen", "127.0.0.1:0", "--speed", "5"],
                            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    address = view.stdout.readline().strip()
    try:
        return subprocess.run(["node", f"{HERE}/page/test/protocol_check.mjs", address, "20", *TOPICS]).returncode == 0
    finally:
        view.terminate()
        view.wait()


def mcap(bin_dir, log, work):
    out = f"{work}/example.mcap"
    subprocess.run([f"{bin_dir}/gw-log", "export", log, "--mcap", out], check=True)
    return subprocess.run(["node", f"{HERE}/page/test/mcap_check.mjs", out]).returncode == 0


def report(bin_dir, log, config, work):
    """True when a report of the log, as it went over the bus, shows what it should."""
    out = f"{work}/report.html"
    watcher = subprocess.Popen([f"{bin_dir}/gw-report", "--config", config, "--lcm-url", URL, "--out", out],
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    time.sleep(2)  # LCM's subscribers test multicast on themselves first
    subprocess.run(["lcm-logplayer", f"--lcm-url={URL}", "--speed=5", log], check=True, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)
    watcher.send_signal(signal.SIGINT)
    if watcher.wait(timeout=30) != 0:
        print("FAILED: gw-report")
        return False
    return subprocess.run(["node", f"{HERE}/page/test/report_check.mjs", out, f"{work}/report.png"]).returncode == 0


def main():
    bin_dir, packages, config, work = sys.argv[1:5]
    chromium = shutil.which("chromium")
    if shutil.which("node") is None or not os.path.isdir(f"{packages}/node_modules"):
        skip("npm is missing, or the page was not built")
    if shutil.which("lcm-logplayer") is None:
        skip("lcm-logplayer is missing")
    enter_private_network()
    os.makedirs(work, exist_ok=True)
    os.environ["GW_PAGE_PACKAGES"] = packages
    log = f"{work}/example.lcm"
    subprocess.run([f"{bin_dir}/gw-view-example-log", log], check=True)
    good = protocol(bin_dir, log)
    good = mcap(bin_dir, log, work) and good
    if chromium is None:
        print("NOT TESTED: the page in a browser, because chromium is missing: apt-get install chromium")
        return 77 if good else 1
    os.environ["GW_CHROMIUM"] = chromium
    page = subprocess.run(["node", f"{HERE}/page/test/page_test.mjs", bin_dir, log, config, work])
    good = report(bin_dir, log, config, work) and good
    return 0 if good and page.returncode == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
