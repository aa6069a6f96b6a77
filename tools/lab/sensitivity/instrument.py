"""Finds the numeric constants of C++ sources and makes them changeable at run time, in a copy.

`constexpr double kFoo = 3;` becomes `const double kFoo = gw::override_value::Of<double>("path:kFoo", 3);`.
A constant whose value is made of other constants only loses its constexpr. What the compiler needs
(array sizes, template arguments) is put back by `revert`, from the compiler's own messages.
"""
import pathlib
import re

TYPES = r"double|float|int|size_t|int32_t|int64_t|uint64_t|DurationUs"
DECLARATION = re.compile(
    r"^(?P<indent> *)(?P<storage>(?:static |inline )*)(?:constexpr|const) (?P<type>" + TYPES + r") "
    r"(?P<list>k[A-Z]\w*\s*=[^;{]*);", re.M)
DECLARATOR = re.compile(r"(?P<name>k[A-Z]\w*)\s*=\s*(?P<value>(?:[^,()]|\([^()]*\))+)(?:,\s*|$)")
CONSTANT = re.compile(r"\bk[A-Z]\w*")

# Not thresholds: indices, marks, layout of tables and vectors, fixed-point scales. By name and reason.
STRUCTURE = {
    "kStream": "seed of random draws",
    "kX": "index", "kY": "index", "kZ": "index", "kHeading": "index", "kWayScale": "index", "kTurnScale": "index",
    "kRadPerDeg": "unit", "kGravity": "physical constant",
    "kTaken": "mark", "kFree": "mark", "kInfinity": "infinity", "kNan": "not a number",
    "kBlock": "width of a vector", "kSlack": "width of a vector", "kWeightSum": "fixed point", "kShift": "fixed point",
    "kOrbPatchRadius": "size of a table", "kMaxLevels": "size of a table", "kMaxCompared": "size of a table",
    "kPatchRadius": "size of a table", "kSearch": "size of a table", "kTables": "groups of 256 bits", "kBits": "groups of 256 bits",
}


class Constant:
    """One declarator: where it is, its source text, whether and why it is not overridable."""

    def __init__(self, path, line, name, number, value, why):
        self.path, self.line, self.name, self.value, self.why = path, line, name, value, why
        self.id = f"{path}:{name}" + (f"#{number}" if number > 1 else "")


def split_declarators(text):
    """'kA = 1, kB = f(2, 3)' -> [('kA', '1'), ('kB', 'f(2, 3)')]; [] when it is something else."""
    found, position = [], 0
    while position < len(text):
        match = DECLARATOR.match(text, position)
        if not match:
            return []
        found.append((match["name"], " ".join(match["value"].split())))
        position = match.end()
    return found


def reason_to_leave(name, value):
    """Why a constant is no threshold, or '' when half and double of it make sense."""
    if STRUCTURE.get(name):
        return STRUCTURE[name]
    used = CONSTANT.findall(value)
    if used:
        return "made of " + ", ".join(sorted(set(used)))
    if not re.search(r"\d", value):
        return "no number"
    return ""


def instrument_text(path, text, reverted=frozenset()):
    """The text with its constants made overridable, and the list of its constants.

    `reverted`: ids that stay as they are because the compiler needs them."""
    constants, count = [], {}

    def replace(match):
        declarators = split_declarators(match["list"])
        if not declarators:
            return match[0]
        parts, plain = [], False
        for name, value in declarators:
            count[name] = count.get(name, 0) + 1
            line = text.count("\n", 0, match.start()) + 1
            constant = Constant(path, line, name, count[name], value, reason_to_leave(name, value))
            if constant.id in reverted:
                constant.why = "needed by the compiler"
                plain = True
            constants.append(constant)
            overridable = not constant.why
            parts.append(f'{name} = gw::override_value::Of<{match["type"]}>("{constant.id}", {value})'
                         if overridable else f"{name} = {value}")
        if plain:  # a declaration is reverted as a whole
            for constant in constants[-len(declarators):]:
                constant.why = constant.why or "needed by the compiler"
            return match[0]
        storage = match["storage"]
        in_function = match["indent"] and "static" not in storage
        in_class = match["indent"] and "static" in storage
        storage = "static " if in_function else "inline static " if in_class else storage
        return f'{match["indent"]}{storage}const {match["type"]} {", ".join(parts)};'

    changed = DECLARATION.sub(replace, text)
    if changed != text:
        first = re.search(r"(?<=\n)#include", changed) or re.search(r"^#include|(?<=#pragma once\n)", changed)
        at = first.start() if first else 0
        changed = changed[:at] + '#include "tools/lab/sensitivity/override.h"\n' + changed[at:]
    return changed, constants


def sources(tree, folders):
    """Paths of the .h and .cc files of these folders that are part of the product."""
    found = []
    for folder in folders:
        for path in sorted((pathlib.Path(tree) / folder).rglob("*")):
            if path.suffix in (".h", ".cc") and not re.search(r"test|benchmark|_study|train_", path.name):
                found.append(str(path.relative_to(tree)))
    return found


def to_revert(compiler_output, constants):
    """Ids of the constants that gcc's errors speak of: by name in the message or the quoted source
    line, those of the file that the message is about before those of headers."""
    by_name = {}
    for constant in constants:
        if constant.why != "needed by the compiler":
            by_name.setdefault(constant.name, []).append(constant)
    ids, path = set(), ""
    for line in compiler_output.splitlines():
        place = re.match(r"(\S+?):\d+:\d+: (?:error|note)", line)
        if place:
            path = place[1]
        quoted = re.match(r"\s*\d+ \| (.*)", line)
        if not place and not quoted:
            continue
        for name in CONSTANT.findall(line):
            same_file = [c for c in by_name.get(name, []) if path.endswith(c.path)]
            ids.update(c.id for c in same_file or by_name.get(name, []))
    return ids
