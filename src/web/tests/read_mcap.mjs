// read_mcap.mjs FILE REPORT: reads an MCAP file with Foxglove's own libraries, holds its schemas against
// Foxglove's and each message against its schema, and writes into REPORT (json) what is in it. Exit 1:
// something is wrong.
import { open, readFile, writeFile } from 'node:fs/promises';
import { McapIndexedReader, McapStreamReader } from '@mcap/core';
import { plain, published, typeOf } from './foxglove_schemas.mjs';
import { check, verdict } from './verdict.mjs';

const [file, report] = process.argv.slice(2);

/** Every record, from the beginning to the end, with all check sums. */
async function readInOrder() {
  const reader = new McapStreamReader({ validateCrcs: true, includeChunks: true });
  reader.append(await readFile(file));
  const counts = {};
  for (let record; (record = reader.nextRecord());) {
    counts[record.type] = (counts[record.type] ?? 0) + 1;
  }
  check('the file is read to its end', reader.done() && reader.bytesRemaining() === 0);
  return counts;
}

async function readable() {
  const handle = await open(file);
  const { size } = await handle.stat();
  return {
    size: async () => BigInt(size),
    read: async (offset, length) => {
      const bytes = new Uint8Array(Number(length));
      await handle.read(bytes, 0, bytes.length, Number(offset));
      return bytes;
    },
  };
}

function note(entry, object) {
  entry.last = object;
  entry.first ??= object;
}

const official = published();
const records = await readInOrder();
const reader = await McapIndexedReader.Initialize({ readable: await readable() });
const types = new Map([...reader.schemasById].map(([id, s]) => [id, typeOf(s, official)]));
const topics = {};
let before = -1n;
for await (const message of reader.readMessages({ validateCrcs: true })) {
  const channel = reader.channelsById.get(message.channelId);
  const type = types.get(channel.schemaId);
  check('messages come in order of time', message.logTime >= before);
  before = message.logTime;
  const entry = topics[channel.topic] ??= { schema: type.fullName.slice(1), count: 0 };
  check(`${channel.topic}: a message each number`, message.sequence === entry.count);
  entry.count++;
  const object = plain(type, message.data);
  const theirs = official.nested.foxglove.nested[type.name];
  if (type.fullName.startsWith('.foxglove.')) {
    check(`${channel.topic}: Foxglove reads the same`,
      JSON.stringify(plain(theirs, message.data)) === JSON.stringify(object));
  }
  const stamp = object.timestamp ?? object.transforms?.[0].timestamp ?? object.entities[0].timestamp;
  check(`${channel.topic}: the stamp is the message's time`,
    BigInt(stamp.seconds ?? 0) * 1000000000n + BigInt(stamp.nanos ?? 0) === message.logTime);
  note(entry, object);
}
for (const [id, count] of reader.statistics.channelMessageCounts) {
  const { topic } = reader.channelsById.get(id);
  check(`${topic}: the statistics count it`, topics[topic].count === Number(count));
}

// A window in the middle, through the indices: as many as lie in it.
const { messageStartTime: begin, messageEndTime: end } = reader.statistics;
const low = begin + (end - begin) / 3n, high = begin + (2n * (end - begin)) / 3n;
const inside = async (options) => {
  let count = 0;
  for await (const m of reader.readMessages(options)) {
    if (m.logTime >= low && m.logTime <= high) count++; else if (options.startTime) count = NaN;
  }
  return count;
};
const window = await inside({ startTime: low, endTime: high });
check('a window of time is found by the indices', window === await inside({}), String(window));
check('a topic alone is found', await (async () => {
  let count = 0;
  for await (const m of reader.readMessages({ topics: ['/pose'] })) count += m ? 1 : 0;
  return count === (topics['/pose']?.count ?? 0);
})());

await writeFile(report, JSON.stringify({ topics, records, window, library: reader.header.library,
  begin: String(begin), end: String(end) }));
process.exit(verdict());
