#!/usr/bin/env python3
"""A suite gives the same table, byte for byte, whichever way its jobs are run, and a job that is killed is run again alone.

usage: workflow_test.py parallel|snakemake|slurm --bench GW_BENCH --suite SUITE --work FOLDER [--runs N]

The reference is gw-bench alone, one run after the other. slurm starts a cluster of one node for itself. Exit 77: the
programs are not installed (Debian: parallel, snakemake, slurm-wlm).
"""
import argparse
import contextlib
import getpass
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import time

SKIPPED = 77
TABLES = ("table.md", "table.csv", "ranking.svg", "inputs.svg")
NEEDED = {
    "parallel": ["parallel"],
    "snakemake": ["snakemake"],
    "slurm": ["snakemake", "slurmctld", "slurmd", "srun", "sinfo"],
}
os.environ["PATH"] += ":/usr/sbin:/sbin"


def run(command, **options):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, **options)
    if done.returncode != 0:
        sys.exit(f"exit {done.returncode} of {command}:\n{done.stdout}")
    return done.stdout


def times_of_runs(out):
    """When each run was finished, by its folder."""
    return {str(key.parent.relative_to(out)): key.stat().st_mtime_ns for key in out.glob("cells/*/*/*/key")}


def kill_a_run(out, workflow):
    """Kills the first gw-slam of this folder that is seen; the folder of its run."""
    prefix = f"{out}/gw-slam".encode()
    while workflow.poll() is None:
        for entry in pathlib.Path("/proc").glob("[0-9]*/cmdline"):
            with contextlib.suppress(OSError):
                words = entry.read_bytes().split(b"\0")
                if words[0] == prefix:
                    os.kill(int(entry.parent.name), signal.SIGKILL)
                    folder = words[words.index(b"--out") + 1].decode()
                    return str(pathlib.Path(folder).relative_to(out))
        time.sleep(0.02)
    sys.exit("no gw-slam was seen to run:\n" + workflow.communicate()[0])


def start(command, environment=None):
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment, start_new_session=True
    )


def kill_one_and_run_again(command, out, cells):
    """Kills one run; the command, given once more, runs that one only."""
    workflow = start(command)
    killed = kill_a_run(out, workflow)
    workflow.communicate()
    check_only_one_is_missing(out, cells, killed, workflow.returncode)
    before = times_of_runs(out)
    run(command)
    check_only_one_was_run(before, times_of_runs(out), killed)


def with_parallel(out, cells):
    parallel = ["parallel", "--jobs", "2", "--arg-file"]
    run([*parallel, out / "inputs.jobs"])
    kill_one_and_run_again([*parallel, out / "cells.jobs"], out, cells)
    run(["sh", out / "table.jobs"])


def with_snakemake(out, cells):
    command = ["snakemake", "--directory", out, "--snakefile", out / "Snakefile", "--cores", "2", "--keep-going"]
    kill_one_and_run_again(command, out, cells)


def with_slurm(out, _):
    """Kills one run; the profile has it run again, without a second start."""
    with slurm_node(out / "node") as environment:
        command = ["snakemake", "--directory", out, "--snakefile", out / "Snakefile", "--profile", out / "slurm"]
        workflow = start(command, environment)
        killed = kill_a_run(out, workflow)
        said, _ = workflow.communicate()
        if workflow.returncode != 0:
            sys.exit(f"snakemake: exit {workflow.returncode}:\n{said}")
        if "Trying to restart" not in said:
            sys.exit(f"{killed} was killed and not run again:\n{said}")


def check_only_one_is_missing(out, cells, killed, code):
    missing = cells - set(times_of_runs(out))
    if code == 0 or missing != {killed}:
        sys.exit(f"{killed} was killed, exit {code}; without a result: {missing}")


def check_only_one_was_run(before, after, killed):
    again = {cell for cell in after if before.get(cell) != after[cell]}
    if again != {killed}:
        sys.exit(f"{killed} was killed, but these were run again: {again}")


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def slurm_configuration(folder):
    host, user = socket.gethostname().split(".")[0], getpass.getuser()
    return f"""
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={free_port()}
SlurmdPort={free_port()}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/none
CredType=cred/none
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmdParameters=config_overrides
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 RealMemory=8000
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


@contextlib.contextmanager
def slurm_node(folder):
    """A cluster of this machine alone; the environment in which programs find it."""
    for name in ("state", "spool"):
        (folder / name).mkdir(parents=True)
    (folder / "slurm.conf").write_text(slurm_configuration(folder))
    environment = dict(os.environ, SLURM_CONF=str(folder / "slurm.conf"))
    daemons = []
    try:
        for name in ("slurmctld", "slurmd"):
            log = open(folder / f"{name}.log", "w")
            daemons.append(subprocess.Popen([name, "-D"], stdout=log, stderr=log, env=environment))
        wait_for_node(folder, environment, daemons)
        yield environment
    finally:
        for daemon in reversed(daemons):
            daemon.terminate()
        for daemon in daemons:
            daemon.wait()


def wait_for_node(folder, environment, daemons):
    for _ in range(600):
        said = subprocess.run(
            ["sinfo", "--noheader", "--format=%T"], env=environment, stdout=subprocess.PIPE, text=True, check=False
        ).stdout
        if said.strip() == "idle":
            return
        if any(daemon.poll() is not None for daemon in daemons):
            break
        time.sleep(0.1)
    logs = "".join(path.read_text() for path in sorted(folder.glob("*.log")))
    sys.exit(f"the Slurm node does not come up:\n{logs}")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("way", choices=sorted(NEEDED))
    parser.add_argument("--bench", required=True)
    parser.add_argument("--suite", required=True)
    parser.add_argument("--work", type=pathlib.Path, required=True)
    parser.add_argument("--runs", default="1")
    args = parser.parse_args()
    missing = [name for name in NEEDED[args.way] if shutil.which(name) is None]
    if missing:
        print(f"[  SKIPPED ] not installed: {', '.join(missing)} (Debian: parallel, snakemake, slurm-wlm)")
        return SKIPPED
    common = [args.bench, args.suite, "--runs", args.runs, "--cache", args.work / "cache"]
    plain, out = args.work / f"plain-{args.runs}", (args.work / args.way).absolute()
    run(common + ["--out", plain])
    shutil.rmtree(out, ignore_errors=True)
    run(common + ["--workflow", out])
    ways = {"parallel": with_parallel, "snakemake": with_snakemake, "slurm": with_slurm}
    began = time.monotonic()
    ways[args.way](out, set(times_of_runs(plain)))
    for name in TABLES:
        if (plain / name).read_bytes() != (out / name).read_bytes():
            sys.exit(f"{name} of {out} differs from that of {plain}")
    print(f"{args.way}: {len(times_of_runs(out))} runs in {time.monotonic() - began:.0f} s, the same tables")
    return 0


if __name__ == "__main__":
    sys.exit(main())
