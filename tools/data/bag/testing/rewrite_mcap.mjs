// node rewrite_mcap.mjs IN OUT: an MCAP file read and written anew by @mcap/core, in chunks and with all its indexes.
// GW_PAGE_PACKAGES: the folder whose node_modules has @mcap/core.
import { createRequire } from "node:module";
import { readFileSync, writeFileSync } from "node:fs";
const require = createRequire(`${process.env.GW_PAGE_PACKAGES}/`);
const { McapStreamReader, McapWriter } = require("@mcap/core");

class Sink {
  parts = [];
  size = 0n;
  position() { return this.size; }
  async write(data) { this.parts.push(Buffer.from(data)); this.size += BigInt(data.byteLength); }
}

const reader = new McapStreamReader();
reader.append(readFileSync(process.argv[2]));
const sink = new Sink();
const writer = new McapWriter({ writable: sink });
await writer.start({ profile: "ros2", library: "@mcap/core" });
const schemas = new Map(), channels = new Map();
for (let record; (record = reader.nextRecord());) {
  if (record.type === "Schema") {
    schemas.set(record.id, await writer.registerSchema(record));
  } else if (record.type === "Channel") {
    channels.set(record.id, await writer.registerChannel({ ...record, schemaId: schemas.get(record.schemaId) }));
  } else if (record.type === "Message") {
    await writer.addMessage({ ...record, channelId: channels.get(record.channelId) });
  }
}
await writer.end();
writeFileSync(process.argv[3], Buffer.concat(sink.parts));
