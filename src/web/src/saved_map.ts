// A saved map: one in which a run found its place, or one on a page of its own.
import { AXES, type Axis, clamp, column, type Columns, decodeColumns, quantile } from './data';
import { grouped } from './format';

export interface Session {
  name: string;
  /** On the clock of its recording [s]. */
  begin: number;
  seconds: number;
  cameras: number;
}

export interface SavedMap {
  sessions: Session[];
  /** As a run's landmarks, with session, own, observations, views and returned (map_data.hpp). */
  marks: Columns;
  /** The root of the trace of their covariance [m]. */
  sigma: Float64Array;
}

export interface RawSavedMap {
  sessions: Session[];
  marks: Record<string, string>;
  /** Alone: what has changed of a map that the page has. */
  returned?: string;
}

export function decodeSavedMap(raw: RawSavedMap | undefined): SavedMap | null {
  if (!raw) return null;
  const marks = decodeColumns(raw.marks), { cxx, cyy, czz } = marks;
  const sigma = Float64Array.from(cxx, (c, i) => Math.sqrt(Math.max(0, c + cyy[i] + czz[i])));
  return { sessions: raw.sessions, marks, sigma };
}

/** The whole map, or which of its landmarks have returned by now. */
export function grownMap(map: SavedMap | null, raw: Partial<RawSavedMap>): SavedMap | null {
  if (raw.sessions && raw.marks) return decodeSavedMap(raw as RawSavedMap);
  if (!map || !raw.returned) return map;
  return { ...map, marks: { ...map.marks, returned: column(raw.returned) } };
}

// Hues that a run's own colours leave, first.
const HUES = ['f-3', 'f-2', 'f-4', 'f-5', 'f-6', 'f-7', 'f-8', 'f-1'];

export const sessionColour = (k: number): string => HUES[k % HUES.length];

/** Its key among the layers of a map. */
export const sessionKey = (k: number): string => `session-${k}`;

/** How opaque each landmark is, 0.3 to 1: the better known, the more. */
export function opacities({ sigma }: SavedMap): Float64Array {
  const log = (s: number) => Math.log(Math.max(s, 1e-9));
  const [low, high] = [0.05, 0.95].map((q) => log(quantile(sigma, q)));
  return sigma.map((s) => (high > low ? 1 - 0.7 * clamp((log(s) - low) / (high - low), 0, 1) : 1));
}

/** The ends of where all but the farthest landmarks are, along each axis. */
export const marksBox = ({ marks }: SavedMap): Record<Axis, number[]> =>
  Object.fromEntries(AXES.map((axis) => [axis, [0.01, 0.99].map((q) => quantile(marks[axis], q))
    .filter(Number.isFinite)])) as Record<Axis, number[]>;

export function mapText({ marks, sessions }: SavedMap): string {
  const s = sessions.length === 1 ? '' : 's';
  return `Map with ${grouped(marks.id.length)} landmarks of ${sessions.length} session${s}.`;
}
