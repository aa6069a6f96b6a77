"""What the checks share: the tracked files of the repository, and C++ without its comments and strings."""
import os
import re
import subprocess


def tracked(*patterns):
    """Paths of the files that git tracks (new ones that are not ignored included) below the working folder."""
    out = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard", "--", *patterns],
                         capture_output=True, text=True, check=True).stdout
    return sorted(path for path in set(out.splitlines()) if os.path.isfile(path))


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def is_test(path):
    """Tests, their helpers and benchmarks may include what the code beside them may not."""
    name = os.path.basename(path)
    return (name.startswith("test_") or name.endswith(("_test.cc", "_benchmark.cc"))
            or path.startswith("test/") or "/test/" in path or "/bench/" in path)


TOKEN = re.compile(r'R"(?P<tag>[^(\s]*)\(.*?\)(?P=tag)"|//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'', re.S)


def _blank(text):
    return re.sub(r"[^\n]", " ", text)


def without_comments_and_strings(text):
    """The same text, each character of a comment or literal a blank; lines keep their numbers."""
    # A ' between digits separates thousands.
    text = re.sub(r"(?<=[0-9a-fA-F])'(?=[0-9a-fA-F])", "_", text)
    return TOKEN.sub(lambda token: _blank(token.group()), text)


def comments(text):
    """(line number, text) of each // comment of C++; the .lcm files use the same."""
    for token in TOKEN.finditer(text):
        if token.group().startswith(("//", "/*")):
            first = text.count("\n", 0, token.start()) + 1
            for offset, line in enumerate(token.group().split("\n")):
                yield first + offset, line


def known(name):
    """What known.txt excuses: lines `NAME | VIOLATION` without line numbers."""
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), "known.txt")
    entries = [line.split(" | ", 1) for line in read(path).splitlines() if line and not line.startswith("#")]
    return [violation for check, violation in entries if check == name]


def finish(name, violations, summary="", excused=None):
    """Prints the outcome; returns the exit code. Violations are equal to an excuse without :LINE and ', N lines'."""
    excused = known(name) if excused is None else excused
    plain = [re.sub(r":\d+: ", ": ", re.sub(r", \d+ lines", "", line.split("\n")[0])) for line in violations]
    wrong = [line for line, key in zip(violations, plain) if key not in excused]
    wrong += [f"known.txt excuses what is mended; delete its line: {name} | {line}" for line in excused if line not in plain]
    for line in wrong:
        print(line)
    left = f", {len(excused)} excused in known.txt" if excused else ""
    print(f"{name}: {len(wrong)} violations" if wrong else f"{name}: ok{summary}{left}")
    return 1 if wrong else 0
