#!/usr/bin/env python3
"""Checks every #include of the project against the layers of docs/adr/0001-layers.md.

A folder may include the folders listed for it (and itself). Third-party headers are checked by a
pattern of what the folder must not see. Exit 1 and one line per violation.
"""
import re
import subprocess
import sys

VALUES = r"lcm/|opencv2/|ceres/|yaml-cpp/|thread|mutex|chrono"  # what plain values and algebra must not see
PURE = VALUES + r"|iostream|fstream"
CORES = ["common/core", "common/camera", "common/contract", "common/config", "common/good_weights"]
SHELLS = ["common"]

# folder prefix (longest match wins) -> (our folders it may include, third-party headers it must not)
LAYERS = {
    "common/core": ([], VALUES),
    "common/camera": (["common/core"], VALUES),
    "common/cli": (["common/core"], VALUES),
    "common/contract": (["common/core"], VALUES),
    "common/config": (["common/core", "common/camera"], r"lcm/|opencv2/|ceres/|thread|chrono"),
    "common/vision": (["common/core", "common/camera", "common/contract"], PURE),
    "common/good_weights": (["common/core", "common/contract", "common/config"], PURE),
    "common/wire": (["common/core", "common/contract"], r"opencv2/|ceres/|yaml-cpp/|thread|chrono"),
    "common/process": (["common"], r"opencv2/|ceres/|yaml-cpp/"),
    "frontend/core": (CORES + ["common/vision"], PURE.replace("opencv2/|", "")),
    "backend/core": (CORES + ["common/vision"], PURE.replace("ceres/|", "")),
    "dr_ekf/core": (CORES, PURE),
    "dr_ekf/pose": (CORES, PURE),
    "grid/core": (CORES, PURE.replace("opencv2/|", "")),
    "drivers/common": (["common/core"], PURE),
    "drivers/kobuki/protocol": (["common/core", "drivers/common"], PURE),
    "drivers/kobuki/core": (CORES + ["drivers/common", "drivers/kobuki/protocol"], PURE),
    "drivers/camera/protocol": (["common/core", "drivers/common"], PURE),
    "drivers/camera/core": (CORES + ["drivers/common", "drivers/camera/protocol"], PURE),
    "frontend": (SHELLS, r"ceres/"),
    "backend": (SHELLS, r"opencv2/"),
    "dr_ekf": (SHELLS, r"opencv2/|ceres/"),
    "grid": (SHELLS, r"ceres/"),
    "drivers": (SHELLS, r"ceres/"),
    "tools": (None, r"$^"),  # their rooms: cycles.py
    "test": (None, r"$^"),
}


def layer_of(path):
    best = ""
    for prefix in LAYERS:
        if path.startswith(prefix + "/") and len(prefix) > len(best):
            best = prefix
    return best


def main():
    files = subprocess.run(["git", "ls-files", "*.h", "*.cc"], capture_output=True, text=True, check=True)
    violations = []
    for path in files.stdout.split():
        layer = layer_of(path)
        if not layer:
            violations.append(f"{path}: belongs to no layer; add its folder to tools/project/check/layering.py")
            continue
        allowed, forbidden = LAYERS[layer]
        # Tests and benchmarks of a core may use files and test libraries.
        is_test = path.endswith(("_test.cc", "_benchmark.cc")) or "/test/" in path or "/bench/" in path
        with open(path, encoding="utf-8") as source:
            for number, line in enumerate(source, 1):
                ours = re.match(r'\s*#include "([^"]+)"', line)
                theirs = re.match(r"\s*#include <([^>]+)>", line)
                if ours and allowed is not None:
                    target = ours.group(1)
                    own_folder = target.startswith(path.split("/")[0] + "/") and path.split("/")[0] != "common"
                    fine = own_folder or target.startswith(layer + "/") or any(
                        target == a or target.startswith(a + "/") for a in allowed)
                    if layer.endswith("/core") and own_folder and not is_test:
                        fine = target.startswith(layer + "/") or any(
                            target == a or target.startswith(a + "/") for a in allowed)
                    if not fine and not is_test:
                        violations.append(f"{path}:{number}: {layer} must not include {target}")
                if theirs and not is_test and re.match(forbidden, theirs.group(1)):
                    violations.append(f"{path}:{number}: {layer} must not include <{theirs.group(1)}>")
    print("\n".join(violations) if violations else "layering: ok")
    return 1 if violations else 0


if __name__ == "__main__":
    sys.exit(main())
