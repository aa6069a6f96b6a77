// Every channel of a running gw-view through Foxglove's own client, and each message against the schema that came with it.
// usage: node protocol_check.mjs ADDRESS SECONDS TOPIC...     the topics that must come within the time
// Exit 0: all messages fit; prints how many of each topic came.
import {createRequire} from 'node:module';
// The packages are where the page was built.
const require = createRequire(`${process.env.GW_PAGE_PACKAGES}/package.json`);
const {FoxgloveClient} = require('@foxglove/ws-protocol');
const Ajv = require('ajv');
const {WebSocket} = require('ws');

const [address, seconds, ...wanted] = process.argv.slice(2);
const ajv = new Ajv({strict: false});
const channels = new Map(), counts = {}, problems = [];
const socket = new WebSocket(address.replace('http', 'ws'), [FoxgloveClient.SUPPORTED_SUBPROTOCOL]);
const client = new FoxgloveClient({ws: socket});
client.on('error', (error) => problems.push(`error: ${error?.message ?? error}`));
client.on('status', (status) => problems.push(`status: ${status.message}`));
client.on('advertise', (list) => {
  for (const channel of list) {
    const fits = ajv.compile(JSON.parse(channel.schema));
    channels.set(client.subscribe(channel.id), {topic: channel.topic, fits});
  }
});
client.on('message', ({subscriptionId, timestamp, data}) => {
  const {topic, fits} = channels.get(subscriptionId);
  counts[topic] = (counts[topic] ?? 0) + 1;
  const message = JSON.parse(new TextDecoder().decode(data));
  if (!fits(message)) problems.push(`${topic}: ${ajv.errorsText(fits.errors)}`);
  if (typeof timestamp !== 'bigint') problems.push(`${topic}: no time`);
});
const started = Date.now();
setInterval(() => {
  const missing = wanted.filter((topic) => !counts[topic]);
  if (missing.length > 0 && Date.now() - started < 1000 * Number(seconds)) return;
  for (const topic of wanted) if (!counts[topic]) problems.push(`${topic}: no message came`);
  console.log(JSON.stringify(counts));
  for (const problem of problems.slice(0, 10)) console.log(problem);
  process.exit(problems.length > 0 ? 1 : 0);
}, 200);
