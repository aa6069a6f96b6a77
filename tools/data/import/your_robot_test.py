"""Every command of docs/your-robot.md, literally and in order, in a fresh folder with a bag, a recorder's folder and a folder in TUM's
layout of simulated drives. What the document prints below a command has to be what the program prints, but for the digits.

usage: your_robot_test.py BIN [FOLDER]: FOLDER keeps what is made
"""
import os
import re
import struct
import subprocess
import sys
import tempfile
import zlib

FOLDER = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(FOLDER)))
sys.path.insert(0, f"{ROOT}/tools/data/bag/testing")
from log_to_bag import convert, events, images  # noqa: E402

SCENARIO = """name: your_robot
map: {root}/config/scenarios/maps/office/map.yaml
waypoints: [[9.5, 2.0, 0.0], [12.5, 2.0, 0.0], [12.8, 4.5, 1.57], [11.0, 4.5, 3.14], [11.0, 2.5, -1.57]]
visit: [0, 1, 2, 3, 4]
drive: {{max_m_s: 0.6, max_deg_s: 60, turn_at_waypoints: false, pause_s: 0}}
world: {{walls: textured, floor: wood}}
camera: {{rate_hz: 10, mode: {mode}, width: 320, height: 240, focal_px: 190}}
"""
# Of a robot with its devices: their own tests run them (record_live_test, preflight_test, services_test).
ON_THE_ROBOT = ("apt-get ", "gw-preflight", "gw-record ", "gw-backend ", "sudo ")


def simulate(binaries, folder, mode, seconds):
    with open(f"{folder}/{mode}_scenario.yaml", "w", encoding="utf-8") as f:
        f.write(SCENARIO.format(root=ROOT, mode=mode))
    subprocess.run([f"{binaries}/gw-sim", "--scenario", f"{folder}/{mode}_scenario.yaml", "--duration", str(seconds), "--log",
                    f"{folder}/{mode}.lcm", "--config-out", f"{folder}/{mode}.yaml"], check=True, capture_output=True)
    return f"{folder}/{mode}.lcm", f"{folder}/{mode}.yaml"


def write_png(path, width, height, bits, pixels):
    """Grey, 8 bits or 16 (big-endian in the file)."""
    row = width * bits // 8
    rows = b"".join(b"\0" + pixels[i * row:(i + 1) * row] for i in range(height))

    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
    with open(path, "wb") as f:
        f.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, bits, 0, 0, 0, 0)) +
                chunk(b"IDAT", zlib.compress(rows, 1)) + chunk(b"IEND", b""))


def write_tum(log, folder):
    os.makedirs(f"{folder}/rgb")
    os.makedirs(f"{folder}/depth")
    with open(f"{folder}/rgb.txt", "w", encoding="utf-8") as rgb, open(f"{folder}/depth.txt", "w", encoding="utf-8") as depth:
        for channel, payload in events(log):
            if channel != "CAMERA":
                continue
            utime, parts = images(payload)
            for kind, width, height, _, _, pixels in parts:
                name, out, bits = ("depth", depth, 16) if kind == 3 else ("rgb", rgb, 8)
                if bits == 16:
                    pixels = b"".join(struct.pack(">H", v) for (v,) in struct.iter_unpack("<H", pixels))
                write_png(f"{folder}/{name}/{utime}.png", width, height, bits, pixels)
                out.write(f"{utime // 10**6}.{utime % 10**6:06d} {name}/{utime}.png\n")


def commands(document):
    """(command, lines that are printed below it, or None where the document shows no output)."""
    found, current = [], None
    for line in document.splitlines():
        code = line[4:] if line.startswith("    ") else None
        if code is None:
            current = current if line == "" else None  # what is printed may hold empty lines
        elif code.startswith("$ "):
            current = []
            found.append((code[2:].split("   #")[0].strip(), current))
        elif current is not None:
            current.append(code)
        else:
            found.append((code.split("   #")[0].strip(), None))
    return found


def skeleton(lines):
    """Words without digits, signs and what the last digits decide."""
    out = []
    for line in lines:
        line = re.sub(r", not yet to .*", "", line)
        line = re.sub(r"[-+]?\d[\d.]*(e-?\d+)?", "#", line)
        out.append(" ".join(line.split()))
    return [line for line in out if line]


def run(command, expected, binaries, folder):
    """None, or what is wrong."""
    done = subprocess.run(["sh", "-c", command.replace("BIN/", f"{binaries}/")], cwd=folder, capture_output=True, text=True,
                          check=False)
    allowed = 1 if any(line.startswith("ERROR") for line in expected or []) else 0
    if done.returncode != allowed:
        return f"exit {done.returncode} instead of {allowed}\n{done.stdout}{done.stderr}"
    if expected is not None and skeleton(done.stdout.splitlines()) != skeleton(expected):
        return f"the document prints\n{chr(10).join(expected)}\nand the program\n{done.stdout}"
    return None


def main():
    binaries = os.path.abspath(sys.argv[1])
    with open(f"{ROOT}/docs/your-robot.md", encoding="utf-8") as f:
        document = commands(f.read())
    with tempfile.TemporaryDirectory() as temporary:
        folder = os.path.abspath(sys.argv[2]) if len(sys.argv) > 2 else temporary
        os.makedirs(f"{folder}/made", exist_ok=True)
        log, config = simulate(binaries, f"{folder}/made", "stereo", 16)
        convert(log, config, f"{folder}/my_drive.mcap", "mcap")
        os.makedirs(f"{folder}/recordings")
        os.rename(log, f"{folder}/recordings/gw-2026-11-29T08-36-48.855218.lcm")
        os.rename(config, f"{folder}/robot.yaml")
        write_tum(simulate(binaries, f"{folder}/made", "rgbd", 3)[0], f"{folder}/my_folder")
        ran, failed = 0, 0
        for command, expected in document:
            if command.startswith(ON_THE_ROBOT):
                print(f"not run here: {command}")
                continue
            wrong = run(command, expected, binaries, folder)
            ran += 1
            failed += wrong is not None
            print(f"{'FAILED' if wrong else 'ok'}: {command}" + (f"\n{wrong}" if wrong else ""), flush=True)
    print(f"{ran} commands run, {failed} failed")
    sys.exit(1 if failed or ran < 8 else 0)


if __name__ == "__main__":
    main()
