// The numbers that travel in the page: json with columns of little-endian base64.

/** Bytes of a base64 text. */
function bytesOf(base64) {
  const binary = atob(base64);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; i++) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

/** A column "f32:…", "f64:…" or "i32:…" as a typed array. */
function column(text) {
  const types = { f32: Float32Array, f64: Float64Array, i32: Int32Array };
  const buffer = bytesOf(text.slice(4)).buffer;
  return new types[text.slice(0, 3)](buffer);
}

function decodeColumns(group) {
  const out = {};
  for (const [name, text] of Object.entries(group || {})) out[name] = column(text);
  return out;
}

/** A run as the page uses it: typed arrays by name, and derived columns. */
function decodeRun(raw) {
  const run = {
    name: raw.name,
    folder: raw.label || '',
    summary: raw.summary || {},
    level: Boolean(raw.level),
    origin: raw.origin,
    healthNames: raw.health_names,
    extraNames: raw.extra_names,
    states: decodeColumns(raw.states),
    extra: raw.extra.map((e) => decodeColumns(e)),
    landmarks: decodeColumns(raw.landmarks),
    truth: raw.truth ? decodeColumns(raw.truth) : null,
    errors: raw.errors ? decodeColumns(raw.errors) : null,
    deadReckoning: raw.dead_reckoning ? decodeColumns(raw.dead_reckoning) : null,
    neesCoordinates: raw.nees_coordinates || 'standard',
    truthProblem: raw.truth_problem || '',
    landmarksLeftOut: raw.landmarks_left_out || 0,
  };
  run.count = run.states.t.length;
  run.euler = eulerAngles(run.states);
  return run;
}

/** Yaw, pitch, roll [deg] of world_T_imu, each state's (z-y-x). */
function eulerAngles({ qx, qy, qz, qw }) {
  const n = qx.length;
  const yaw = new Float32Array(n), pitch = new Float32Array(n), roll = new Float32Array(n);
  for (let i = 0; i < n; i++) {
    const [x, y, z, w] = [qx[i], qy[i], qz[i], qw[i]];
    yaw[i] = DEG * Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
    pitch[i] = DEG * Math.asin(clamp(2 * (w * y - z * x), -1, 1));
    roll[i] = DEG * Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y));
  }
  return { yaw, pitch, roll };
}

const AXES = ['x', 'y', 'z'];
const DEG = 180 / Math.PI;
const clamp = (v, low, high) => Math.min(high, Math.max(low, v));

/** Index of the value nearest to v in a rising array. */
function nearestIndex(sorted, v) {
  let low = 0, high = sorted.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (sorted[middle] <= v) low = middle; else high = middle;
  }
  return high >= 0 && Math.abs(sorted[high] - v) < Math.abs(sorted[low] - v) ? high : low;
}

/** The q-quantile of the finite values; NaN when there are none. */
function quantile(values, q) {
  const finite = Array.from(values).filter(Number.isFinite).sort((a, b) => a - b);
  return finite.length ? finite[Math.round(q * (finite.length - 1))] : NaN;
}

function mean(values) {
  let sum = 0, n = 0;
  for (const v of values) if (Number.isFinite(v)) { sum += v; n++; }
  return n ? sum / n : NaN;
}

/** The share of the finite values within [low, high] (arrays or numbers). */
function shareInside(values, low, high) {
  let inside = 0, n = 0;
  for (let i = 0; i < values.length; i++) {
    if (!Number.isFinite(values[i])) continue;
    n++;
    if (values[i] >= at(low, i) && values[i] <= at(high, i)) inside++;
  }
  return n ? inside / n : NaN;
}

const at = (column, i) => (typeof column === 'number' ? column : column[i]);
