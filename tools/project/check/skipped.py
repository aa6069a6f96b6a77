#!/usr/bin/env python3
"""Says loudly which tests did not run, and why.

usage: skipped.py JUNIT_XML      the file of `ctest --output-junit`; exit 0: a skipped test is no failure
"""
import re
import sys
import xml.etree.ElementTree

# GoogleTest: the place, "Skipped", the reason, and the case.
CASE = re.compile(r"^\S+:\d+: Skipped\n(.*?)\n+\[  SKIPPED \] (\S+)", re.M | re.S)


def skipped(path):
    """(test, reason) of every test and every GoogleTest case that was skipped."""
    for test in xml.etree.ElementTree.parse(path).getroot().iter("testcase"):
        output = test.findtext("system-out") or ""
        cases = [(f"{test.get('name')}: {case}", " ".join(reason.split())) for reason, case in CASE.findall(output)]
        yield from cases
        if test.find("skipped") is not None and not cases:
            lines = [line for line in output.strip().splitlines() if line.strip()]
            yield test.get("name"), lines[-1].strip() if lines else "says nothing"


def main():
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    found = sorted(skipped(sys.argv[1]))
    if found:
        print(f"\nSKIPPED: {len(found)} tests did not run; what they show is not shown by this run:")
        for name, reason in found:
            print(f"  {name}\n      {reason}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
