#!/usr/bin/env python3
"""How well a floor map agrees with a plan of what truly stands there.

usage: grid_eval.py --grid DIR --plan DIR --log LOG.lcm --run DIR --config ROBOT.yaml [--png F] [--json F]

DIR of --grid and --plan hold map.yaml and map.pgm (gw-slam --grid, gw-map export --grid, gw-grid; gw-sim --plan-out).
They are read here with numpy and yaml alone, and checked against the rules of map_server. LOG holds GROUND_TRUTH in the
frame of the plan; RUN is the folder of gw-slam, whose trajectory_final.tum ties W to the plan: turn and shift by least
squares, as for APE.

Counted are occupied cells. One of the map is right when the plan has one within a cell (the eight neighbours), and one
of the plan is found when the map has one within a cell. Of the plan only what the camera saw counts: cells that stop a
ray cast through the plan, from where the camera truly was, within its view and the range of gw-grid, in at least
MIN_LOOKS of the poses LOOK_S apart. IoU = right / (right + wrong + missed). A free cell is inside a wall when the plan
has a wall there and nothing free within a cell.
"""
import argparse
import json
import os
import struct
import sys

import numpy
import yaml

MIN_LOOKS = 3
LOOK_S = 0.2
UNKNOWN, FREE, OCCUPIED = 0, 1, 2


class FloorMap:
    """map_server's map: cells[y, x], the lowest y first."""

    def __init__(self, directory):
        with open(os.path.join(directory, "map.yaml"), encoding="utf-8") as file:
            about = yaml.safe_load(file)
        with open(os.path.join(directory, about["image"]), "rb") as file:
            data = file.read()
        magic, width, height, white = self._header(data)
        if magic != b"P5" or white != 255:
            raise SystemExit(f"{directory}: not an 8-bit PGM")
        grey = numpy.frombuffer(data, numpy.uint8, width * height, len(data) - width * height)
        dark = (255.0 - grey.reshape(height, width)[::-1]) / 255.0
        if about["negate"]:
            dark = 1 - dark
        self.cells = numpy.full((height, width), UNKNOWN, numpy.uint8)
        self.cells[dark > about["occupied_thresh"]] = OCCUPIED
        self.cells[dark < about["free_thresh"]] = FREE
        self.cell = float(about["resolution"])
        self.origin = numpy.array(about["origin"][:2], float)

    @staticmethod
    def _header(data):
        words, at = [], 0
        while len(words) < 4:
            while data[at:at + 1].isspace():
                at += 1
            if data[at:at + 1] == b"#":
                at = data.index(b"\n", at)
                continue
            end = at
            while not data[end:end + 1].isspace():
                end += 1
            words.append(data[at:end])
            at = end
        return words[0], int(words[1]), int(words[2]), int(words[3])

    def index(self, points):
        return numpy.floor((points - self.origin) / self.cell).astype(int)

    def at(self, points):
        """States of the cells at points (n, 2); UNKNOWN outside."""
        index = self.index(points)
        height, width = self.cells.shape
        inside = (index >= 0).all(1) & (index[:, 0] < width) & (index[:, 1] < height)
        out = numpy.full(len(points), UNKNOWN, numpy.uint8)
        out[inside] = self.cells[index[inside, 1], index[inside, 0]]
        return out

    def centres(self, mask):
        y, x = numpy.nonzero(mask)
        return self.origin + self.cell * (numpy.stack([x, y], 1) + 0.5)


def near(points, others, reach):
    """For each point: is one of the others in a cell within `reach` along both axes?"""
    if not len(points) or not len(others):
        return numpy.zeros(len(points), bool)
    bins = {}
    for other in others:
        bins.setdefault(tuple(numpy.floor(other / reach).astype(int)), []).append(other)
    found = numpy.zeros(len(points), bool)
    for i, point in enumerate(points):
        bx, by = numpy.floor(point / reach).astype(int)
        close = [o for dx in (-1, 0, 1) for dy in (-1, 0, 1) for o in bins.get((bx + dx, by + dy), ())]
        found[i] = bool(close) and (numpy.abs(numpy.array(close) - point).max(1) <= reach).any()
    return found


def ground_truth(log):
    """Rows t, x, y, yaw of the log's GROUND_TRUTH."""
    rows = []
    with open(log, "rb") as file:
        while True:
            header = file.read(28)
            if len(header) < 28:
                break
            _, _, _, name_length, length = struct.unpack(">IqqII", header)
            if file.read(name_length) != b"GROUND_TRUTH":
                file.seek(length, 1)
                continue
            message = file.read(length)
            utime, _, x, y, _, w, qx, qy, z = struct.unpack(">qq7d", message[8:80])
            rows.append((utime * 1e-6, x, y, numpy.arctan2(2 * (w * z + qx * qy), 1 - 2 * (qy * qy + z * z))))
    return numpy.array(rows)


def interpolated(truth, times):
    out = [numpy.interp(times, truth[:, 0], truth[:, i]) for i in (1, 2)]
    return numpy.stack(out + [numpy.interp(times, truth[:, 0], numpy.unwrap(truth[:, 3]))], 1)


def align(estimate, truth):
    """R, p with truth = R estimate + p, least squares."""
    a, b = estimate - estimate.mean(0), truth - truth.mean(0)
    angle = numpy.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum())
    turn = numpy.array([[numpy.cos(angle), -numpy.sin(angle)], [numpy.sin(angle), numpy.cos(angle)]])
    return turn, truth.mean(0) - turn @ estimate.mean(0)


def camera_of(config):
    with open(config, encoding="utf-8") as file:
        robot = yaml.safe_load(file)
    camera = robot["calibration"]["camera"]
    view = numpy.arctan(camera["width"] / 2 / camera["left"]["fx"])
    w, x, y, z = camera["T_BC"]["q_wxyz"]
    forward = numpy.array([2 * (x * z + w * y), 2 * (y * z - w * x)])  # the optical axis in B
    grid = robot.get("grid", {})
    # Where the depth is known to two cells: farther away nothing is put into the map (grid/core/floor_scan.h).
    if camera["kind"] == "stereo":
        baseline, sigma = camera["T_C0C1"]["p"][0], grid.get("disparity_sigma_px", 0.2)
    else:  # 1.5: kPixelNoise of grid/core/depth_source.cc
        baseline, sigma = camera.get("depth_baseline_m", 0.08), 1.5 * camera.get("disparity_sigma_px", 0.1)
    sharp = numpy.sqrt(2 * grid.get("cell_m", 0.05) * camera["left"]["fx"] * baseline / sigma)
    reach = min(grid.get("max_range_m", 4.0), sharp)
    return numpy.array(camera["T_BC"]["p"][:2]), numpy.arctan2(forward[1], forward[0]), view, reach


def seen_cells(plan, truth, config):
    """Occupied cells of the plan that the camera saw; mask of the plan's shape."""
    place, heading, view, reach = camera_of(config)
    looks = numpy.zeros(plan.cells.shape, int)
    bearings = numpy.linspace(-view, view, 161)
    steps = numpy.arange(0.3, reach, plan.cell / 2)
    for _, x, y, yaw in truth:
        turn = numpy.array([[numpy.cos(yaw), -numpy.sin(yaw)], [numpy.sin(yaw), numpy.cos(yaw)]])
        foot = turn @ place + (x, y)
        angles = yaw + heading + bearings
        rays = foot + steps[None, :, None] * numpy.stack([numpy.cos(angles), numpy.sin(angles)], 1)[:, None, :]
        stops = plan.at(rays.reshape(-1, 2)).reshape(rays.shape[:2]) == OCCUPIED
        hit = stops.any(1)
        index = plan.index(rays[hit, stops[hit].argmax(1)])
        once = numpy.unique(index, axis=0)
        looks[once[:, 1], once[:, 0]] += 1
    return looks >= MIN_LOOKS


def write_png(path, grid, plan, seen, turn, shift):
    import cv2  # pylint: disable=import-outside-toplevel
    scale = 2
    picture = numpy.full(plan.cells.shape + (3,), 255, numpy.uint8)
    known = grid.cells != UNKNOWN
    for state, colour in ((FREE, (225, 240, 210)), (OCCUPIED, (0, 0, 220))):
        index = plan.index(grid.centres(known & (grid.cells == state)) @ turn.T + shift)
        inside = (index >= 0).all(1) & (index[:, 0] < plan.cells.shape[1]) & (index[:, 1] < plan.cells.shape[0])
        picture[index[inside, 1], index[inside, 0]] = colour
    dark = (picture == (0, 0, 220)).all(2)
    wall = plan.cells == OCCUPIED
    picture[wall & ~dark & seen] = (220, 120, 0)
    picture[wall & ~dark & ~seen] = (200, 200, 200)
    picture[wall & dark] = (0, 0, 0)
    cv2.imwrite(path, cv2.resize(picture[::-1], None, fx=scale, fy=scale, interpolation=cv2.INTER_NEAREST))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("grid", "plan", "log", "run", "config"):
        parser.add_argument("--" + name, required=True)
    parser.add_argument("--png", help="black: found, red: not in the plan, blue: missed, grey: never seen")
    parser.add_argument("--json")
    arguments = parser.parse_args()
    grid, plan = FloorMap(arguments.grid), FloorMap(arguments.plan)
    truth = ground_truth(arguments.log)
    if not len(truth):
        raise SystemExit(f"{arguments.log}: holds no GROUND_TRUTH")
    run = numpy.loadtxt(os.path.join(arguments.run, "trajectory_final.tum"))
    turn, shift = align(run[:, 1:3], interpolated(truth, run[:, 0])[:, :2])
    times = numpy.arange(run[0, 0], run[-1, 0], LOOK_S)
    seen = seen_cells(plan, numpy.column_stack([times, interpolated(truth, times)]), arguments.config)

    reach = 1.5 * max(grid.cell, plan.cell)  # neighbours on lattices that do not coincide
    mapped = grid.centres(grid.cells == OCCUPIED) @ turn.T + shift
    walls = plan.centres(plan.cells == OCCUPIED)
    right = near(mapped, walls, reach)
    found = near(plan.centres(seen), mapped, reach)
    free = grid.centres(grid.cells == FREE) @ turn.T + shift
    in_wall = free[(plan.at(free) != FREE)]
    in_wall = in_wall[~near(in_wall, plan.centres(plan.cells == FREE), reach)]
    missed, wrong = int((~found).sum()), int((~right).sum())
    result = {"iou": float(right.sum() / max(1, right.sum() + wrong + missed)), "occupied_right": int(right.sum()),
              "occupied_wrong": wrong, "seen": int(seen.sum()), "missed": missed,
              "free": int(len(free)), "free_in_wall": int(len(in_wall))}
    print("  ".join(f"{k} {v:.3f}" if isinstance(v, float) else f"{k} {v}" for k, v in result.items()))
    if arguments.json:
        with open(arguments.json, "w", encoding="utf-8") as file:
            json.dump(result, file, indent=1)
    if arguments.png:
        write_png(arguments.png, grid, plan, seen, turn, shift)
    return 0


if __name__ == "__main__":
    sys.exit(main())
