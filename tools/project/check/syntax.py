#!/usr/bin/env python3
"""A second compiler's opinion, and headers that compile alone. Nothing is linked; warnings are errors.

usage: syntax.py COMPILER BUILD_FOLDER sources|headers|all

sources: every source file but tests, with the flags of BUILD_FOLDER/compile_commands.json. The library headers that most
         of them include are compiled once, which halves the time.
headers: every header that is not the first include of a source file of its own name (those compile alone whenever that
         file does), in a translation unit of its own.
"""
import concurrent.futures
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile

import sources


def commands(build):
    """Compiler arguments without compiler, output and input, by path of the source file from the root."""
    found = {}
    with open(f"{build}/compile_commands.json", encoding="utf-8") as file:
        for entry in json.load(file):
            words = shlex.split(entry["command"])
            first = next(i for i, word in enumerate(words) if word.startswith("-"))
            words = words[first:]
            output = words.index("-o")
            del words[output:output + 2]
            words = [word for word in words if word != "-c" and not word.endswith(".cc")]
            found[os.path.relpath(os.path.join(entry["directory"], entry["file"]))] = words
    return found


def stands_first(header, known):
    """Is the header the first include of the source file of its name?"""
    source = header[:-2] + ".cc"
    if source not in known or not os.path.exists(source):
        return False
    first = re.search(r'^#include [<"]([^">]+)[">]', sources.read(source), re.M)
    return first is not None and first.group(1) == header


def all_includes(known):
    """The flags of any file, and include folders and definitions of all: what a header may include is checked elsewhere."""
    flags = [word for word in next(iter(known.values())) if not word.startswith("-I")]
    options = []
    for words in known.values():
        for i, word in enumerate(words):
            option = [word] if word.startswith(("-I", "-D")) else words[i:i + 2] if word == "-isystem" else []
            if option and option not in options:
                options.append(option)
    return flags + [word for option in options for word in option]


# Heavy and in many sources. Only this check reads them precompiled, so that the other compiler still sees a missing include.
COMMON_HEADERS = "".join(f"#include <{name}>\n" for name in (
    "Eigen/Core", "Eigen/Geometry", "algorithm", "filesystem", "fmt/format.h", "fstream", "functional", "map", "memory",
    "optional", "sstream", "string", "vector"))


class Precompiled:
    """COMMON_HEADERS in the compiler's own form, once for each set of flags that it depends on."""

    def __init__(self, compiler, folder):
        self.compiler, self.folder, self.made = compiler, folder, {}

    def options(self, flags):
        """What a source with these flags is compiled with besides; nothing where the headers do not compile with these."""
        key = tuple(flag for flag in flags if flag.startswith(("-std", "-m", "-f", "-O")))
        if key not in self.made:
            path = os.path.join(self.folder, f"{len(self.made)}.pch")
            command = [self.compiler, *key, "-isystem", "/usr/include/eigen3", "-x", "c++-header", "-", "-o", path]
            done = subprocess.run(command, input=COMMON_HEADERS, capture_output=True, text=True, check=False)
            self.made[key] = [] if done.returncode else ["-include-pch", path]
        return self.made[key]


def compile_one(job):
    compiler, name, flags, text = job
    command = [compiler, *flags, "-fsyntax-only", "-Werror"]
    command += [name] if text is None else ["-x", "c++", "-"]
    done = subprocess.run(command, input=text, capture_output=True, text=True, check=False)
    return f"{name}: does not compile\n{done.stderr.rstrip()}" if done.returncode else None


def main():
    if len(sys.argv) != 4 or sys.argv[3] not in ("sources", "headers", "all"):
        print(__doc__, file=sys.stderr)
        return 2
    compiler, build, what = sys.argv[1:]
    known = commands(build)
    jobs = []
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        if what != "headers":
            precompiled = Precompiled(compiler, folder)
            jobs += [(compiler, path, known[path] + precompiled.options(known[path]), None)
                     for path in sources.tracked("*.cc") if path in known and not sources.is_test(path)]
        num_sources = len(jobs)
        if what != "sources":
            flags = all_includes(known)
            jobs += [(compiler, header, flags, f'#include "{header}"\n')
                     for header in sources.tracked("*.h") if not stands_first(header, known)]
        violations = [violation for violation in pool.map(compile_one, jobs) if violation]
    return sources.finish(f"{compiler} {what}", violations,
                          f" ({num_sources} source files, {len(jobs) - num_sources} headers alone)")


if __name__ == "__main__":
    sys.exit(main())
