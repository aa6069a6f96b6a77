"""Bags as files: ROS 1 by rosbag (python3-rosbag), rosbag2's SQLite3 by its schema, MCAP by its specification."""
import os
import sqlite3
import struct
import zlib

from ros_messages import cdr, ros1


class Ros1Bag:
    def __init__(self, path, compression="none"):
        import rosbag
        self.bag = rosbag.Bag(path, "w", compression=compression)

    def write(self, topic, kind, value, ns):
        import rospy
        self.bag.write(topic, ros1(kind, value), rospy.Time(ns // 10**9, ns % 10**9))

    def close(self):
        self.bag.close()


def long_type(kind):
    return kind.replace("/", "/msg/")


class Sqlite:
    """A folder as `ros2 bag record` of Humble leaves it."""

    def __init__(self, folder):
        os.makedirs(folder)
        self.folder = folder
        self.name = os.path.basename(folder) + "_0.db3"
        self.db = sqlite3.connect(f"{folder}/{self.name}")
        self.db.executescript(
            "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,"
            " serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);"
            "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL,"
            " data BLOB NOT NULL);"
            "CREATE INDEX timestamp_idx ON messages (timestamp ASC);")
        self.topics = {}

    def write(self, topic, kind, value, ns):
        if topic not in self.topics:
            self.topics[topic] = len(self.topics) + 1
            self.db.execute("INSERT INTO topics VALUES (?, ?, ?, 'cdr', '')", (self.topics[topic], topic, long_type(kind)))
        self.db.execute("INSERT INTO messages (topic_id, timestamp, data) VALUES (?, ?, ?)",
                        (self.topics[topic], ns, cdr(kind, value)))

    def close(self):
        self.db.commit()
        self.db.close()
        with open(f"{self.folder}/metadata.yaml", "w", encoding="utf-8") as f:
            f.write("rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: sqlite3\n"
                    f"  relative_file_paths:\n    - {self.name}\n  compression_format: \"\"\n  compression_mode: \"\"\n")


def text(value):
    data = value.encode()
    return struct.pack("<I", len(data)) + data


def record(op, content):
    return struct.pack("<BQ", op, len(content)) + content


class Mcap:
    """Chunks without compression, or none at all; no index, which the specification allows."""
    MAGIC = b"\x89MCAP0\r\n"

    def __init__(self, path, chunk_bytes=1 << 20):
        self.file = open(path, "wb")
        self.file.write(self.MAGIC + record(1, text("ros2") + text("bag_files.py")))
        self.chunk_bytes = chunk_bytes
        self.chunk = []
        self.times = []
        self.channels = {}

    def put(self, data, ns=None):
        if not self.chunk_bytes:
            self.file.write(data)
            return
        self.chunk.append(data)
        if ns is not None:
            self.times.append(ns)
        if sum(map(len, self.chunk)) >= self.chunk_bytes:
            self.flush()

    def flush(self):
        if self.chunk:
            data = b"".join(self.chunk)
            times = self.times or [0]
            self.file.write(record(6, struct.pack("<QQQI", min(times), max(times), len(data), zlib.crc32(data)) + text("") +
                                   struct.pack("<Q", len(data)) + data))
        self.chunk, self.times = [], []

    def write(self, topic, kind, value, ns):
        if topic not in self.channels:
            number = len(self.channels) + 1
            self.channels[topic] = number
            self.put(record(3, struct.pack("<H", number) + text(long_type(kind)) + text("ros2msg") + text("# not needed")))
            self.put(record(4, struct.pack("<HH", number, number) + text(topic) + text("cdr") + text("")))
        self.put(record(5, struct.pack("<HIQQ", self.channels[topic], 0, ns, ns) + cdr(kind, value)), ns)

    def close(self):
        self.flush()
        self.file.write(record(15, struct.pack("<I", 0)) + record(2, struct.pack("<QQI", 0, 0, 0)) + self.MAGIC)
        self.file.close()


def open_bag(container, path):
    return {"ros1": Ros1Bag, "sqlite": Sqlite, "mcap": Mcap}[container](path)
