"""ROS messages as dictionaries, and their bytes: CDR as ROS 2 writes it, and the classes of ROS 1 filled from the same."""
import struct

TIME = "time"
SCHEMAS = {
    "std_msgs/Header": [("stamp", TIME), ("frame_id", "string")],
    "geometry_msgs/Vector3": [(k, "float64") for k in "xyz"],
    "geometry_msgs/Point": [(k, "float64") for k in "xyz"],
    "geometry_msgs/Quaternion": [(k, "float64") for k in "xyzw"],
    "geometry_msgs/Pose": [("position", "geometry_msgs/Point"), ("orientation", "geometry_msgs/Quaternion")],
    "geometry_msgs/PoseStamped": [("header", "std_msgs/Header"), ("pose", "geometry_msgs/Pose")],
    "geometry_msgs/PoseWithCovariance": [("pose", "geometry_msgs/Pose"), ("covariance", "float64[36]")],
    "geometry_msgs/Twist": [("linear", "geometry_msgs/Vector3"), ("angular", "geometry_msgs/Vector3")],
    "geometry_msgs/TwistWithCovariance": [("twist", "geometry_msgs/Twist"), ("covariance", "float64[36]")],
    "geometry_msgs/Transform": [("translation", "geometry_msgs/Vector3"), ("rotation", "geometry_msgs/Quaternion")],
    "geometry_msgs/TransformStamped": [("header", "std_msgs/Header"), ("child_frame_id", "string"),
                                       ("transform", "geometry_msgs/Transform")],
    "tf2_msgs/TFMessage": [("transforms", "geometry_msgs/TransformStamped[]")],
    "nav_msgs/Odometry": [("header", "std_msgs/Header"), ("child_frame_id", "string"),
                          ("pose", "geometry_msgs/PoseWithCovariance"), ("twist", "geometry_msgs/TwistWithCovariance")],
    "sensor_msgs/Image": [("header", "std_msgs/Header"), ("height", "uint32"), ("width", "uint32"), ("encoding", "string"),
                          ("is_bigendian", "uint8"), ("step", "uint32"), ("data", "uint8[]")],
    "sensor_msgs/CompressedImage": [("header", "std_msgs/Header"), ("format", "string"), ("data", "uint8[]")],
    "sensor_msgs/RegionOfInterest": [("x_offset", "uint32"), ("y_offset", "uint32"), ("height", "uint32"),
                                     ("width", "uint32"), ("do_rectify", "bool")],
    "sensor_msgs/CameraInfo": [("header", "std_msgs/Header"), ("height", "uint32"), ("width", "uint32"),
                               ("distortion_model", "string"), ("D", "float64[]"), ("K", "float64[9]"), ("R", "float64[9]"),
                               ("P", "float64[12]"), ("binning_x", "uint32"), ("binning_y", "uint32"),
                               ("roi", "sensor_msgs/RegionOfInterest")],
    "sensor_msgs/Imu": [("header", "std_msgs/Header"), ("orientation", "geometry_msgs/Quaternion"),
                        ("orientation_covariance", "float64[9]"), ("angular_velocity", "geometry_msgs/Vector3"),
                        ("angular_velocity_covariance", "float64[9]"), ("linear_acceleration", "geometry_msgs/Vector3"),
                        ("linear_acceleration_covariance", "float64[9]")],
    "sensor_msgs/JointState": [("header", "std_msgs/Header"), ("name", "string[]"), ("position", "float64[]"),
                               ("velocity", "float64[]"), ("effort", "float64[]")],
    "std_msgs/String": [("data", "string")],
}
NUMBERS = {"uint8": "B", "bool": "?", "uint32": "I", "float64": "d"}


def split_array(kind):
    """("float64", 9) of "float64[9]", ("string", None) of "string[]", or nothing of what is no array."""
    if not kind.endswith("]"):
        return None
    base, count = kind[:-1].split("[")
    return base, int(count) if count else None


def default(kind):
    array = split_array(kind)
    if array:
        return [default(array[0])] * (array[1] or 0)
    if kind in SCHEMAS:
        return {}
    return {"string": "", TIME: 0, "bool": False}.get(kind, 0)


class Cdr:
    """OMG CDR, little-endian: numbers aligned to their size after the 4 bytes of encapsulation."""

    def __init__(self):
        self.parts = [b"\x00\x01\x00\x00"]
        self.position = 0

    def raw(self, data):
        self.parts.append(data)
        self.position += len(data)

    def number(self, code, value):
        size = struct.calcsize(code)
        self.raw(b"\0" * (-self.position % size))
        self.raw(struct.pack("<" + code, value))

    def write(self, kind, value):
        array = split_array(kind)
        if array:
            base, count = array
            if count is None:
                self.number("I", len(value))
            if base == "uint8":
                return self.raw(bytes(value))
            for element in value:
                self.write(base, element)
        elif kind in SCHEMAS:
            for name, inner in SCHEMAS[kind]:
                self.write(inner, value.get(name, default(inner)))
        elif kind == "string":
            data = value.encode() + b"\0"
            self.number("I", len(data))
            self.raw(data)
        elif kind == TIME:
            self.number("i", value // 10**9)
            self.number("I", value % 10**9)
        else:
            self.number(NUMBERS[kind], value)


def cdr(kind, value):
    out = Cdr()
    out.write(kind, value)
    return b"".join(out.parts)


def ros1(kind, value):
    """An object of the message's class of ROS 1 (python3-sensor-msgs and its like)."""
    import importlib
    import genpy
    package, name = kind.split("/")
    message = getattr(importlib.import_module(package + ".msg"), name)()
    for field, inner in SCHEMAS[kind]:
        content = value.get(field, default(inner))
        array = split_array(inner)
        if inner == TIME:
            content = genpy.Time(content // 10**9, content % 10**9)
        elif inner in SCHEMAS:
            content = ros1(inner, content)
        elif array and array[0] in SCHEMAS:
            content = [ros1(array[0], element) for element in content]
        elif array and array[0] == "uint8":
            content = bytes(content)
        setattr(message, field, content)
    return message
