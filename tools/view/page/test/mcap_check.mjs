// Reads an MCAP file with @mcap/core, by its index and as a stream, and each message against its schema.
// usage: node mcap_check.mjs FILE
import {createRequire} from 'node:module';
import {open} from 'node:fs/promises';
import {readFileSync} from 'node:fs';
const require = createRequire(`${process.env.GW_PAGE_PACKAGES}/package.json`);
const {McapIndexedReader, McapStreamReader} = require('@mcap/core');
const Ajv = require('ajv');

const file = await open(process.argv[2]);
const readable = {
  size: async () => BigInt((await file.stat()).size),
  read: async (offset, length) => {
    const bytes = new Uint8Array(Number(length));
    await file.read(bytes, 0, Number(length), Number(offset));
    return bytes;
  },
};
const reader = await McapIndexedReader.Initialize({readable});
const ajv = new Ajv({strict: false}), fits = new Map(), counts = {};
for (const [id, schema] of reader.schemasById) fits.set(id, ajv.compile(JSON.parse(new TextDecoder().decode(schema.data))));
let last = 0n, total = 0n, failed = 0;
for await (const message of reader.readMessages()) {
  const channel = reader.channelsById.get(message.channelId);
  const check = fits.get(channel.schemaId);
  if (!check(JSON.parse(new TextDecoder().decode(message.data)))) {
    if (++failed < 5) console.log(`${channel.topic}: ${ajv.errorsText(check.errors)}`);
  }
  if (message.logTime < last) { console.log('not in order of time'); failed++; }
  last = message.logTime;
  counts[channel.topic] = (counts[channel.topic] ?? 0) + 1;
  ++total;
}
if (total !== reader.statistics.messageCount) { console.log('statistics are wrong'); failed++; }
// The same as a stream, with the CRCs of the chunks.
const stream = new McapStreamReader({validateCrcs: true});
stream.append(readFileSync(process.argv[2]));
let streamed = 0n;
for (let record; (record = stream.nextRecord());) if (record.type === 'Message') ++streamed;
if (!stream.done() || streamed !== total) { console.log(`as a stream ${streamed} of ${total}`); failed++; }
console.log(JSON.stringify(counts));
process.exit(failed > 0 || total === 0n ? 1 : 0);
