// What the parts of the page share: the runs, the cursor, the visible time span.

const app = { runs: [], scenes: [], active: 0, cursor: 0, span: [0, 1], fullSpan: [0, 1] };
const listeners = {};

const activeRun = () => app.runs[app.active];

/** Calls f after each change of the kind: 'run', 'cursor', 'span', 'theme', or before a 'print'. */
function listen(kind, f) {
  (listeners[kind] = listeners[kind] || []).push(f);
}

function notify(kind) {
  for (const f of listeners[kind] || []) f();
}

function setCursor(index) {
  const next = clamp(Math.round(index), 0, activeRun().count - 1);
  if (next === app.cursor) return;
  app.cursor = next;
  notify('cursor');
}

function setCursorTime(t) {
  setCursor(nearestIndex(activeRun().states.t, t));
}

function setSpan(low, high) {
  const [first, last] = app.fullSpan;
  const width = clamp(high - low, (last - first) / 2000, last - first);
  const start = clamp(low, first, last - width);
  app.span = [start, start + width];
  notify('span');
}

function setRun(index) {
  app.active = index;
  const t = activeRun().states.t;
  const last = t.length ? t[t.length - 1] : 1;
  app.fullSpan = [0, last > 0 ? last : 1];
  app.span = app.fullSpan.slice();
  app.cursor = Math.max(0, t.length - 1);
  notify('run');
  notify('cursor');
  notify('span');
}

/** Runs f at most once a frame of the screen. */
function throttled(f) {
  let waiting = false;
  return () => {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => { waiting = false; f(); });
  };
}
