#!/usr/bin/env python3
"""Checks that what documents and comments point to exists.

- Relative links of all .md files, with their #headings.
- Files of this repository named in `backticks` of .md files, by their path from the root or from the document.
- Comments of C++, LCM types, CMake and scripts: every .md, .h, .cc, .py or _t.lcm file they name is in the repository,
  by its path or by the end of it. Everything else that a comment relies on is cited by authors and title.
"""
import os
import re
import sys

import sources

LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
TOP = r"(?:backend|common|config|deploy|docs|dr_ekf|drivers|frontend|grid|lcmtypes|test|tools)"
QUOTED_PATH = re.compile(rf"`({TOP}/[\w./-]+\.(?:cc|h|md|py|yaml|lcm|cmake|txt))`")
CITED_FILE = re.compile(r"(?<![\w/<$*.-])((?:[\w.-]+/)*[A-Za-z][\w.-]*(?:\.md|\.h|\.cc|\.py|_t\.lcm))(?![\w*])")
# Headers of other projects and of the system, and names that stand for one to be given.
OTHERS = re.compile(r"^(lcm|opencv2|ceres|linux|sys|yaml-cpp|Eigen|rosbag)/|^videodev2\.h$|^[A-Z/]+\.md$")


def heading_anchor(heading):
    """GitHub's anchor of a heading: small letters, blanks as dashes, without punctuation."""
    heading = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).strip().lower()
    return re.sub(r"[^\w\- ]", "", heading).replace(" ", "-")


def anchors(path):
    return {heading_anchor(heading) for heading in re.findall(r"^#+ +(.+)$", sources.read(path), re.M)}


def broken_links(path):
    for number, line in enumerate(sources.read(path).splitlines(), 1):
        for target in LINK.findall(line):
            if re.match(r"\w+:", target):
                continue  # another site
            file, _, anchor = target.partition("#")
            full = os.path.normpath(os.path.join(os.path.dirname(path), file)) if file else path
            if not os.path.exists(full):
                yield f"{path}:{number}: link to {target}, which does not exist"
            elif anchor and full.endswith(".md") and anchor not in anchors(full):
                yield f"{path}:{number}: {file or path} has no heading #{anchor}"
        for target in QUOTED_PATH.findall(line):
            if not os.path.exists(target) and not os.path.exists(os.path.join(os.path.dirname(path), target)):
                yield f"{path}:{number}: names {target}, which does not exist"


def comment_lines(path):
    text = sources.read(path)
    if path.endswith((".h", ".cc", ".lcm")):
        yield from sources.comments(text)
        return
    for number, line in enumerate(text.splitlines(), 1):
        comment = re.search(r"(?:^|\s)#(?!!)(.*)", line)
        if comment:
            yield number, comment.group(1)


def bad_cites(path, known_ends):
    for number, line in comment_lines(path):
        for cited in CITED_FILE.findall(line):
            if not OTHERS.match(cited) and cited not in known_ends:
                yield f"{path}:{number}: cites {cited}, which is not in the repository"


def ends(paths):
    """a/b/c.h, b/c.h and c.h for each path."""
    found = set()
    for path in paths:
        parts = path.split("/")
        found.update("/".join(parts[i:]) for i in range(len(parts)))
    return found


def main():
    files = sources.tracked()
    known_ends = ends(files)
    violations = []
    for path in files:
        if path.endswith(".md"):
            violations += broken_links(path)
        elif path.endswith((".h", ".cc", ".lcm", ".py", ".cmake", "CMakeLists.txt")):
            violations += bad_cites(path, known_ends)
    return sources.finish("links and cites", violations)


if __name__ == "__main__":
    sys.exit(main())
