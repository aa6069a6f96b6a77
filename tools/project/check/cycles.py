#!/usr/bin/env python3
"""Checks that folders depend on each other in one direction only: the graph of folders, joined by #include, has no cycle.

Tests are left out. The rooms of tools/ are checked as wholes too: a room includes only those before it in ROOMS.
Exit 1 and, per cycle, the includes that close it.
"""
import collections
import os
import re
import sys

import sources

ROOMS = ["tools/data", "tools/robot", "tools/view", "tools/lab", "tools/sim"]  # tools/README.md


def includes():
    """(including file, line, included file) for every include of ours outside of tests."""
    for path in sources.tracked("*.h", "*.cc"):
        if sources.is_test(path):
            continue
        for number, line in enumerate(sources.read(path).splitlines(), 1):
            ours = re.match(r'\s*#include "([^"]+)"', line)
            if ours and os.path.exists(ours.group(1)):
                yield path, number, ours.group(1)


def folder_graph(edges):
    graph = collections.defaultdict(lambda: collections.defaultdict(list))
    for path, number, target in edges:
        source_folder, target_folder = os.path.dirname(path), os.path.dirname(target)
        if source_folder != target_folder:
            graph[source_folder][target_folder].append(f"{path}:{number}: includes {target}")
    return graph


def reachable(graph, start):
    seen, todo = set(), [start]
    while todo:
        for target in graph.get(todo.pop(), {}):
            if target not in seen:
                seen.add(target)
                todo.append(target)
    return seen


def cycles(graph):
    """Groups of folders that all reach each other."""
    reach = {folder: reachable(graph, folder) for folder in list(graph)}
    groups = {frozenset(other for other in reach[folder] if folder in reach.get(other, ()))
              for folder in reach if folder in reach[folder]}
    return sorted(sorted(group) for group in groups)


def room_of(path):
    return next((index for index, room in enumerate(ROOMS) if path.startswith(room + "/")), None)


def main():
    edges = list(includes())
    graph = folder_graph(edges)
    violations = []
    for group in cycles(graph):
        closing = [f"  {line}" for a in group for b in group for line in graph[a].get(b, [])]
        violations.append("\n".join(["folders include each other: " + ", ".join(group)] + closing))
    for path, number, target in edges:
        source_room, target_room = room_of(path), room_of(target)
        if target.startswith("tools/") and target_room is None:
            violations.append(f"{path}:{number}: {target} is in no room of tools/")
        elif target_room is not None and source_room is None:
            violations.append(f"{path}:{number}: includes a tool, {target}")
        elif target_room is not None and target_room > source_room:
            violations.append(f"{path}:{number}: {ROOMS[source_room]} is below {ROOMS[target_room]}, includes {target}")
    return sources.finish("cycles", violations, f" ({len(graph)} folders)")


if __name__ == "__main__":
    sys.exit(main())
