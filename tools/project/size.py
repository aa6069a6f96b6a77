#!/usr/bin/env python3
"""How large the house is: files, lines and public names of the C++ without tests, for each room and commit, as Markdown.

    tools/project/size.py COMMIT...

Public names: what universal-ctags finds in the headers that is neither private nor protected, each name of a file once.
"""
import pathlib
import re
import subprocess
import sys
import tempfile

ROOMS = ["common", "frontend", "backend", "dr_ekf", "grid", "drivers", "tools"]
TEST = re.compile(r"_test\.cc$|/test/|/testing/|/test_|/bench/")


def public_names(headers):
    if not headers:
        return 0
    tags = subprocess.run(["ctags", "-f", "-", "--language-force=C++", "--c++-kinds=csgfptv", "--fields=+a", *headers],
                          capture_output=True, text=True, check=True).stdout.splitlines()
    return len({tuple(tag.split("\t")[:2]) for tag in tags if not re.search("access:(private|protected)", tag)})


def measure(commit):
    """(files, lines, public names) by room."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        archive = subprocess.run(["git", "archive", commit], capture_output=True, check=True).stdout
        subprocess.run(["tar", "-x", "-C", folder], input=archive, check=True)
        for room in ROOMS:
            files = sorted(path for path in pathlib.Path(folder, room).rglob("*")
                           if path.suffix in (".h", ".cc") and not TEST.search(str(path)))
            lines = sum(path.read_text(encoding="utf-8").count("\n") for path in files)
            found[room] = (len(files), lines, public_names([str(path) for path in files if path.suffix == ".h"]))
    return found


def main():
    commits = sys.argv[1:]
    if not commits or commits[0].startswith("-"):
        print(__doc__, file=sys.stderr)
        return 2
    sizes = [measure(commit) for commit in commits]
    print("| room | " + " | ".join(commits) + " |\n" + "| --- " * (len(commits) + 1) + "|")
    for room in ROOMS:
        print(f"| {room} | " + " | ".join(", ".join(map(str, size[room])) for size in sizes) + " |")
    totals = [tuple(map(sum, zip(*size.values()))) for size in sizes]
    print("| all | " + " | ".join(", ".join(map(str, total)) for total in totals) + " |")
    return 0


if __name__ == "__main__":
    sys.exit(main())
