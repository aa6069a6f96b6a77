#!/usr/bin/env python3
"""A scenario through the estimator processes live, several times, against gw-slam on the same log: every image
gets a pose, and the error is that of the offline run within the spread of the live ones.

usage: live_scenario_study.py BIN_DIR SCENARIO.yaml WORK_DIR [--runs N] [--speed X]
gw-sim renders the scenario first (GB). Prints what it measured. Exit 0 ok, 1 failed, 77 skipped (says why).
"""
import argparse
import collections
import os
import shutil
import subprocess

from live_system import Claims, System, ape, busy, enter_private_network, player, rendered, rows, skip

STATUS = {"1": "initializing", "2": "tracking", "3": "degraded", "4": "dr_only", "5": "recovering", "6": "lost"}


def counts(path):
    return collections.Counter(STATUS.get(row["status"], row["status"]) for row in rows(path))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("bin")
    parser.add_argument("scenario")
    parser.add_argument("work")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--speed", type=float, default=1.0, help="below 1 on a machine that cannot follow")
    args = parser.parse_args()
    if shutil.which("lcm-logplayer") is None:
        skip("lcm-logplayer is missing")
    enter_private_network()
    os.makedirs(args.work, exist_ok=True)
    log, config, truth = rendered(args.bin, args.scenario, args.work)
    offline_dir = f"{args.work}/offline"
    subprocess.run([f"{args.bin}/gw-slam", log, "--config", config, "--out", offline_dir], check=True,
                   stderr=subprocess.DEVNULL)
    offline = ape(args.bin, truth, f"{offline_dir}/trajectory.tum")
    images = sum(counts(f"{offline_dir}/frames.csv").values())
    print(f"offline: {images} images, APE {offline:.4f} m, {dict(counts(f'{offline_dir}/frames.csv'))}", flush=True)
    host_is_busy = busy()
    claims, live = Claims(), []

    for i in range(args.runs):
        out = f"{args.work}/live-{i}"
        system = System(args.bin, config, out)
        system.play_and_kill(player(log, speed=args.speed))
        codes, summary = system.stop()
        status = counts(f"{out}/frames.csv")
        live.append(ape(args.bin, truth, f"{out}/trajectory.tum"))
        print(f"live {i}: APE {live[-1]:.4f} m, {dict(status)}; load {os.getloadavg()[0]:.1f}\n  {summary}",
              flush=True)
        claims.expect(all(c == 0 for c in codes.values()), f"SIGTERM ends every process with 0: {codes}")
        claims.expect(host_is_busy or sum(status.values()) == images, f"every one of {images} images has a pose")
        claims.expect(status["lost"] == 0, "the map is never lost")
    spread = max(live) - min(live)
    print(f"live: APE {min(live):.4f} to {max(live):.4f} m, mean {sum(live) / len(live):.4f} m; offline {offline:.4f} m")
    claims.expect(min(live) - spread <= offline <= max(live) + spread, "offline is within the spread of the live runs")
    claims.end()


if __name__ == "__main__":
    main()
