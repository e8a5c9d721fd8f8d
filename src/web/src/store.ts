// What the parts of a page share: the runs or studies, the cursor, the visible time span.
import { clamp, nearestIndex } from './data';

/** A run or a study: what the plots over time need of it. */
export interface Subject {
  name: string;
  /** What legends and pickers call it. */
  label: string;
  count: number;
  /** Times of its rows [s], rising. */
  t: ArrayLike<number>;
  health: ArrayLike<number>;
  healthNames: string[];
  /** The row at which the page opens; the last one where it is not given. */
  opening?: number;
}

/** 'rows': the active subject has grown; 'shown': another choice of what is drawn. */
type Kind = 'run' | 'rows' | 'cursor' | 'span' | 'theme' | 'shown' | 'print';

export const app = {
  subjects: [] as Subject[],
  active: 0,
  cursor: 0,
  span: [0, 1] as [number, number],
  fullSpan: [0, 1] as [number, number],
};
/** Rows of the active subject when it was last looked at. */
let shownRows = 0;
const listeners = new Map<Kind, (() => void)[]>();

export const activeSubject = (): Subject => app.subjects[app.active];

/** Calls f after each change of the kind, or before a print. */
export function listen(kind: Kind, f: () => void): void {
  listeners.set(kind, [...(listeners.get(kind) ?? []), f]);
}

export function notify(kind: Kind): void {
  for (const f of listeners.get(kind) ?? []) f();
}

export function setCursor(index: number): void {
  const next = clamp(Math.round(index), 0, activeSubject().count - 1);
  if (next === app.cursor) return;
  app.cursor = next;
  notify('cursor');
}

export function setCursorTime(t: number): void {
  setCursor(nearestIndex(activeSubject().t, t));
}

export function setSpan(low: number, high: number): void {
  const [first, last] = app.fullSpan;
  const width = clamp(high - low, (last - first) / 2000, last - first);
  const start = clamp(low, first, last - width);
  app.span = [start, start + width];
  notify('span');
}

export const showAllTimes = (): void => setSpan(...app.fullSpan);

function measureTimes(): void {
  const { t } = activeSubject(), last = t.length ? t[t.length - 1] : 1;
  app.fullSpan = [0, last > 0 ? last : 1];
  shownRows = t.length;
}

/** The active subject has more rows: a cursor at its end goes with it, and so does a view of all
 *  times. */
export function grow(): void {
  const follows = app.cursor >= shownRows - 1;
  const whole = app.span[0] <= app.fullSpan[0] && app.span[1] >= app.fullSpan[1];
  measureTimes();
  if (whole) app.span = [...app.fullSpan];
  app.cursor = follows ? Math.max(0, shownRows - 1) : clamp(app.cursor, 0, shownRows - 1);
  notify('rows');
  notify('cursor');
  notify('span');
}

export function setActive(index: number): void {
  app.active = index;
  measureTimes();
  app.span = [...app.fullSpan];
  app.cursor = activeSubject().opening ?? Math.max(0, shownRows - 1);
  notify('run');
  notify('cursor');
  notify('span');
}

/** Runs f at most once a frame of the screen. */
export function throttled(f: () => void): () => void {
  let waiting = false;
  return () => {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => { waiting = false; f(); });
  };
}
