// foxglove_run.mjs CHASLES RECORDING FOLDER: runs CHASLES over a recording with images, and looks on with
// clients of Foxglove's WebSocket protocol: one from the beginning, one that comes late with the newer
// subprotocol, and one that never reads. Compares what they get with the run folder FOLDER/seen, and
// leaves the last picture as FOLDER/last.jpg, its time in FOLDER/report.json. Exit 1: something failed.
import { spawn } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import { Client } from './foxglove_client.mjs';
import { published } from './foxglove_schemas.mjs';
import { check, verdict } from './verdict.mjs';

const [chasles, recording, folder] = process.argv.slice(2);
const official = published();

/** Starts a run; resolves with its URL for Foxglove. */
function start(...options) {
  const child = spawn(chasles, ['run', recording, '-o', `${folder}/seen`, '--quiet', ...options],
    { stdio: ['ignore', 'ignore', 'pipe'] });
  let text = '';
  const ended = new Promise((done) => { child.on('exit', (code, signal) => done(signal ?? code)); });
  const url = new Promise((done, failed) => {
    child.stderr.on('data', (data) => {
      text += data;
      const found = /chasles: foxglove: (ws:\S+)\n/.exec(text);
      if (found) done(found[1]);
    });
    child.on('exit', () => failed(new Error(`no URL: ${text}`)));
  });
  return { url, ended };
}

/** The rows of a table of the run folder, by column. */
function table(file) {
  const [head, ...rows] = readFileSync(`${folder}/seen/${file}`, 'utf8').trim().split('\n')
    .map((line) => line.split(','));
  return rows.map((row) => Object.fromEntries(head.map((name, i) => [name,
    name === 'time_ns' ? BigInt(row[i]) : Number(row[i])])));
}

const messages = (client, topic) => client.topics[topic]?.messages ?? [];
const close = (a, b) => Math.abs(a - b) <= 1e-12 * Math.max(1, Math.abs(a));
const sameVector = (v, row, names = ['x', 'y', 'z']) =>
  ['x', 'y', 'z'].every((k, i) => (v[k] ?? 0) === row[names[i]]);
const sameRotation = (q, row) => ['x', 'y', 'z', 'w'].every((k) => close(q[k] ?? 0, row[`q${k}`]));
const samePose = (position, rotation, row) => sameVector(position, row) && sameRotation(rotation, row);

/** Each state has its messages, with the numbers of states.csv. */
function compareStates(client, who) {
  const rows = table('states.csv');
  for (const topic of ['/tf', '/pose', '/odometry', '/state']) {
    check(`${who}: ${topic} has each state once`, client.count(topic) === rows.length,
      `${client.count(topic)} of ${rows.length}`);
    check(`${who}: ${topic} has their times`,
      messages(client, topic).every((m, i) => m.time === rows[i]?.time_ns));
  }
  const each = (topic, same) => {
    const found = messages(client, topic).findIndex((m, i) => !same(m.object, rows[i]));
    check(`${who}: ${topic} has the numbers of states.csv`, found < 0, `row ${found}`);
  };
  each('/pose', ({ pose }, row) => samePose(pose.position, pose.orientation, row));
  each('/tf', ({ transforms: [t] }, row) => samePose(t.translation, t.rotation, row)
    && t.parent_frame_id === 'world' && t.child_frame_id === 'imu');
  each('/odometry', ({ pose, pose_covariance: P }, row) => samePose(pose.position, pose.orientation, row)
    && P[0] === row.cov_33 && P[7] === row.cov_44 && P[1] === row.cov_34 && P[21] === row.cov_00);
  each('/state', (s, row) => (s.used ?? 0) === row.used && (s.landmarks ?? 0) === row.landmarks
    && (s.nis ?? 0) === row.nis && s.velocity_x === row.velocity_x);
}

/** The pieces of the path, put together by their ids, are the path; the truth is there. */
function comparePath(client, who) {
  const lines = new Map();
  for (const { object } of messages(client, '/ways')) {
    if (object.deletions?.length) lines.clear();
    for (const entity of object.entities ?? []) lines.set(entity.id, entity.lines[0].points);
  }
  const rows = table('states.csv');
  const pieces = [...lines].filter(([id]) => id.startsWith('estimate '));
  const path = pieces.flatMap(([, points], i) => (i > 0 ? points.slice(1) : points));
  check(`${who}: the path is complete`, path.length === rows.length
    && path.every((p, i) => sameVector(p, rows[i])), `${path.length} of ${rows.length}`);
  check(`${who}: the truth is there`, lines.has('truth'));
}

function compareMap(client, who) {
  const rows = table('landmarks.csv');
  const cloud = messages(client, '/map').at(-1)?.object;
  const data = new DataView(Uint8Array.from(cloud?.data ?? []).buffer);
  check(`${who}: the cloud has every landmark`, data.byteLength === rows.length * cloud.point_stride,
    `${data.byteLength} bytes`);
  check(`${who}: the cloud has their positions`, rows.every((row, i) => ['x', 'y', 'z'].every((k, j) =>
    data.getFloat32(i * cloud.point_stride + 4 * j, true) === Math.fround(row[k]))));
  const spheres = messages(client, '/map/ellipsoids').at(-1)?.object.entities[0].spheres;
  check(`${who}: each landmark has an ellipsoid`, spheres.length === rows.length);
}

function compareRest(client, who) {
  const cameras = messages(client, '/tf_cameras').at(-1)?.object.transforms ?? [];
  check(`${who}: the cameras have their places`, cameras.length > 0
    && cameras.every((t, k) => t.parent_frame_id === 'imu' && t.child_frame_id === `cam${k}`));
  check(`${who}: the errors are there`, client.count('/errors') > 0
    && client.count('/errors') === client.count('/truth/pose'));
  const images = messages(client, '/cam0/image'), marks = messages(client, '/cam0/annotations');
  check(`${who}: images came`, images.length > 0, String(images.length));
  // On a busy machine few images are shown, perhaps none with a used point: then they have waiting ones.
  check(`${who}: points of images came`,
    marks.some(({ object }) => object.circles?.length > 0 || object.points?.length > 0));
  check(`${who}: they are of the images`, marks.at(-1)?.time === images.at(-1)?.time);
  check(`${who}: the clock goes forwards`, client.clock.every((t, i) => i === 0 || t > client.clock[i - 1]));
  check(`${who}: the end is reported`, client.statuses.at(-1)?.message.startsWith('the run is complete:'),
    JSON.stringify(client.statuses));
  check(`${who}: the server is named`, /^chasles \d/.test(client.info?.name), client.info?.name);
}

const run = start('--threads', '1', '--foxglove', '0');
const url = await run.url;
const early = new Client(url, official);
const deaf = new Client(url, official);
deaf.client.on('advertise', () => deaf.socket.pause());
let late;
early.client.on('message', () => {
  if (early.count('/pose') >= 10) {
    late ??= new Client(url, official, { subprotocol: 'foxglove.sdk.v1',
      origin: 'https://app.foxglove.dev' });
  }
});
check('the early client hears of the end', await early.closed === 1001);
check('the late client came in time', late !== undefined);
check('the late client hears of the end', await late?.closed === 1001);
check('the run is complete', await run.ended === 0);
for (const [who, client] of [['early', early], ['late', late]]) {
  if (!client) continue;
  compareStates(client, who);
  comparePath(client, who);
  compareMap(client, who);
  compareRest(client, who);
}
const { time, object } = messages(early, '/cam0/image').at(-1);
writeFileSync(`${folder}/last.jpg`, Uint8Array.from(object.data));
writeFileSync(`${folder}/report.json`, JSON.stringify({ time: String(time), topics:
  Object.fromEntries(Object.entries(early.topics).map(([topic, t]) => [topic, t.messages.length])) }));
deaf.socket.terminate();
process.exit(verdict());
