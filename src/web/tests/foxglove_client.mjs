// A client of Foxglove's WebSocket protocol, from Foxglove's own libraries: it subscribes to every
// channel and keeps what it gets, decoded by the schemas that the server advertises.
import { createRequire } from 'node:module';
import { WebSocket } from 'ws';
import { plain, typeOf } from './foxglove_schemas.mjs';
import { check } from './verdict.mjs';

const { FoxgloveClient } = createRequire(import.meta.url)('@foxglove/ws-protocol');

const nanoseconds = ({ seconds, nanos }) => BigInt(seconds ?? 0) * 1000000000n + BigInt(nanos ?? 0);
const stampOf = (object) => object.timestamp ?? object.transforms?.[0].timestamp
  ?? object.entities?.[0]?.timestamp ?? object.deletions[0].timestamp;

/** `official`: Foxglove's schemas. `wanted`: topics to subscribe to; by default all. */
export class Client {
  constructor(url, official, { subprotocol = 'foxglove.websocket.v1', wanted = () => true,
    origin } = {}) {
    this.topics = {};
    this.clock = [];
    this.statuses = [];
    this.socket = new WebSocket(url, [subprotocol], { origin });
    this.client = new FoxgloveClient({ ws: this.socket });
    const channels = new Map(), subscriptions = new Map();
    this.client.on('error', (error) => check('the client has no error', false, String(error)));
    this.client.on('serverInfo', (info) => {
      check('the server introduces itself once', !this.info);
      this.info = info;
      check('the subprotocol is chosen', this.socket.protocol === subprotocol, this.socket.protocol);
    });
    this.client.on('status', (status) => this.statuses.push(status));
    this.client.on('time', ({ timestamp }) => this.clock.push(timestamp));
    this.client.on('advertise', (list) => {
      check('the server introduces itself first', this.info !== undefined);
      for (const channel of list) {
        check(`${channel.topic}: has a number of its own`, !channels.has(channel.id));
        channels.set(channel.id, channel);
        check(`${channel.topic}: is protobuf`, channel.encoding === 'protobuf');
        const type = typeOf({ name: channel.schemaName, encoding: channel.schemaEncoding,
          data: Buffer.from(channel.schema, 'base64') }, official);
        this.topics[channel.topic] = { type, messages: [], channel: channel.id };
        if (!wanted(channel.topic)) continue;
        subscriptions.set(this.client.subscribe(channel.id), channel.topic);
      }
    });
    this.client.on('message', ({ subscriptionId, timestamp, data }) => {
      const topic = subscriptions.get(subscriptionId);
      const { type, messages } = this.topics[topic];
      const bytes = new Uint8Array(data.buffer, data.byteOffset, data.byteLength);
      const object = plain(type, bytes);
      check(`${topic}: the stamp is the message's time`, nanoseconds(stampOf(object)) === timestamp);
      check(`${topic}: its time was sent before`, this.clock.at(-1) >= timestamp);
      messages.push({ time: timestamp, object });
    });
    this.closed = new Promise((done) => this.client.on('close', (event) => done(event.code)));
  }

  count(topic) { return this.topics[topic]?.messages.length ?? 0; }
}
