"""faults_test.py BIN [quick]: recordings with one fault each, which gw-check has to name, and their clean twins, of which it has to
say nothing. Two simulated drives of 16 s (stereo, RGB-D) are spoilt here, not by the project's own gw-fault.

quick: the faults that are found without following the images. Prints a line a fault; exit 1 when fewer than 28 of 30 (quick: not all)
are named or a clean twin is blamed.
"""
import json
import os
import struct
import subprocess
import sys
import tempfile

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
SCENARIO = """name: check
map: {root}/config/scenarios/maps/office/map.yaml
waypoints: [[9.5, 2.0, 0.0], [12.5, 2.0, 0.0], [12.8, 4.5, 1.57], [11.0, 4.5, 3.14], [11.0, 2.5, -1.57]]
visit: [0, 1, 2, 3, 4]
drive: {{max_m_s: 0.6, max_deg_s: 60, turn_at_waypoints: false, pause_s: 0}}
world: {{walls: textured, floor: wood}}
camera: {{rate_hz: 10, mode: {mode}, width: 320, height: 240, focal_px: 190}}
"""
HOUR = 3_600_000_000  # us


class Camera:
    """A camera_t; images as arrays by name."""
    KINDS = {1: "left", 2: "right", 3: "depth"}

    def __init__(self, payload):
        self.head = payload[:8]
        self.utime, self.seq, self.exposure, self.emitter, count = struct.unpack_from(">qqiii", payload, 8)
        self.images = {}
        at = 36
        for _ in range(count):
            kind, width, height, _, pixel_format, size = struct.unpack_from(">6i", payload, at)
            at += 24
            data = np.frombuffer(payload[at:at + size], "<u2" if pixel_format == 2 else np.uint8)
            self.images[self.KINDS[kind]] = data.reshape(height, width).copy()
            at += size

    def encode(self):
        out = [self.head, struct.pack(">qqiii", self.utime, self.seq, self.exposure, self.emitter, len(self.images))]
        for kind, name in self.KINDS.items():
            if name in self.images:
                image = np.ascontiguousarray(self.images[name])
                depth = image.dtype != np.uint8
                data = image.tobytes()
                out.append(struct.pack(">6i", kind, image.shape[1], image.shape[0], image.shape[1] * (2 if depth else 1),
                                       2 if depth else 1, len(data)) + data)
        return b"".join(out)


class Record:
    """imu_t or wheel_t by fields."""
    FORMATS = {"IMU": (">qq6d?", "utime seq wx wy wz ax ay az has"),
               "WHEEL": (">qqq?iiddd?d???", "utime seq begin ticks l r dx dy dyaw has heading bumper cliff drop")}

    def __init__(self, channel, payload):
        self.format, names = self.FORMATS[channel]
        self.names = names.split()
        self.head = payload[:8]
        self.__dict__.update(zip(self.names, struct.unpack_from(self.format, payload, 8)))

    def encode(self):
        return self.head + struct.pack(self.format, *(self.__dict__[n] for n in self.names))


def read(path):
    with open(path, "rb") as f:
        while head := f.read(28):
            _, _, received, size, length = struct.unpack(">IQQII", head)
            channel = f.read(size).decode()
            payload = f.read(length)
            if channel == "CAMERA":
                yield received, channel, Camera(payload)
            elif channel in Record.FORMATS:
                yield received, channel, Record(channel, payload)


def write(path, events):
    with open(path, "wb") as f:
        for number, (received, channel, message) in enumerate(events):
            payload = message.encode()
            f.write(struct.pack(">IQQII", 0xEDA1DA01, number, received, len(channel), len(payload)) + channel.encode() + payload)


# ---------------------------------------------------------------- faults: events -> events
def each(channel, edit):
    """edit(message, number) changes it, or returns False to drop it."""
    def fault(events):
        number = 0
        for received, name, message in events:
            if name == channel:
                number += 1
                if edit(message, number) is False:
                    continue
            yield received, name, message
    return fault


def scaled(channel, factor, *fields):
    def edit(message, _):
        for field in fields:
            setattr(message, field, getattr(message, field) * factor)
    return each(channel, edit)


def later(channel, us):
    def edit(message, _):
        message.utime += us
        if hasattr(message, "begin"):
            message.begin += us
    return each(channel, edit)


def image_edit(edit):
    def change(camera, number):
        for name in ("left", "right"):
            if name in camera.images:
                camera.images[name] = edit(camera.images[name], number)
    return each("CAMERA", change)


def swap_eyes(camera, _):
    camera.images["left"], camera.images["right"] = camera.images["right"], camera.images["left"]


def one_eye(camera, _):
    camera.images["right"] = camera.images["left"].copy()


def rows_shifted(camera, _):
    camera.images["right"] = np.roll(camera.images["right"], 2, axis=0)


def lagging(name):
    def make():
        last = []

        def edit(camera, _):
            last.append(camera.images[name])
            camera.images[name] = last[-2] if len(last) > 1 else last[-1]
        return each("CAMERA", edit)
    return lambda events: make()(events)


def frozen(events):
    last = None
    for received, name, message in events:
        if name == "CAMERA":
            if last is not None and message.seq % 3 == 0:
                message.images = last
            last = message.images
        yield received, name, message


def dots(image, _):
    rng = np.random.default_rng(5)
    out = image.astype(int)
    for y, x in zip(rng.integers(2, image.shape[0] - 2, 900), rng.integers(2, image.shape[1] - 2, 900)):
        out[y - 1:y + 2, x - 1:x + 2] += 90
    return out.clip(0, 255).astype(np.uint8)


def blurred(image, _):
    out = image.astype(float)
    for _ in range(4):
        for axis in (0, 1):
            out = sum(np.roll(out, k, axis) for k in (-2, -1, 0, 1, 2)) / 5
    return out.astype(np.uint8)


def jitter():
    rng = np.random.default_rng(1)

    def edit(message, _):
        message.utime += int(rng.normal(0, 35_000))
    return each("CAMERA", edit)


def turned_axes(message, _):
    message.wx, message.wy, message.wz = message.wz, message.wx, message.wy
    message.ax, message.ay, message.az = message.az, message.ax, message.ay


def upside_down(message, _):
    for field in ("wx", "wy", "ax", "ay"):
        setattr(message, field, -getattr(message, field))


def without_gravity(message, _):
    message.ax, message.ay, message.az = (v * 0.01 for v in (message.ax, message.ay, message.az))


def swapped_times(events):
    events = list(events)
    cameras = [i for i, e in enumerate(events) if e[1] == "CAMERA"]
    for i in cameras[10::20]:
        j = cameras[cameras.index(i) + 1]
        events[i], events[j] = events[j], events[i]
    return events


def rotated_camera(text):
    """T_BC turned by 10 degrees about the body's z."""
    half = np.radians(10) / 2
    w, x, y, z = 0.5, -0.5, 0.5, -0.5
    c, s = np.cos(half), np.sin(half)
    return text.replace("q_wxyz: [0.5, -0.5, 0.5, -0.5]}  # left camera",
                        f"q_wxyz: [{c * w - s * z}, {c * x - s * y}, {c * y + s * x}, {c * z + s * w}]}}  # left camera")


def drop_share(share):
    rng = np.random.default_rng(2)
    return lambda *_: rng.random() > share


# name, drive, fault of the events, ids of which one has to be found, whether the images have to be followed for it
FAULTS = [
    ("stamps in nanoseconds", "stereo", each("CAMERA", lambda m, _: setattr(m, "utime", m.utime * 1000)),
     ["stamp-unit", "undecodable"], False),
    ("stamps in milliseconds", "stereo", each("IMU", lambda m, _: setattr(m, "utime", m.utime // 1000)), ["stamp-unit"], False),
    ("IMU clock an hour off", "stereo", later("IMU", HOUR), ["clock"], False),
    ("camera clock an hour off", "rgbd", later("CAMERA", -HOUR), ["clock"], False),
    ("IMU 120 ms late", "stereo", later("IMU", 120_000), ["imu-delay"], True),
    ("wheels 150 ms late", "rgbd", later("WHEEL", 150_000), ["wheel-delay"], True),
    ("images dropped for 1 s", "stereo", each("CAMERA", lambda m, n: not 50 < n < 61), ["gap"], False),
    ("a fifth of the images dropped", "rgbd", each("CAMERA", drop_share(0.2)), ["lost"], False),
    ("IMU gap of half a second", "stereo", each("IMU", lambda m, n: not 1000 < n < 1100), ["gap"], False),
    ("IMU stamps doubled", "stereo", each("IMU", lambda m, n: setattr(m, "utime", m.utime - m.utime % 10_000)),
     ["stamp-doubled"], False),
    ("image stamps with jitter", "stereo", jitter(), ["jitter"], False),
    ("images out of order", "stereo", swapped_times, ["order"], False),
    ("IMU at a tenth of its rate", "stereo", each("IMU", lambda m, n: n % 10 == 0), ["rate"], False),
    ("no IMU at all", "stereo", each("IMU", lambda *_: False), ["stream-missing"], False),
    ("eyes swapped", "stereo", each("CAMERA", swap_eyes), ["eyes-swapped"], False),
    ("one eye twice", "stereo", each("CAMERA", one_eye), ["one-eye-twice"], False),
    ("right eye two rows off", "stereo", each("CAMERA", rows_shifted), ["rows"], False),
    ("right eye one image late", "stereo", lagging("right"), ["eye-late"], False),
    ("dark images", "stereo", image_edit(lambda i, _: (i // 30).astype(np.uint8)), ["dark"], False),
    ("overexposed images", "rgbd", image_edit(lambda i, _: (i.astype(int) * 4).clip(0, 255).astype(np.uint8)), ["burnt"], False),
    ("every third image frozen", "stereo", frozen, ["frozen"], False),
    ("dots of the emitter", "stereo", image_edit(dots), ["static-pattern"], False),
    ("out of focus", "rgbd", image_edit(blurred), ["blur"], False),
    ("depth in centimetres", "rgbd",
     each("CAMERA", lambda m, _: m.images.update(depth=(m.images["depth"] // 10).astype("<u2"))), ["depth-unit", "way-scale"], True),
    ("no depth", "rgbd", each("CAMERA", lambda m, _: m.images.update(depth=m.images["depth"] * 0)), ["depth-empty"], False),
    ("gyro in degrees", "stereo", scaled("IMU", 57.29578, "wx", "wy", "wz"), ["gyro-unit"], False),
    ("accelerometer in g", "stereo", scaled("IMU", 1 / 9.80665, "ax", "ay", "az"), ["accel-unit"], False),
    ("gravity removed", "stereo", each("IMU", without_gravity), ["gravity-removed"], False),
    ("IMU axes turned", "stereo", each("IMU", turned_axes), ["imu-axes", "imu-tilt"], False),
    ("IMU upside down", "stereo", each("IMU", upside_down), ["imu-tilt", "gyro-sign"], False),
    ("wheels reversed", "stereo", scaled("WHEEL", -1, "dx", "dy"), ["wheel-way-sign"], True),
    ("wheels exchanged", "rgbd", scaled("WHEEL", -1, "dyaw", "heading"), ["wheel-turn-sign"], True),
    ("track off by a third", "stereo", scaled("WHEEL", 1.33, "dyaw", "heading"), ["wheel-turn-scale"], True),
    ("wheels in centimetres", "stereo", scaled("WHEEL", 100, "dx", "dy"), ["way-scale"], True),
    ("camera mounted 10 degrees off", "stereo", rotated_camera, ["camera-yaw"], True),
]


def check(binaries, log, config, vision):
    done = subprocess.run([f"{binaries}/gw-check", log, "--config", config, "--json"] + ([] if vision else ["--no-vision"]),
                          capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1) or not done.stdout:
        sys.exit(f"gw-check: exit {done.returncode}\n{done.stderr}")
    return [finding["id"] for finding in json.loads(done.stdout)["findings"]]


def run_fault(binaries, folder, fault):
    name, drive, edit, expected, vision = fault
    log, config = f"{folder}/{drive}.lcm", f"{folder}/{drive}.yaml"
    if edit is rotated_camera:
        with open(config, encoding="utf-8") as f:
            text = f.read()
        config = f"{folder}/spoilt.yaml"
        with open(config, "w", encoding="utf-8") as f:
            f.write(rotated_camera(text))
    else:
        write(f"{folder}/spoilt.lcm", edit(read(log)))
        log = f"{folder}/spoilt.lcm"
    found = check(binaries, log, config, vision)
    named = bool(set(found) & set(expected))
    print(f"{'named' if named else 'MISSED':7} {name}: {', '.join(found) or 'nothing'}", flush=True)
    return named


def main():
    binaries, quick = sys.argv[1], "quick" in sys.argv[2:]
    faults = [fault for fault in FAULTS if not quick or not fault[4]]
    if quick:
        faults = faults[::4]
    blamed = 0
    with tempfile.TemporaryDirectory() as folder:
        for mode in sorted({fault[1] for fault in faults}):
            with open(f"{folder}/s.yaml", "w", encoding="utf-8") as f:
                f.write(SCENARIO.format(root=ROOT, mode=mode))
            subprocess.run([f"{binaries}/gw-sim", "--scenario", f"{folder}/s.yaml", "--duration", "16", "--log",
                            f"{folder}/{mode}.lcm", "--config-out", f"{folder}/{mode}.yaml"], check=True, capture_output=True)
            found = check(binaries, f"{folder}/{mode}.lcm", f"{folder}/{mode}.yaml", not quick)
            print(f"clean {mode}: {', '.join(found) or 'nothing'}", flush=True)
            blamed += len(found)
        named = sum(run_fault(binaries, folder, fault) for fault in faults)
    print(f"{named} of {len(faults)} faults named, {blamed} findings on the clean twins")
    needed = len(faults) if quick else round(len(faults) * 28 / 30)
    sys.exit(named < needed or blamed > 0)


if __name__ == "__main__":
    main()
