#!/usr/bin/env python3
"""The change indicator: does gw-slam still do what it did?

    behaviour.py BIN OUT            compares with behaviour.txt beside this file; a difference is printed as a diff, exit 1
    behaviour.py BIN OUT --accept   writes behaviour.txt (tools/dev accept)

Each scenario beside this file is simulated and run through gw-slam; what is compared are figures that people can read (poses by
status, size of the map, errors) and the SHA-256 of every output. A change of behaviour is no mistake, but it must be meant: the
commit that accepts it says why.

The libraries that choose their code by the CPU's features are told to take that of the oldest CPU we build for, so that the
outputs are the same on every x86-64 machine of one vendor. Approximate instructions differ between vendors; on a machine of
another vendor than that of behaviour.txt, the figures must agree and the hashes are only listed.
"""
import difflib
import hashlib
import json
import os
import shutil
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
GOLDEN = os.path.join(HERE, "behaviour.txt")
RUNS = [("office_turn", "full"), ("office_turn", "none"), ("lights_out", "full"), ("slip_and_return", "full")]
OUTPUTS = ["trajectory.tum", "trajectory_final.tum", "keyframes.tum", "dr.tum", "frames.csv", "covariance.csv"]
ENVIRONMENT = {
    "OPENCV_CPU_DISABLE": "SSE4_1,SSE4_2,AVX,FP16,AVX2,FMA3,AVX512_SKX",
    "OPENBLAS_CORETYPE": "Nehalem",
    "OPENBLAS_NUM_THREADS": "1",
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX,-AVX2,-FMA,-FMA4,-AVX512F",
}


def run(*command):
    done = subprocess.run(command, env={**os.environ, **ENVIRONMENT}, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"{' '.join(command)}: exit {done.returncode}\n{done.stderr}")


def sha256(path):
    with open(path, "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()


def load(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def ape_mm(binaries, log, estimate, out):
    run(f"{binaries}/gw-eval", "--ref", log, "--est", estimate, "--json", out)
    return f"{1000 * load(out)['ape']['translation_m']['rmse']:.1f}"


def figures(binaries, log, folder):
    """What people look at, most telling first."""
    report = load(f"{folder}/report.json")
    yield "images", report["images"]
    for status, count in report["poses"].items():
        yield f"poses {status}", count
    for name, file in (("live", "trajectory.tum"), ("final", "trajectory_final.tum"), ("dead reckoning", "dr.tum")):
        yield f"APE {name} [mm]", ape_mm(binaries, log, f"{folder}/{file}", f"{folder}/eval.json")
    yield "keyframes", report["map"]["keyframes"]
    yield "landmarks", report["map"]["landmarks"]
    yield "local BA", report["map"]["local_ba_applied"]
    yield "loops closed", report["loops"]["closed"]


def cpu_vendor():
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        return next((line.split(":")[1].strip() for line in file if line.startswith("vendor_id")), "unknown")


def measure(binaries, out):
    lines = [f"cpu vendor: {cpu_vendor()}"]
    for scenario in sorted({scenario for scenario, _ in RUNS}):
        run(f"{binaries}/gw-sim", "--scenario", f"{HERE}/{scenario}.yaml", "--log", f"{out}/{scenario}.lcm",
            "--config-out", f"{out}/{scenario}.yaml")
        lines.append(f"{scenario}: sha256 log {sha256(f'{out}/{scenario}.lcm')}")
    for scenario, variant in RUNS:
        log, folder = f"{out}/{scenario}.lcm", f"{out}/{scenario}.{variant}"
        run(f"{binaries}/gw-slam", log, "--config", f"{out}/{scenario}.yaml", "--out", folder, "--variant", variant)
        lines += [f"{scenario} {variant}: {name}: {value}" for name, value in figures(binaries, log, folder)]
        lines += [f"{scenario} {variant}: sha256 {file} {sha256(f'{folder}/{file}')}" for file in OUTPUTS]
    return lines


def compare(expected, found):
    """The diff to show and whether it counts."""
    if expected == found:
        return [], False
    diff = list(difflib.unified_diff(expected, found, "accepted", "now", lineterm="", n=0))
    other_vendor = expected[:1] != found[:1]
    counts = [line for line in diff if line[0] in "+-" and not line.startswith(("+++", "---"))]
    if other_vendor:
        counts = [line for line in counts if "sha256" not in line and "cpu vendor" not in line]
    return diff, bool(counts)


def main():
    arguments = [argument for argument in sys.argv[1:] if argument != "--accept"]
    if len(arguments) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    binaries, out = arguments
    shutil.rmtree(out, ignore_errors=True)
    os.makedirs(out)
    found = measure(binaries, out)
    expected = []
    if os.path.exists(GOLDEN):
        with open(GOLDEN, encoding="utf-8") as file:
            expected = file.read().splitlines()
    diff, counts = compare(expected, found)
    print("\n".join(diff) if diff else "behaviour: as accepted")
    if "--accept" in sys.argv:
        with open(GOLDEN, "w", encoding="utf-8") as file:
            file.write("\n".join(found) + "\n")
        print("accepted; say in the commit what changes and why" if diff else "nothing to accept")
        return 0
    if counts:
        print("gw-slam behaves differently. If that is meant: tools/dev accept, and say why in the commit.")
    return 1 if counts else 0


if __name__ == "__main__":
    sys.exit(main())
