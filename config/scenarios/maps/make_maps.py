#!/usr/bin/env python3
"""Draws the floor maps of the scenarios (map_server format) from lists of walls.

Run it in this folder after changing a plan; the maps are committed so that nobody needs to.
"""
import os

RESOLUTION = 0.1  # m


class Plan:
    """Free floor of width x height metres with a margin; walls are 0.2 m thick, in metres."""

    def __init__(self, width, height):
        self.columns = round(width / RESOLUTION)
        self.rows = round(height / RESOLUTION)
        self.cells = [[254] * self.columns for _ in range(self.rows)]
        for x0, y0, x1, y1 in ((0, 0, width, 0), (0, height - 0.2, width, height - 0.2),
                               (0, 0, 0, height), (width - 0.2, 0, width - 0.2, height)):
            self.wall(x0, y0, x1, y1)

    def block(self, x0, y0, x1, y1, value=0):
        for row in range(round(y0 / RESOLUTION), min(self.rows, round(y1 / RESOLUTION))):
            for column in range(round(x0 / RESOLUTION), min(self.columns, round(x1 / RESOLUTION))):
                self.cells[row][column] = value

    def wall(self, x0, y0, x1, y1):
        """Along x or y; (x0, y0) is the lower left corner of its first end."""
        self.block(x0, y0, x1 + 0.2, y1 + 0.2)

    def door(self, x0, y0, x1, y1):
        self.block(x0, y0, x1, y1, 254)

    def write(self, folder):
        os.makedirs(folder, exist_ok=True)
        with open(os.path.join(folder, "map.pgm"), "wb") as out:
            out.write(b"P5\n%d %d\n255\n" % (self.columns, self.rows))
            for row in reversed(self.cells):  # the first row of the image is the highest y
                out.write(bytes(row))
        with open(os.path.join(folder, "map.yaml"), "w", encoding="utf-8") as out:
            out.write(f"image: map.pgm\nresolution: {RESOLUTION}\norigin: [0, 0, 0]\nnegate: 0\n"
                      "occupied_thresh: 0.65\nfree_thresh: 0.196\n")


def office():
    """A loop around a block of rooms, 11 x 7 m along its middle."""
    plan = Plan(15, 11)
    for x0, y0, x1, y1 in ((3.4, 3.4, 11.4, 3.4), (3.4, 7.4, 11.4, 7.4), (3.4, 3.4, 3.4, 7.4),
                           (11.4, 3.4, 11.4, 7.4), (7.2, 3.4, 7.2, 7.4)):
        plan.wall(x0, y0, x1, y1)
    plan.door(5.0, 3.3, 6.2, 3.8)
    plan.door(9.0, 7.3, 10.2, 7.8)
    for x0, y0, x1, y1 in ((5.5, 0, 5.5, 0.6), (9.5, 0, 9.5, 0.5), (6.0, 10.2, 6.0, 10.8),
                           (0, 5.4, 0.5, 5.4), (14.4, 5.0, 14.8, 5.0)):
        plan.wall(x0, y0, x1, y1)  # pillars: the corridor is not a plain box
    plan.write("office")


def corridor():
    """A room, a corridor of 36 m with two turns that face a wall, a room."""
    plan = Plan(26, 14)
    plan.block(5.2, 2.4, 25.8, 13.8)   # all but the two rooms and the corridor is solid
    plan.block(0.2, 6.0, 5.2, 13.8)
    plan.block(0.2, 0.2, 5.8, 6.0, 254)        # first room
    plan.block(5.8, 0.2, 25.8, 2.4, 0)
    plan.block(5.0, 1.0, 23.0, 3.0, 254)       # along +x
    plan.block(21.0, 1.0, 23.0, 11.0, 254)     # along +y
    plan.block(7.0, 9.0, 23.0, 11.0, 254)      # back along -x
    plan.block(1.0, 7.6, 7.0, 12.8, 254)       # last room
    plan.write("corridor")


def twins():
    """Two equal loops, 16 m apart, joined by a short passage: like two floors of one building."""
    plan = Plan(31, 11)
    for x in (0, 16):
        plan.wall(x + 3.4, 3.4, x + 11.4, 3.4)
        plan.wall(x + 3.4, 7.4, x + 11.4, 7.4)
        plan.wall(x + 3.4, 3.4, x + 3.4, 7.4)
        plan.wall(x + 11.4, 3.4, x + 11.4, 7.4)
        plan.wall(x + 5.5, 0, x + 5.5, 0.6)
        plan.wall(x + 6.0, 10.2, x + 6.0, 10.8)
    plan.block(14.8, 0.2, 16.2, 10.8)
    plan.block(14.8, 0.9, 16.2, 2.5, 254)
    plan.write("twins")


def apartment():
    """Three rooms and two, on both sides of a hall 1.4 m wide."""
    plan = Plan(12, 9)
    for x0, y0, x1, y1 in ((0, 3.8, 12, 3.8), (0, 5.4, 12, 5.4), (4.2, 0, 4.2, 3.8),
                           (8.0, 0, 8.0, 3.8), (5.2, 5.4, 5.2, 9)):
        plan.wall(x0, y0, x1, y1)
    for x, y in ((2.2, 3.8), (5.6, 3.8), (9.4, 3.8), (1.6, 5.4), (7.6, 5.4)):
        plan.door(x, y - 0.1, x + 1.2, y + 0.3)
    plan.write("apartment")


if __name__ == "__main__":
    apartment()
    office()
    corridor()
    twins()
