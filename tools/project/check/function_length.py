#!/usr/bin/env python3
"""Checks that no function of the cores is longer than 80 lines, signature included; prints the ten longest.

usage: function_length.py [FOLDER...]      default: the pure cores and common
"""
import re
import sys

import sources

MAX_LINES = 80  # a screen and a half; what is longer has a part that deserves a name
FOLDERS = ["common", "frontend/core", "backend/core", "dr_ekf/core", "dr_ekf/pose", "grid", "drivers/kobuki/core", "drivers/camera/core"]
SCOPE = re.compile(r"\b(namespace|class|struct|union|enum|extern)\b")


def kind_of_block(head, enclosing):
    """What a brace opens, by the text before it since the last statement: scope, function, initializer or other."""
    if any(kind != "scope" for kind, _, _ in enclosing):
        return "other"  # inside a function: part of it
    head = re.sub(r"^\s*(#[^\n]*\n\s*|(public|private|protected)\s*:\s*)+", "", head)
    without_templates = re.sub(r"<[^<>]*>", "", head)
    if re.search(r"\)[^:(){}]*:[^:]", head) and re.search(r"\w\s*$", head):
        return "initializer"  # x{1} between a constructor's name and its body
    if "(" in head and not re.search(r"[^=!<>]=\s*$", head):
        return "function"
    return "scope" if SCOPE.search(without_templates) or not head.strip() else "other"


def functions(text):
    """(first line, number of lines, name) of every function with a body."""
    code = sources.without_comments_and_strings(text)
    code = re.sub(r"^[ \t]*#[^\n]*(?:\\\n[^\n]*)*", lambda m: re.sub(r"[^\n]", " ", m.group()), code, flags=re.M)
    stack, statement, round_brackets = [], 0, 0
    for at, character in enumerate(code):
        if character in "()":
            round_brackets += 1 if character == "(" else -1
        elif round_brackets > 0:
            continue  # a lambda or braces among arguments
        elif character == "{":
            head = code[statement:at]
            kind = kind_of_block(head, stack)
            stack.append((kind, statement + len(head) - len(head.lstrip()), head))
            statement = statement if kind == "initializer" else at + 1
        elif character == "}" and stack:
            kind, begin, head = stack.pop()
            if kind == "function":
                first = code.count("\n", 0, begin) + 1
                name = re.search(r"([~\w:]+|operator\S+)\s*\(", head)
                yield first, code.count("\n", begin, at) + 1, name.group(1) if name else "?"
            statement = statement if kind == "initializer" else at + 1
        elif character == ";" and not any(kind == "function" for kind, _, _ in stack):
            statement = at + 1


def main():
    folders = sys.argv[1:] or FOLDERS
    found = []
    for path in sources.tracked("*.h", "*.cc"):
        if path.startswith(tuple(folder + "/" for folder in folders)) and not sources.is_test(path):
            found += [(lines, f"{path}:{first}", name) for first, lines, name in functions(sources.read(path))]
    found.sort(key=lambda f: (-f[0], f[1]))
    print("longest functions of the cores (lines, where, name):")
    for lines, where, name in found[:10]:
        print(f"  {lines:4d}  {where}  {name}")
    violations = [f"{where}: {name} is longer than {MAX_LINES} lines, {lines} lines"
                  for lines, where, name in found if lines > MAX_LINES]
    return sources.finish("function length", violations, f" ({len(found)} functions)")


if __name__ == "__main__":
    sys.exit(main())
