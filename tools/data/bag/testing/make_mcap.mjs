// node make_mcap.mjs FOLDER < messages (JSON lines of make_bags.py): MCAP files by @mcap/core; prints each message's CDR bytes.
import { createRequire } from "node:module";
import { readFileSync, writeFileSync } from "node:fs";
const require = createRequire((process.env.NODE_PATH ?? process.cwd()) + "/");
const { McapWriter } = require("@mcap/core");
const { MessageWriter } = require("@foxglove/rosmsg2-serialization");
const { ros2humble } = require("@foxglove/rosmsg-msgs-common");
const zstd = require("@foxglove/wasm-zstd");
const lz4 = require("lz4js");

const FIELDS = { D: "d", K: "k", R: "r", P: "p" };  // CameraInfo has small letters in ROS 2

function definitionsOf(type) {
  const seen = [];
  const visit = (name) => {
    const definition = ros2humble[name.replace("/msg/", "/")] ?? ros2humble[name];
    if (!definition || seen.some((d) => d.name === name)) return;
    seen.push({ ...definition, name });
    for (const field of definition.definitions) if (field.isComplex) visit(field.type);
  };
  visit(type);
  return seen;
}

function toRos2(value, type) {
  if (Array.isArray(value)) return value.map((v) => toRos2(v));
  if (value === null || typeof value !== "object") return value;
  if ("base64" in value) return Buffer.from(value.base64, "base64");
  const out = {};
  for (const [key, inner] of Object.entries(value)) {
    const name = type === "sensor_msgs/CameraInfo" ? FIELDS[key] ?? key : key;
    out[name] = key === "stamp" ? { sec: Math.floor(inner / 1e9), nanosec: inner % 1e9 } : toRos2(inner);
  }
  return out;
}

class Sink {
  parts = [];
  size = 0n;
  position() { return this.size; }
  async write(data) { this.parts.push(Buffer.from(data)); this.size += BigInt(data.byteLength); }
}

const messages = readFileSync(0, "utf8").split("\n").filter(Boolean).map((line) => JSON.parse(line));
const bytes = messages.map((m) => {
  const name = m.type;
  return Buffer.from(new MessageWriter(definitionsOf(name)).writeMessage(toRos2(m.value, m.type)));
});
for (const b of bytes) console.log(b.toString("base64"));

await zstd.isLoaded;
const variants = {
  none: { useChunks: true },
  unchunked: { useChunks: false },
  unindexed: { useChunks: true, useChunkIndex: false, useMessageIndex: false, useSummaryOffsets: false,
               repeatChannels: false, repeatSchemas: false, useStatistics: false },
  zstd: { compressChunk: (d) => ({ compression: "zstd", compressedData: zstd.compress(d) }) },
  lz4: { compressChunk: (d) => ({ compression: "lz4", compressedData: lz4.compress(d) }) },
};
for (const [name, options] of Object.entries(variants)) {
  const sink = new Sink();
  const writer = new McapWriter({ writable: sink, chunkSize: 20000, ...options });
  await writer.start({ profile: "ros2", library: "@mcap/core" });
  const channels = {};
  for (const [i, m] of messages.entries()) {
    if (!(m.topic in channels)) {
      const schemaId = await writer.registerSchema({
        name: m.type.replace("/", "/msg/"), encoding: "ros2msg", data: Buffer.from("# left out") });
      channels[m.topic] = await writer.registerChannel({
        schemaId, topic: m.topic, messageEncoding: "cdr", metadata: new Map() });
    }
    await writer.addMessage({ channelId: channels[m.topic], sequence: i, logTime: BigInt(m.ns),
                              publishTime: BigInt(m.ns), data: bytes[i] });
  }
  await writer.end();
  writeFileSync(`${process.argv[2]}/${name}.mcap`, Buffer.concat(sink.parts));
}
