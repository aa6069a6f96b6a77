#!/usr/bin/env python3
"""What half and double of every numeric constant of the cores do to the result of gw-slam.

    sensitivity.py build --scratch DIR [--commit HEAD] [--only REGEX]
    sensitivity.py run   --scratch DIR LOG[@T0:T1][+yaw][+dr][+twice]... [--only REGEX] [--seeds N] [--values V...]
    sensitivity.py table --scratch DIR

`build` copies the tree of a commit into DIR, makes the constants changeable there (instrument.py) and
builds gw-slam once. `run` runs each log (its configuration LOG.yaml beside it,
its reference LOG.gt.tum or the log itself) undisturbed from N starts, which is the scatter, and
with half and double of each constant: those of a file together first, and each by itself where that
changed anything. Every result is a line of DIR/runs.csv, and what is there is not run again. `table` prints Markdown.
"""
import argparse
import csv
import functools
import hashlib
import json
import os
import pathlib
import re
import resource
import shutil
import signal
import statistics
import subprocess
import sys
import time

import instrument

FOLDERS = ["frontend/core", "backend/core", "common/good_weights", "common/vision", "dr_ekf/core"]
FIELDS = ["constant", "direction", "log", "seed", "before", "after", "live", "keyframes", "digest", "exit", "cpu_s"]
MOST_CPU_SECONDS = 60  # of a run; constants that are off can make it endless. Not of the clock: the machine may be busy
NEAR_ONE = re.compile(r"Cos|Share|Ratio|Quality|Coverage|Part|Surface")


def repository():
    return pathlib.Path(subprocess.run(["git", "rev-parse", "--show-toplevel"], capture_output=True, text=True,
                                       check=True, cwd=pathlib.Path(__file__).parent).stdout.strip())


def program(name):
    """One that no constant changes: that of the repository's own build."""
    return repository() / "build/dev/bin" / name


# --- build

def write_changed(path, content):
    """Unchanged files keep their time, so that little is built again."""
    if not path.exists() or path.read_bytes() != content:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)


def copy_tree(scratch, commit):
    """The tree of a commit, into scratch/original."""
    original = scratch / "original"
    shutil.rmtree(original, ignore_errors=True)
    original.mkdir()
    archive = subprocess.run(["git", "archive", commit], capture_output=True, check=True, cwd=repository())
    subprocess.run(["tar", "-x", "-C", original], input=archive.stdout, check=True)


def write_instrumented(scratch, reverted, only):
    """scratch/tree: the copy, instrumented. Returns all constants."""
    original, constants = scratch / "original", []
    changeable = {p for p in instrument.sources(original, FOLDERS) if re.search(only, p)}
    for path in sorted(p for p in original.rglob("*") if p.is_file()):
        name, content = str(path.relative_to(original)), path.read_bytes()
        if name in changeable:
            text, found = instrument.instrument_text(name, content.decode(), reverted)
            constants += found
            content = text.encode()
        write_changed(scratch / "tree" / name, content)
    return constants


def build(scratch, commit, only):
    tree, log = scratch / "tree", scratch / "build.log"
    copy_tree(scratch, commit)
    kept = scratch / "needed_by_the_compiler.txt"
    reverted = set(kept.read_text().split()) if kept.exists() else set()
    constants = write_instrumented(scratch, reverted, only)
    # Preset, layout and flags of the repository itself, so that ccache knows what is unchanged.
    subprocess.run(["cmake", "--preset", "dev"], check=True, stdout=subprocess.DEVNULL, cwd=tree)
    while True:
        done = subprocess.run(["cmake", "--build", "build/dev", "--target", "gw-slam",
                               "--", "-j2", "-k0"], capture_output=True, text=True, cwd=tree)
        log.write_text(done.stdout + done.stderr)
        if done.returncode == 0:
            break
        new = instrument.to_revert(done.stdout + done.stderr, constants) - reverted
        if not new:
            sys.exit(f"the copy does not build, and no constant is named: {log}")
        print(f"needed by the compiler: {', '.join(sorted(new))}", flush=True)
        reverted |= new
        kept.write_text("\n".join(sorted(reverted)))
        constants = write_instrumented(scratch, reverted, only)
    with open(scratch / "constants.csv", "w", newline="") as f:
        writer = csv.writer(f)
        writer.writerow(["constant", "line", "value", "left_as_it_is"])
        writer.writerows([c.id, c.line, c.value, c.why] for c in constants)
    left = sum(1 for c in constants if c.why)
    print(f"{len(constants)} constants, {len(constants) - left} of them changeable")


# --- run

class Log:
    """A scenario: LOG[@T0:T1][+yaw][+dr][+twice], cut into the scratch folder; +yaw: for a drive along a line; +dr: dead reckoning
    alone; +twice: the second time in the map of the first."""

    def __init__(self, scratch, text):
        text, *marks = text.split("+")
        path, _, span = text.partition("@")
        self.path = pathlib.Path(path)
        self.name = self.path.stem + ("@" + span if span else "")
        self.config = self.path.with_suffix(".yaml")
        truth = self.path.with_suffix(".gt.tum")
        self.reference = truth if truth.exists() else self.path
        self.align = "yaw" if "yaw" in marks else "se3"
        self.dr_only = "dr" in marks
        self.laps = 2 if "twice" in marks else 1
        self.name += ("+dr" if self.dr_only else "") + ("+twice" if self.laps > 1 else "")
        if span:
            cut = scratch / "logs" / (re.sub("[@:+]", "_", self.name) + ".lcm")
            cut.parent.mkdir(exist_ok=True)
            if not cut.exists():
                subprocess.run([program("gw-log"), "cut", self.path, span, cut], check=True,
                               stdout=subprocess.DEVNULL)
            self.path = cut


@functools.lru_cache(maxsize=None)
def ape_of(align, reference, content, scratch):
    """APE RMSE in m of a trajectory with this content, or '' when it cannot be compared."""
    result, estimate = scratch / "eval.json", scratch / "estimate.tum"
    estimate.write_bytes(content)
    result.unlink(missing_ok=True)
    subprocess.run([program("gw-eval"), "--align", align, "--ref", reference, "--est", estimate,
                    "--json", result], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
    if not result.exists():
        return ""
    return f'{json.loads(result.read_text())["ape"]["translation_m"]["rmse"]:.5f}'


def ape(log, estimate, scratch):
    return ape_of(log.align, log.reference, estimate.read_bytes(), scratch)


def digest(folder):
    """Of everything the run says, but for the report, which names the binary."""
    total = hashlib.sha256()
    for path in sorted(folder.iterdir()):
        if path.is_file() and path.name != "report.json":
            total.update(path.name.encode() + path.read_bytes())
    return total.hexdigest()[:16]


def limit_cpu_time():
    resource.setrlimit(resource.RLIMIT_CPU, (MOST_CPU_SECONDS, MOST_CPU_SECONDS + 5))


def run_once(scratch, log, changes, seed):
    """One run with these (constant, direction) changed; a row for each, or one without a constant."""
    out = scratch / "out"
    shutil.rmtree(out, ignore_errors=True)
    environment = dict(os.environ)
    environment["GW_OVERRIDE"] = ",".join(f"{constant}={direction}" for constant, direction in changes)
    command = ["nice", "-n", "8", scratch / "tree/build/dev/bin/gw-slam", log.path, "--config", log.config, "--out", out]
    command += ["--dr-only"] if log.dr_only else ["--seed", str(seed), "--laps", str(log.laps)]
    before = os.times()
    done = subprocess.run(command, capture_output=True, text=True, env=environment, preexec_fn=limit_cpu_time)
    # Dead reckoning alone exits with 1 where its verdict is bad: a result, too.
    code, told = 0 if log.dr_only and done.returncode == 1 and (out / "dr.tum").exists() else done.returncode, done.stderr
    after = os.times()
    cpu_s = after.children_user + after.children_system - before.children_user - before.children_system
    complete = code == 0
    estimates = ("dr.tum", "raw_wheels.tum") if log.dr_only else ("trajectory.tum", "keyframes.tum")
    if log.laps > 1:
        estimates = tuple(f"lap{log.laps}/{name}" for name in estimates)
    result = {"log": log.name, "seed": seed, "exit": code, "cpu_s": f"{cpu_s / max(1, len(changes)):.2f}",
              "live": ape(log, out / estimates[0], scratch) if complete else "",
              "keyframes": ape(log, out / estimates[1], scratch) if complete else "",
              "digest": digest(out) if complete else ""}
    values = {m[1]: (m[2], m[3]) for m in re.finditer(r"^override: (\S+) (\S+) (\S+)$", told, re.M)}
    rows = []
    for constant, direction in changes or [("", "")]:
        old, new = values.get(constant, ("", ""))
        rows.append({"constant": constant, "direction": direction, "before": old, "after": new, **result})
    return rows


def directions(name, value):
    """Half and double; a share, ratio or cosine of one half or more changes what it lacks to one."""
    try:
        near_one = 0.5 <= float(value.rstrip("fF")) < 1
    except ValueError:
        near_one = False
    return ("less", "more") if near_one and NEAR_ONE.search(name) else ("half", "double")


def read(path):
    if not path.exists():
        return []
    with open(path, newline="") as f:
        return list(csv.DictReader(f))


def groups(constants, only, values=None):
    """Lists of (constant, direction): the constants of one file, all in their first or second direction; with
    values: each constant by itself, with each of them."""
    found = {}
    for constant in constants:
        if not constant["left_as_it_is"] and re.search(only, constant["constant"]):
            path, name = constant["constant"].split(":")
            for i, direction in enumerate(values or directions(name, constant["value"])):
                path = constant["constant"] if values else path
                found.setdefault((path, i), []).append((constant["constant"], direction))
    return list(found.values())


class Runs:
    """runs.csv, to which every run adds."""

    def __init__(self, path):
        self.path, self.rows = path, read(path)

    def find(self, constant, direction, log, seed="0"):
        return next((r for r in self.rows if (r["constant"], r["direction"], r["log"], str(r["seed"])) ==
                     (constant, direction, log.name, seed)), None)

    def add(self, rows):
        self.rows += rows
        new = not self.path.exists()
        with open(self.path, "a", newline="") as f:
            writer = csv.DictWriter(f, FIELDS)
            if new:
                writer.writeheader()
            writer.writerows(rows)


def run_group(scratch, runs, log, group):
    """What changes nothing together is taken to change nothing alone; else each half is run by itself, and so on."""
    group = [change for change in group if not runs.find(*change, log)]
    if not group:
        return
    rows = run_once(scratch, log, group, 0)
    if len(group) == 1 or (rows[0]["digest"] and rows[0]["digest"] == runs.find("", "", log)["digest"]):
        return runs.add(rows)
    run_group(scratch, runs, log, group[:len(group) // 2])
    run_group(scratch, runs, log, group[len(group) // 2:])


def run(scratch, logs, only, seeds, values=None):
    runs = Runs(scratch / "runs.csv")
    for log in logs:
        for seed in range(1 if log.dr_only else seeds):
            if not runs.find("", "", log, str(seed)):
                runs.add(run_once(scratch, log, [], seed))
    wanted = groups(read(scratch / "constants.csv"), only, values)
    started = time.monotonic()
    for i, group in enumerate(wanted):
        for log in logs:
            run_group(scratch, runs, log, group)
        print(f"{i + 1} of {len(wanted)} groups, {time.monotonic() - started:.0f} s", file=sys.stderr, flush=True)


# --- table

class Scatter:
    """Undisturbed runs of one log: the digest, and both errors and their deviation over the starts: of one start a tenth of the
    error, of more at least a twentieth, as few starts can lie together by chance."""

    def __init__(self, rows):
        self.digest = next(r["digest"] for r in rows if r["seed"] == "0")
        self.first, self.deviation = {}, {}
        for what in ("live", "keyframes"):
            values = [float(r[what]) for r in rows if r[what]]
            first = float(next(r[what] for r in rows if r["seed"] == "0"))
            least = (0.05 if len(values) > 1 else 0.1) * first
            self.first[what] = first
            self.deviation[what] = max(statistics.stdev(values) if len(values) > 1 else 0, least, 1e-5)


def effect(row, scatter):
    """By how many deviations of the starts a run is worse than the undisturbed one, and moved; None where it is the same."""
    if row["digest"] == scatter.digest:
        return None
    if row["exit"] != "0" or not row["live"] or not row["keyframes"]:
        return float("inf"), float("inf")
    changes = [(float(row[w]) - scatter.first[w]) / scatter.deviation[w] for w in ("live", "keyframes")]
    return max(changes), max(abs(c) for c in changes)


def cell(row, scatter):
    """What one run gave: '=', the errors in m, or why there are none."""
    if row is None:
        return "not run"
    if row["exit"] != "0":
        return "endless" if row["exit"] == str(-signal.SIGXCPU) else "fails"
    if row["digest"] == scatter.digest:
        return "="
    if not row["live"] or not row["keyframes"]:
        return "no pose"
    one = "+dr" in row["log"]  # the wheels' own sum is not changed by any constant
    return " ".join(f"{float(row[w]):.4f}" for w in (("live",) if one else ("live", "keyframes")))


def verdict(effects, sharp=3.0):
    known = [e for e in effects if e is not None]
    worst = max((e[0] for e in known), default=0)
    return "=" if not known else "sharp" if worst > sharp else "some" if worst > 1 else "within"


def by_path(names):
    """['a/b.cc:kX', 'a/b.cc:kY'] -> ['`a/b.cc`: `kX`, `kY`']"""
    found = {}
    for name in names:
        path, constant = name.split(":")
        found.setdefault(path, []).append(f"`{constant}`")
    return [f"`{path}`: {', '.join(constants)}" for path, constants in found.items()]


def table(scratch):
    """Each constant once: in the table of the log on which it moves the errors most."""
    rows, constants = read(scratch / "runs.csv"), read(scratch / "constants.csv")
    logs = list(dict.fromkeys(r["log"] for r in rows if not r["constant"]))
    scatters = {log: Scatter([r for r in rows if r["log"] == log and not r["constant"]]) for log in logs}
    lines, same, never, counts = {}, {}, [], {}
    for constant in constants:
        if constant["left_as_it_is"]:
            continue
        name = constant["constant"]
        mine = {(r["log"], r["direction"]): r for r in rows if r["constant"] == name}
        tried = [log for log in logs if any(key[0] == log for key in mine)]
        if not tried:
            never.append(name)
            continue
        effects = {log: [effect(r, scatters[log]) for key, r in mine.items() if key[0] == log] for log in tried}
        moved = {log: max((e[1] for e in effects[log] if e is not None), default=-1) for log in tried}
        told = verdict([e for log in tried for e in effects[log]])
        counts[told] = counts.get(told, 0) + 1
        if told == "=":
            same.setdefault(", ".join(tried), []).append(name)
            continue
        most = max(tried, key=lambda log: moved[log])
        both = [mine.get((most, d)) for d in directions(name.split(":")[1], constant["value"])]
        others = ", ".join(f"{log} {verdict(effects[log])}" for log in tried if log != most and verdict(effects[log]) not in ("=", "within"))
        lines.setdefault(most, []).append(
            f"| `{name}` | {constant['value']} | {' | '.join(cell(r, scatters[most]) for r in both)} | "
            f"{told}{' (' + others + ')' if others else ''} |")
    for log in logs:
        s = scatters[log]
        print(f"### {log}\n\nlive {s.first['live']:.4f} m (deviation {s.deviation['live']:.4f}), "
              f"keyframes {s.first['keyframes']:.4f} m ({s.deviation['keyframes']:.4f})\n")
        if log in lines:
            print("| constant | value | half | double | verdict |\n| --- | --- | --- | --- | --- |\n" + "\n".join(lines[log]) + "\n")
    print("### The same bytes\n")
    for tried, names in same.items():
        print(f"On {tried}:\n\n" + "\n".join(f"* {line}" for line in by_path(names)) + "\n")
    if never:
        print("### Not run\n\n" + "\n".join(f"* {line}" for line in by_path(never)) + "\n")
    print(", ".join(f"{v}: {n}" for v, n in sorted(counts.items())))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    for name in ("build", "run", "table"):
        command = commands.add_parser(name)
        command.add_argument("--scratch", type=pathlib.Path, required=True)
        if name == "build":
            command.add_argument("--commit", default="HEAD")
            command.add_argument("--only", default="", help="constants of files whose path matches; less is built")
        if name == "run":
            command.add_argument("logs", nargs="+")
            command.add_argument("--only", default="", help="constants whose path:name matches")
            command.add_argument("--values", nargs="+", help="in place of half and double, each constant by itself")
            command.add_argument("--seeds", type=int, default=5, help="undisturbed starts that make the scatter")
    arguments = parser.parse_args()
    scratch = arguments.scratch.resolve()
    scratch.mkdir(parents=True, exist_ok=True)
    if arguments.command == "build":
        build(scratch, arguments.commit, arguments.only)
    elif arguments.command == "run":
        run(scratch, [Log(scratch, text) for text in arguments.logs], arguments.only,
            arguments.seeds, arguments.values)
    else:
        table(scratch)


if __name__ == "__main__":
    main()
