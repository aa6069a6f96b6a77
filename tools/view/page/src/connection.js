// The connection to gw-view: Foxglove's own client, which subscribes to all topics, and comes back by itself.
import {FoxgloveClient} from '@foxglove/ws-protocol';

const RETRY_MS = 1000;
const decoder = new TextDecoder();

export class Connection {
  // handlers: topic -> function(message, received), received: s, by gw-view's clock or that of the log; events: opened(info), lost(), parameters(list).
  constructor(url, handlers, events) {
    Object.assign(this, {url, handlers, events});
    this.connect();
  }

  connect() {
    const socket = new WebSocket(this.url, [FoxgloveClient.SUPPORTED_SUBPROTOCOL]);
    const client = new FoxgloveClient({ws: socket});
    const topics = new Map();
    client.on('serverInfo', (info) => {
      this.events.opened(info);
      if (info.capabilities.includes('parametersSubscribe')) client.subscribeParameterUpdates([]);
    });
    client.on('parameterValues', ({parameters}) => this.events.parameters(parameters));
    client.on('advertise', (channels) => {
      for (const channel of channels) {
        if (channel.encoding !== 'json' || !this.handlers[channel.topic]) continue;
        topics.set(client.subscribe(channel.id), channel.topic);
      }
    });
    client.on('message', ({subscriptionId, timestamp, data}) => {
      const topic = topics.get(subscriptionId);
      if (topic) this.handlers[topic](JSON.parse(decoder.decode(data)), Number(timestamp) * 1e-9);
    });
    client.on('error', () => {});
    client.on('close', () => {
      this.client = null;
      this.events.lost();
      setTimeout(() => this.connect(), RETRY_MS);
    });
    this.client = client;
  }

  setParameters(values) {
    const parameters = Object.entries(values).map(([name, value]) => ({name, value}));
    this.client?.setParameters(parameters);
  }
}
