#!/usr/bin/env python3
"""make_bags.py: writes the bags in bags/, which the tests read, by the libraries that robots use.

ROS 1 by rosbag (Debian: python3-rosbag python3-sensor-msgs python3-nav-msgs python3-tf2-msgs); MCAP by make_mcap.mjs
(npm install @mcap/core @foxglove/rosmsg @foxglove/rosmsg-msgs-common @foxglove/rosmsg2-serialization @foxglove/wasm-zstd lz4js),
which also serialises; the SQLite3 database by Python's sqlite3 with the same bytes. NODE_PATH: the folder with the npm packages.
"""
import base64
import json
import os
import shutil
import subprocess

from bag_files import Ros1Bag, Sqlite
from ros_messages import cdr

HERE = os.path.dirname(os.path.abspath(__file__))
BAGS = f"{HERE}/bags"
WIDTH, HEIGHT = 64, 64


def messages():
    """(topic, type, content, ns): 3 images at 10 Hz, depth 1 ms later, IMU, wheels, truth, the frames of the robot."""
    optical = {"x": -0.5, "y": 0.5, "z": -0.5, "w": 0.5}
    forward = {"w": 1.0}
    for i in range(3):
        ns = 100 * 10**9 + i * 10**8

        def header(frame, later=0, ns=ns):
            return {"stamp": ns + later, "frame_id": frame}

        def transform(parent, child, p, q, header=header):
            return {"header": header(parent), "child_frame_id": child,
                    "transform": {"translation": dict(zip("xyz", p)), "rotation": q}}
        if i == 0:
            yield "/tf_static", "tf2_msgs/TFMessage", {"transforms": [
                transform("base_footprint", "base_link", (0.0, 0.0, 0.1), forward),
                transform("base_link", "camera_optical", (0.2, 0.0, 0.3), optical),
                transform("base_link", "imu_link", (0.0, 0.0, 0.05), forward)]}, ns
        yield "/camera/camera_info", "sensor_msgs/CameraInfo", {
            "header": header("camera_optical"), "height": HEIGHT, "width": WIDTH, "distortion_model": "plumb_bob",
            "D": [0.1, -0.05, 0.001, 0.002, 0.0], "K": [60.0, 0.0, 31.5, 0.0, 61.0, 32.5, 0.0, 0.0, 1.0],
            "R": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
            "P": [60.0, 0.0, 31.5, 0.0, 0.0, 61.0, 32.5, 0.0, 0.0, 0.0, 1.0, 0.0]}, ns
        yield "/camera/image_raw", "sensor_msgs/Image", {
            "header": header("camera_optical"), "height": HEIGHT, "width": WIDTH, "encoding": "mono8", "step": WIDTH,
            "data": bytes([(k + i) % 251 for k in range(WIDTH * HEIGHT)])}, ns
        yield "/camera/depth/image_raw", "sensor_msgs/Image", {
            "header": header("camera_optical", 10**6), "height": HEIGHT, "width": WIDTH, "encoding": "16UC1",
            "step": 2 * WIDTH, "data": (1500 + i).to_bytes(2, "little") * (WIDTH * HEIGHT)}, ns + 10**6
        yield "/imu", "sensor_msgs/Imu", {
            "header": header("imu_link"), "orientation": forward, "angular_velocity": {"z": 0.5}, "linear_acceleration": {"z": 9.8}}, ns
        yield "/odom", "nav_msgs/Odometry", {
            "header": header("odom"), "child_frame_id": "base_link",
            "pose": {"pose": {"position": {"x": 0.1 * i}, "orientation": forward}}}, ns
        yield "/tf", "tf2_msgs/TFMessage", {"transforms": [
            transform("odom", "base_footprint", (0.1 * i, 0.0, 0.0), forward),
            transform("world", "base_link_gt", (0.1 * i, 2.0, 0.0), forward)]}, ns
        yield "/chatter", "std_msgs/String", {"data": "hello"}, ns


def write(bag):
    for topic, kind, value, ns in messages():
        bag.write(topic, kind, value, ns)
    bag.close()


def main():
    shutil.rmtree(BAGS, ignore_errors=True)
    os.makedirs(BAGS)
    for compression in ("none", "bz2", "lz4"):
        write(Ros1Bag(f"{BAGS}/ros1_{compression}.bag", compression))
    lines = [json.dumps({"topic": t, "type": k, "value": v, "ns": ns},
                        default=lambda data: {"base64": base64.b64encode(data).decode()}) for t, k, v, ns in messages()]
    done = subprocess.run(["node", f"{HERE}/make_mcap.mjs", BAGS], input="\n".join(lines), text=True,
                          capture_output=True, check=True)
    for line, (topic, kind, value, _) in zip(done.stdout.splitlines(), messages()):
        if base64.b64decode(line) != cdr(kind, value):
            raise SystemExit(f"ros_messages.py serialises {topic} ({kind}) otherwise than rosmsg2-serialization")
    write(Sqlite(f"{BAGS}/rosbag2"))


if __name__ == "__main__":
    main()
