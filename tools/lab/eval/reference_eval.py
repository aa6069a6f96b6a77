#!/usr/bin/env python3
"""A second opinion on gw-eval: the same measures, written independently with numpy.

    reference_eval.py GW_EVAL    runs the program on random trajectories and compares all numbers

Rotations are matrices here and quaternions there, the SE(3) geodesic is the matrix logarithm's
closed form. Exit: 0 all agree to 1e-9, 1 they do not, 77 numpy is missing (ctest: skipped).
"""

import json
import os
import subprocess
import sys
import tempfile

try:
    import numpy as np
except ImportError:
    print("numpy is missing; install python3-numpy to run this comparison")
    sys.exit(77)

TOLERANCE = 1e-9
LENGTHS = [1, 2, 5, 10, 20, 50, 100, 200, 400, 800]


def skew(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def rot_exp(v):
    angle = np.linalg.norm(v)
    if angle < 1e-12:
        return np.eye(3) + skew(v)
    k = skew(v / angle)
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * (k @ k)


def rot_log(R):
    v = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    sine = np.linalg.norm(v)
    angle = np.arctan2(sine, 0.5 * (np.trace(R) - 1))
    return v if sine < 1e-12 else v * (angle / sine)


def left_jacobian(v):
    angle = np.linalg.norm(v)
    k = skew(v)
    if angle < 1e-4:
        return np.eye(3) + 0.5 * k + k @ k / 6
    return (np.eye(3) + (1 - np.cos(angle)) / angle**2 * k
            + (angle - np.sin(angle)) / angle**3 * (k @ k))


def matrix(R, p):
    T = np.eye(4)
    T[:3, :3] = R
    T[:3, 3] = p
    return T


def quat_to_rot(x, y, z, w):
    n = np.sqrt(x * x + y * y + z * z + w * w)
    x, y, z, w = x / n, y / n, z / n, w / n
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def read_tum(path):
    times, poses = [], []
    for row in np.atleast_2d(np.loadtxt(path)):
        times.append(int(round(row[0] * 1e6)))
        poses.append(matrix(quat_to_rot(*row[4:8]), row[1:4]))
    return times, poses


def geodesic(A, B, fraction):
    D = np.linalg.inv(A) @ B
    phi = rot_log(D[:3, :3])
    rho = np.linalg.solve(left_jacobian(phi), D[:3, 3])
    return A @ matrix(rot_exp(fraction * phi), left_jacobian(fraction * phi) @ (fraction * rho))


def associate(ref, est, max_gap=100000, max_diff=20000):
    times, poses = ref
    out = []
    for t, T in zip(*est):
        right = int(np.searchsorted(times, t))
        if right < len(times) and times[right] == t:
            out.append((t, poses[right], T))
            continue
        if 0 < right < len(times) and times[right] - times[right - 1] <= max_gap:
            f = (t - times[right - 1]) / (times[right] - times[right - 1])
            out.append((t, geodesic(poses[right - 1], poses[right], f), T))
            continue
        best = min(range(len(times)), key=lambda i: abs(times[i] - t))
        if abs(times[best] - t) <= max_diff:
            out.append((t, poses[best], T))
    return out


def align(pairs, mode):
    if mode == "none":
        return np.eye(4)
    P = np.array([p[1][:3, 3] for p in pairs])
    Q = np.array([p[2][:3, 3] for p in pairs])
    p0, q0 = P.mean(axis=0), Q.mean(axis=0)
    if mode == "yaw":
        # Best turn of the points in the complex plane.
        u, v = (P - p0) @ [1, 1j, 0], (Q - q0) @ [1, 1j, 0]
        turn = np.vdot(v, u)
        turn /= abs(turn)
        R = np.array([[turn.real, -turn.imag, 0], [turn.imag, turn.real, 0], [0, 0, 1]])
    else:
        # Horn 1987: the quaternion is the largest eigenvector of a symmetric 4x4 matrix.
        S = (Q - q0).T @ (P - p0)
        delta = np.array([S[1, 2] - S[2, 1], S[2, 0] - S[0, 2], S[0, 1] - S[1, 0]])
        N = np.block([[np.array([[np.trace(S)]]), delta[None, :]],
                      [delta[:, None], S + S.T - np.trace(S) * np.eye(3)]])
        w, x, y, z = np.linalg.eigh(N)[1][:, -1]
        R = quat_to_rot(x, y, z, w)
    return matrix(R, p0 - R @ q0)


def degrees(T):
    return np.degrees(np.linalg.norm(rot_log(T[:3, :3])))


def motion_error(a, b):
    inv = np.linalg.inv
    return inv(inv(a[1]) @ b[1]) @ (inv(a[2]) @ b[2])


def stats(errors):
    if len(errors) == 0:
        return None
    e = np.array(errors)
    return {"count": len(e), "rmse": np.sqrt(np.mean(e**2)), "mean": np.mean(e),
            "median": np.median(e), "max": np.max(e)}


def distances(ref, pairs):
    way, counted, seen, out = 0.0, ref[1][0][:3, 3], 0, []
    for t, _, _ in pairs:
        while seen < len(ref[0]) and ref[0][seen] <= t:
            step = np.linalg.norm(ref[1][seen][:3, 3] - counted)
            if step >= 0.01:
                way, counted = way + step, ref[1][seen][:3, 3]
            seen += 1
        out.append(way)
    return np.array(out)


def completeness(ref, est):
    first, last = ref[0][0], ref[0][-1]
    periods = np.sort(np.diff(est[0]))
    longest = 3 * periods[len(periods) // 2]
    events = [min(first, est[0][0])] + list(est[0]) + [max(last, est[0][-1])]
    silent = sum(max(0, min(b, last) - max(a, first))
                 for a, b in zip(events[:-1], events[1:]) if b - a > longest)
    return 1 - silent / (last - first)


def evaluate(ref, est, mode, delta=1000000):
    pairs = associate(ref, est)
    T_ref_est = align(pairs, mode)
    pairs = [(t, a, T_ref_est @ b) for t, a, b in pairs]
    rpe = []
    t = np.array([p[0] for p in pairs])
    for i, pair in enumerate(pairs):
        miss = np.abs(t - (pair[0] + delta))
        j = int(np.argmin(miss))
        if miss[j] <= delta // 10:
            rpe.append(motion_error(pair, pairs[j]))
    way = distances(ref, pairs)
    percent, deg_per_m = [], []
    for length in LENGTHS:
        for i in range(len(pairs)):
            far = np.nonzero(way >= way[i] + length)[0]
            if len(far) > 0:
                error = motion_error(pairs[i], pairs[far[0]])
                percent.append(100 * np.linalg.norm(error[:3, 3]) / length)
                deg_per_m.append(degrees(error) / length)
    final = motion_error(pairs[0], pairs[-1])
    path = way[-1] - way[0]
    return {
        "pairs": len(pairs),
        "T_RefEst": {"p": list(T_ref_est[:3, 3])},
        "ape": {"translation_m": stats([np.linalg.norm(a[:3, 3] - b[:3, 3]) for _, a, b in pairs]),
                "rotation_deg": stats([degrees(np.linalg.inv(a) @ b) for _, a, b in pairs])},
        "rpe": {"translation_m": stats([np.linalg.norm(e[:3, 3]) for e in rpe]),
                "rotation_deg": stats([degrees(e) for e in rpe])},
        "drift": {"path_length_m": path, "final_error_m": np.linalg.norm(final[:3, 3]),
                  "final_error_deg": degrees(final),
                  "final_percent": 100 * np.linalg.norm(final[:3, 3]) / path,
                  "segments": len(percent), "segment_percent": np.mean(percent),
                  "segment_deg_per_m": np.mean(deg_per_m)},
        "completeness": completeness(ref, est),
    }


def random_case(seed, folder):
    """A smooth random drive; the estimate drifts, is noisy, has gaps and another frame."""
    rng = np.random.RandomState(seed)

    def write(name, times, poses):
        with open(os.path.join(folder, name), "w") as f:
            f.write("# made by reference_eval.py, seed %d\n" % seed)
            for t, T in zip(times, poses):
                v = rot_log(T[:3, :3])
                angle = np.linalg.norm(v)
                q = np.append(v / max(angle, 1e-300) * np.sin(angle / 2), np.cos(angle / 2))
                f.write("%.6f %s\n" % (t * 1e-6, " ".join("%.17g" % x for x in [*T[:3, 3], *q])))

    a = rng.normal(size=6)

    def truth(t):
        return matrix(rot_exp([0.1 * np.sin(t * a[0]), 0.1 * np.cos(t * a[1]), np.sin(t * a[2])]),
                      [3 * np.sin(0.3 * t * a[3]), 2 * np.cos(0.2 * t + a[4]), 0.1 * np.sin(t)])

    start = 1500000000000000 + rng.randint(1000000)
    ref_times = start + np.cumsum(rng.randint(8000, 12000, size=2500))
    hole = rng.randint(800, 1500)  # of the reference: too long to interpolate over
    ref_times = np.delete(ref_times, np.arange(hole, hole + 60))
    begin = start + rng.randint(-300000, 2000000)
    est_times = begin + np.cumsum(rng.randint(30000, 37000, size=rng.randint(650, 800)))
    gap = rng.randint(100, 500)
    est_times = np.delete(est_times, np.arange(gap, gap + rng.randint(1, 90)))
    offset = matrix(rot_exp(rng.normal(size=3)), 5 * rng.normal(size=3))
    drift = 0.002 * rng.normal(size=6)
    est = []
    for t in (est_times - start) * 1e-6:
        noise = drift * t + 0.01 * rng.normal(size=6)
        est.append(offset @ truth(t) @ matrix(rot_exp(noise[3:]), noise[:3]))
    write("ref.tum", ref_times, [truth(t) for t in (ref_times - start) * 1e-6])
    write("est.tum", est_times, est)


def differences(mine, theirs, path=""):
    """Yields what differs, for every number of mine."""
    if isinstance(mine, dict):
        for key, value in mine.items():
            yield from differences(value, theirs[key], path + "/" + key)
    elif isinstance(mine, list):
        for i, value in enumerate(mine):
            yield from differences(value, theirs[i], "%s/%d" % (path, i))
    elif mine is None or theirs is None:
        if mine is not theirs:
            yield "%s: %s here, %s there" % (path, mine, theirs)
    elif not abs(mine - theirs) <= TOLERANCE * max(1.0, abs(mine)):
        yield "%s: %.15g here, %.15g there" % (path, mine, theirs)


def main(program):
    failures = 0
    with tempfile.TemporaryDirectory() as folder:
        name = lambda file: os.path.join(folder, file)
        for seed in range(4):
            random_case(seed, folder)
            ref, est = read_tum(name("ref.tum")), read_tum(name("est.tum"))
            for mode in ("se3", "yaw", "none"):
                subprocess.run([program, "--ref", name("ref.tum"), "--est", name("est.tum"),
                                "--align", mode, "--json", name("out.json")],
                               check=True, stdout=subprocess.DEVNULL)
                with open(name("out.json")) as f:
                    theirs = json.load(f)
                for text in differences(evaluate(ref, est, mode), theirs):
                    print("seed %d, %s: %s" % (seed, mode, text))
                    failures += 1
    print("%d differences above %g" % (failures, TOLERANCE))
    return 1 if failures else 0


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1]))
