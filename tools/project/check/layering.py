#!/usr/bin/env python3
"""Checks every #include of the project against the layers of docs/adr/0001-layers.md.

A folder may include the folders listed for it (and itself). Third-party headers are checked by a
pattern of what the folder must not see. Exit 1 and one line per violation.
"""
import re
import subprocess
import sys

# folder prefix (longest match wins) -> (our folders it may include, third-party headers it must not)
LAYERS = {
    "common/core": ([], r"lcm/|opencv2/|ceres/|yaml-cpp/|thread|mutex|chrono"),
    "common/camera": (["common/core", "common/core/fields.h"], r"lcm/|opencv2/|ceres/|yaml-cpp/|thread|chrono"),
    "common/contract": (["common/core", "common/camera"], r"lcm/|opencv2/|ceres/|yaml-cpp/|thread|chrono"),
    "common/vision": (["common/core", "common/camera"],
                      r"lcm/|opencv2/|ceres/|yaml-cpp/|thread|mutex|chrono|iostream|fstream"),
    "common/config": (["common/core", "common/camera"], r"lcm/|opencv2/|ceres/|thread|chrono"),
    "common/process": (["common", "lcmtypes"], r"opencv2/|ceres/|yaml-cpp/"),
    "lcmtypes": (["common/core", "common/contract", "common/camera"], r"opencv2/|ceres/|yaml-cpp/|thread|chrono"),
    "frontend/core": (["common/core", "common/camera", "common/contract", "common/config", "common/vision"],
                      r"lcm/|ceres/|yaml-cpp/|thread|mutex|chrono|iostream|fstream"),
    "backend/core": (["common/core", "common/camera", "common/contract", "common/config", "common/vision"],
                     r"lcm/|opencv2/|yaml-cpp/|thread|mutex|chrono|iostream|fstream"),
    "dr_ekf/core": (["common/core", "common/camera", "common/contract", "common/config"],
                    r"lcm/|opencv2/|ceres/|yaml-cpp/|thread|mutex|chrono|iostream|fstream"),
    "drivers/common": (["common/core"], r"lcm/|opencv2/|ceres/|yaml-cpp/|thread|mutex|chrono|iostream|fstream"),
    "drivers/kobuki/protocol": (["common/core", "drivers/common"], r"lcm/|opencv2/|ceres/|yaml-cpp/|thread|mutex|chrono|iostream|fstream"),
    "drivers/kobuki/core": (["common/core", "common/camera", "common/contract", "common/config",
                             "drivers/common", "drivers/kobuki/protocol"],
                            r"lcm/|opencv2/|ceres/|yaml-cpp/|thread|mutex|chrono|iostream|fstream"),
    "drivers/camera/protocol": (["common/core", "drivers/common"], r"lcm/|opencv2/|ceres/|yaml-cpp/|thread|mutex|chrono|iostream|fstream"),
    "drivers/camera/core": (["common/core", "common/camera", "common/contract", "common/config",
                             "drivers/common", "drivers/camera/protocol"],
                            r"lcm/|opencv2/|ceres/|yaml-cpp/|thread|mutex|chrono|iostream|fstream"),
    "frontend": (["common", "lcmtypes"], r"ceres/"),
    "backend": (["common", "lcmtypes"], r"opencv2/"),
    "dr_ekf": (["common", "lcmtypes"], r"opencv2/|ceres/"),
    "drivers": (["common", "lcmtypes"], r"ceres/"),
    "tools": (None, r"$^"),
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
