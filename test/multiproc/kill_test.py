#!/usr/bin/env python3
"""gw-backend killed with -9 at random times while a log is replayed live: the map on disk always loads, the
process is back within a second, and the poses are about as good as undisturbed.

usage: kill_test.py BIN_DIR DATA_DIR WORK_DIR [--kills N] [--seed N] [--scenario S.yaml] [--speed X]
Without --scenario the recording of DATA_DIR is replayed; with it, gw-sim renders one first (GB).
Prints what it measured. Exit 0 ok, 1 failed, 77 skipped (says why).
"""
import argparse
import json
import os
import random
import shutil
import subprocess
import time

from live_system import Claims, System, ape, clock_us, enter_private_network, player, recorded, rendered, rows, skip

REJOIN_S = 1.0
APE_RATIO = 1.1
LEAST_UP_S = 1.0  # between a restart and the next kill: shorter than LCM's own start-up would test nothing


def duration_s(args, log):
    out = subprocess.run([f"{args.bin}/gw-log", "info", "--json", log], capture_output=True, text=True, check=True)
    return json.loads(out.stdout)["duration_s"]


def run(args, log, config, out, kill_times):
    """Replays; kills at the given seconds. Per kill: problems of the map, time until the process was back."""
    system = System(args.bin, config, out)
    feeding = subprocess.Popen(player(log, speed=args.speed), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    begin = time.monotonic()
    unreadable, restarts = [], []
    for at in kill_times:
        time.sleep(max(0.0, begin + at - time.monotonic()))
        if feeding.poll() is not None:
            break
        system.kill("gw-backend")
        check = subprocess.run([f"{args.bin}/gw-map", "check", f"{out}/map"], capture_output=True, text=True)
        if check.returncode != 0:
            unreadable.append(check.stdout + check.stderr)
        restarts.append(clock_us())
        system.start("gw-backend")
    feeding.wait()
    time.sleep(1)
    codes, summary = system.stop()
    health = [int(row["utime"]) for row in rows(f"{out}/health.csv") if row["process"] == "gw-backend"]
    rejoin = [min((t for t in health if t >= r), default=r + 10**9) - r for r in restarts]
    print(f"{len(restarts)} kills: {summary}, exit codes {codes}")
    return codes, unreadable, sorted(t * 1e-6 for t in rejoin)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("bin")
    parser.add_argument("data")
    parser.add_argument("work")
    parser.add_argument("--kills", type=int, default=3)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--scenario")
    parser.add_argument("--speed", type=float, default=1.0, help="below 1 on a machine that cannot follow")
    args = parser.parse_args()
    if shutil.which("lcm-logplayer") is None:
        skip("lcm-logplayer is missing")
    enter_private_network()
    os.makedirs(args.work, exist_ok=True)
    if args.scenario:
        log, config, truth = rendered(args.bin, args.scenario, args.work)
    else:
        log, config, truth = recorded(args.bin, args.data, args.work)
    length = duration_s(args, log) / args.speed
    claims = Claims()

    run(args, log, config, f"{args.work}/undisturbed", [])
    undisturbed = ape(args.bin, truth, f"{args.work}/undisturbed/trajectory.tum")

    chance = random.Random(args.seed)
    slot = (length - 2) / args.kills
    if slot < LEAST_UP_S:
        skip(f"{args.kills} kills do not fit into {length:.0f} s")
    times = [1 + slot * i + chance.uniform(0, slot - LEAST_UP_S / 2) for i in range(args.kills)]
    out = f"{args.work}/killed"
    codes, unreadable, rejoin = run(args, log, config, out, times)
    killed = ape(args.bin, truth, f"{out}/trajectory.tum")
    print(f"  seed {args.seed}, {len(rejoin)} kills: back after {rejoin[len(rejoin) // 2]:.3f} s (median), "
          f"{rejoin[-1]:.3f} s (longest); APE {killed:.4f} m, undisturbed {undisturbed:.4f} m")
    check = subprocess.run([f"{args.bin}/gw-map", "check", f"{out}/map"], capture_output=True, text=True)
    print("  " + (check.stdout + check.stderr).strip())
    claims.expect(len(rejoin) == args.kills, "every kill happened")
    claims.expect(not unreadable, f"the map loads after every kill: {unreadable[:1]}")
    claims.expect(check.returncode == 0, "the map is whole at the end")
    claims.expect(all(c == 0 for c in codes.values()), "SIGTERM ends every process with 0")
    claims.expect(rejoin[-1] < REJOIN_S, f"gw-backend is back within {REJOIN_S} s")
    claims.expect(killed <= APE_RATIO * undisturbed, f"APE at most {APE_RATIO} x undisturbed")
    claims.end()


if __name__ == "__main__":
    main()
