#!/usr/bin/env python3
"""gw-backend killed with -9 at random times while a log is replayed live: the map on disk always loads, the
process is back within a second, and the poses are about as good as undisturbed.

usage: kill_test.py BIN_DIR DATA_DIR WORK_DIR [--kills N] [--runs N] [--seed N] [--scenario S.yaml] [--speed X]
Without --scenario the recording of DATA_DIR is replayed; with it, gw-sim renders one first (GB).
Undisturbed runs of one recording differ by some percent of APE, as processes meet in another order: the recording
is replayed --runs times with and without kills, and the ratio of the means is judged. It fails where the ratio is above
its bar by more than twice its standard error: nearer, the runs do not tell. A single run is judged as it is.
Prints what it measured. Exit 0 ok, 1 failed, 77 skipped (says why).
"""
import argparse
import json
import os
import random
import shutil
import statistics
import subprocess
import time

from live_system import Claims, System, ape, clock_us, enter_private_network, player, recorded, rendered, rows, skip

REJOIN_S = 1.0
APE_RATIO = 1.1
LEAST_UP_S = 0.5  # shortest time between two kills: less than LCM's own start-up would test nothing


def duration_s(args, log):
    out = subprocess.run([f"{args.bin}/gw-log", "info", "--json", log], capture_output=True, text=True, check=True)
    return json.loads(out.stdout)["duration_s"]


def run(args, log, config, out, kill_times):
    """Replays; kills at the given seconds. Exit codes, problems of the map, and per kill the time until the process
    was back; None where the next kill came before it could be."""
    system = System(args.bin, config, out)
    feeding = subprocess.Popen(player(log, speed=args.speed), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    begin = time.monotonic()
    unreadable, restarts, kills = [], [], []
    for at in kill_times:
        time.sleep(max(0.0, begin + at - time.monotonic()))
        if feeding.poll() is not None:
            break
        kills.append(clock_us())
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
    print(f"{len(restarts)} kills: {summary}, exit codes {codes}")
    ends = kills[1:] + [clock_us()]
    return codes, unreadable, [time_to_report(health, *life) for life in zip(restarts, ends)]


def time_to_report(health, start, end):
    """Seconds from the start of a process to its first HEALTH; None when it was ended too early to judge."""
    first = min((t for t in health if start <= t < end), default=end)
    return None if first == end and end - start < REJOIN_S * 1e6 else (first - start) * 1e-6


def ratio_of_means(above, below):
    """Ratio of two means and its standard error; 0 of single values, which do not tell it."""
    def relative_variance(values):
        return statistics.variance(values) / len(values) / statistics.mean(values)**2 if len(values) > 1 else 0.0
    ratio = statistics.mean(above) / statistics.mean(below)
    return ratio, ratio * (relative_variance(above) + relative_variance(below))**0.5


def in_mm(lengths_m):
    return ", ".join(f"{1000 * length:.1f}" for length in lengths_m) + " mm"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("bin")
    parser.add_argument("data")
    parser.add_argument("work")
    parser.add_argument("--kills", type=int, default=3)
    parser.add_argument("--runs", type=int, default=3)
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
    slot = (duration_s(args, log) / args.speed - 2) / args.kills
    if slot < 2 * LEAST_UP_S:
        skip(f"{args.kills} kills do not fit into {slot * args.kills:.0f} s")

    claims = Claims()
    chance = random.Random(args.seed)
    undisturbed, killed, back = [], [], []
    for _ in range(args.runs):
        out = f"{args.work}/undisturbed"
        run(args, log, config, out, [])
        undisturbed.append(ape(args.bin, truth, f"{out}/trajectory.tum"))

        out = f"{args.work}/killed"
        times = [1 + slot * i + chance.uniform(0, slot - LEAST_UP_S) for i in range(args.kills)]
        codes, unreadable, rejoin = run(args, log, config, out, times)
        killed.append(ape(args.bin, truth, f"{out}/trajectory.tum"))
        back += rejoin
        check = subprocess.run([f"{args.bin}/gw-map", "check", f"{out}/map"], capture_output=True, text=True)
        print("  " + (check.stdout + check.stderr).strip())
        claims.expect(len(rejoin) == args.kills, "every kill happened")
        claims.expect(not unreadable, f"the map loads after every kill: {unreadable[:1]}")
        claims.expect(check.returncode == 0, "the map is whole at the end")
        claims.expect(all(c == 0 for c in codes.values()), "SIGTERM ends every process with 0")

    too_early = back.count(None)
    back = sorted(t for t in back if t is not None)
    ratio, error = ratio_of_means(killed, undisturbed)
    print(f"  seed {args.seed}, {len(back) + too_early} kills: back after {back[len(back) // 2]:.3f} s (median), "
          f"{back[-1]:.3f} s (longest), {too_early} killed again before; APE {in_mm(killed)}, undisturbed {in_mm(undisturbed)}: {ratio:.2f} +- {error:.2f}")
    claims.expect(back[-1] < REJOIN_S, f"gw-backend is back within {REJOIN_S} s")
    claims.expect(ratio - 2 * error <= APE_RATIO, f"APE at most {APE_RATIO} x undisturbed")
    claims.end()


if __name__ == "__main__":
    main()
