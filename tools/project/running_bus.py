#!/usr/bin/env python3
"""The buses of demos and replays that run on this machine, so that spy and gw-view find them.

usage: running_bus.py announce URL PID     prints the file that says so; its owner removes it
       running_bus.py find                 prints the URL of the newest that runs; exit 1 when there is none
"""
import os
import sys
import tempfile

FOLDER = os.path.join(os.environ.get("XDG_RUNTIME_DIR") or tempfile.gettempdir(), f"good-weights-{os.getuid()}")


def announce(url, pid):
    os.makedirs(FOLDER, mode=0o700, exist_ok=True)
    path = f"{FOLDER}/{pid}.bus"
    with open(path, "w") as f:
        f.write(url)
    return path


def runs(pid):
    return os.path.exists(f"/proc/{pid}")


def find():
    """The URL of the newest demo or replay that runs, or None. Files of those that were killed are removed."""
    newest = None
    for name in os.listdir(FOLDER) if os.path.isdir(FOLDER) else []:
        path, pid = f"{FOLDER}/{name}", name.removesuffix(".bus")
        if os.stat(path).st_uid != os.getuid():
            continue
        if not runs(pid):
            os.remove(path)
        elif newest is None or os.path.getmtime(path) > os.path.getmtime(newest):
            newest = path
    if newest is None:
        return None
    with open(newest) as f:
        return f.read()


def main():
    if len(sys.argv) == 4 and sys.argv[1] == "announce":
        print(announce(sys.argv[2], sys.argv[3]))
        return 0
    if sys.argv[1:] == ["find"]:
        url = find()
        if url:
            print(url)
        return 0 if url else 1
    print(__doc__, file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main())
