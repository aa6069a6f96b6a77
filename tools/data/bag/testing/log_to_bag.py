#!/usr/bin/env python3
"""log_to_bag.py LOG.lcm ROBOT.yaml OUT {ros1,sqlite,mcap}: the bag that a ROS robot would have recorded of the same drive.

Wheels become nav_msgs/Odometry (T_OB composed of the increments), the calibration CameraInfo and tf_static.
"""
import math
import re
import struct
import sys

from bag_files import open_bag


def events(path):
    """(channel, payload without its fingerprint) of an LCM log."""
    with open(path, "rb") as f:
        while head := f.read(28):
            _, _, _, channel, size = struct.unpack(">IQQII", head)
            name = f.read(channel).decode()
            yield name, f.read(size)[8:]


def images(payload):
    """utime, [(kind, width, height, stride, format, pixels)] of a camera_t."""
    utime, _, _, _, count = struct.unpack_from(">qqiii", payload)
    at = 28
    out = []
    for _ in range(count):
        kind, width, height, stride, pixel_format, size = struct.unpack_from(">6i", payload, at)
        at += 24
        out.append((kind, width, height, stride, pixel_format, payload[at:at + size]))
        at += size
    return utime, out


def pose_in_yaml(text, key):
    p, q = re.search(key + r": \{p: \[([^\]]*)\], q_wxyz: \[([^\]]*)\]\}", text).groups()
    return [float(v) for v in p.split(",")], [float(v) for v in q.split(",")]


def eye_in_yaml(text, key):
    section = text[text.index(f"    {key}:"):]
    return [float(re.search(rf"{k}: ([-0-9.e+]+)", section).group(1)) for k in ("fx", "fy", "cx", "cy")]


class Converter:
    def __init__(self, robot, bag):
        self.robot = robot
        self.bag = bag
        self.stereo = "kind: stereo" in robot
        self.x = self.y = self.yaw = 0.0
        self.odometry_begun = False
        self.begun = False

    def header(self, ns, frame):
        return {"stamp": ns, "frame_id": frame}

    def tf_static(self, ns):
        pairs = [("T_BC", "camera_left_optical"), ("T_BI", "imu")]
        transforms = []
        for key, child in pairs:
            p, q = pose_in_yaml(self.robot, key)
            transforms.append({"header": self.header(ns, "base_footprint"), "child_frame_id": child, "transform": {
                "translation": dict(zip("xyz", p)), "rotation": dict(zip("wxyz", q))}})
        self.bag.write("/tf_static", "tf2_msgs/TFMessage", {"transforms": transforms}, ns)

    def camera_info(self, name, eye, width, height, ns):
        fx, fy, cx, cy = eye_in_yaml(self.robot, eye)
        baseline = pose_in_yaml(self.robot, "T_C0C1")[0][0] if eye == "right" else 0.0
        self.bag.write(f"/camera/{name}/camera_info", "sensor_msgs/CameraInfo", {
            "header": self.header(ns, "camera_left_optical"), "height": height, "width": width,
            "distortion_model": "plumb_bob", "D": [0.0] * 5, "K": [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
            "R": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
            "P": [fx, 0.0, cx, -fx * baseline, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0]}, ns)

    def camera(self, payload):
        utime, parts = images(payload)
        ns = utime * 1000
        for kind, width, height, stride, _, pixels in parts:
            name = {1: "left" if self.stereo else "color", 2: "right", 3: "aligned_depth_to_color"}[kind]
            self.camera_info(name, "right" if kind == 2 else "left", width, height, ns)
            self.bag.write(f"/camera/{name}/image_raw", "sensor_msgs/Image", {
                "header": self.header(ns, "camera_left_optical"), "height": height, "width": width,
                "encoding": "16UC1" if kind == 3 else "mono8", "step": stride, "data": pixels}, ns)

    def imu(self, payload):
        utime, _, *v = struct.unpack_from(">qq6d", payload)
        self.bag.write("/imu/data", "sensor_msgs/Imu", {
            "header": self.header(utime * 1000, "imu"), "angular_velocity": dict(zip("xyz", v[:3])),
            "linear_acceleration": dict(zip("xyz", v[3:]))}, utime * 1000)

    def odometry(self, utime):
        self.bag.write("/odom", "nav_msgs/Odometry", {
            "header": self.header(utime * 1000, "odom"), "child_frame_id": "base_footprint", "pose": {"pose": {
                "position": {"x": self.x, "y": self.y, "z": 0.0},
                "orientation": {"z": math.sin(self.yaw / 2), "w": math.cos(self.yaw / 2)}}}}, utime * 1000)

    def wheel(self, payload):
        utime, _, begin, _, _, _, dx, dy, dyaw = struct.unpack_from(">qqq?iiddd", payload)
        if not self.odometry_begun:
            self.odometry_begun = True
            self.odometry(begin)
        self.x += math.cos(self.yaw) * dx - math.sin(self.yaw) * dy
        self.y += math.sin(self.yaw) * dx + math.cos(self.yaw) * dy
        self.yaw += dyaw
        self.odometry(utime)

    def truth(self, payload):
        utime, _, *v = struct.unpack_from(">qq7d", payload)
        self.bag.write("/ground_truth", "geometry_msgs/PoseStamped", {
            "header": self.header(utime * 1000, "world"), "pose": {
                "position": dict(zip("xyz", v[:3])), "orientation": dict(zip("wxyz", v[3:]))}}, utime * 1000)

    def add(self, channel, payload):
        if not self.begun and channel != "NOTE":
            self.begun = True
            self.tf_static(struct.unpack_from(">q", payload)[0] * 1000)
        handler = {"CAMERA": self.camera, "IMU": self.imu, "WHEEL": self.wheel, "GROUND_TRUTH": self.truth}.get(channel)
        if handler:
            handler(payload)


def convert(log, robot_yaml, out, container):
    with open(robot_yaml, encoding="utf-8") as f:
        robot = f.read()
    bag = open_bag(container, out)
    converter = Converter(robot, bag)
    for channel, payload in events(log):
        converter.add(channel, payload)
    bag.close()


if __name__ == "__main__":
    convert(*sys.argv[1:5])
