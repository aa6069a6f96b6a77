#!/usr/bin/env python3
"""Samples a true trajectory at a rate and adds white noise, to see what `gw-eval smooth` makes of it.

usage: noisy_truth.py TRUTH.tum OUT.tum --rate HZ --metres SIGMA --degrees SIGMA [--seed N]
"""
import argparse
import math
import random


def turned(q, phi):
    """q * Exp(phi), for small phi; quaternions x y z w."""
    x, y, z, w = q
    a, b, c = (angle / 2 for angle in phi)
    product = (
        x + w * a + y * c - z * b,
        y + w * b + z * a - x * c,
        z + w * c + x * b - y * a,
        w - x * a - y * b - z * c,
    )
    norm = math.sqrt(sum(v * v for v in product))
    return [v / norm for v in product]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("truth")
    parser.add_argument("out")
    parser.add_argument("--rate", type=float, required=True, help="Hz")
    parser.add_argument("--metres", type=float, required=True, help="per axis")
    parser.add_argument("--degrees", type=float, required=True, help="per axis")
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    rng = random.Random(args.seed)
    due = -math.inf
    with open(args.truth) as truth, open(args.out, "w") as out:
        for line in truth:
            values = [float(word) for word in line.split("#")[0].split()]
            if not values or values[0] < due - 1e-6:
                continue
            due = max(due, values[0]) + 1 / args.rate
            position = [p + rng.gauss(0, args.metres) for p in values[1:4]]
            rotation = turned(values[4:], [math.radians(rng.gauss(0, args.degrees)) for _ in range(3)])
            print(f"{values[0]:.6f}", *(f"{v:.9f}" for v in position + rotation), file=out)


if __name__ == "__main__":
    main()
