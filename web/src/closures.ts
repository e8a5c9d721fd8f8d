// The loop closures of a run, as summary.json lists them.
import { nearestIndex } from './data';
import type { Run } from './runs';

export interface Closure {
  /** The first state with it. */
  state: number;
  landmarks: number;
  /** By which it moved the pose [m]. */
  moved: number;
}

/** Those whose pose is finite. */
export function closuresOf(run: Run): Closure[] {
  const { summary: { closures }, states: { x, y, z } } = run;
  if (!Array.isArray(closures) || !run.count) return [];
  const known = closures.filter(({ seconds }) => typeof seconds === 'number');
  return known.map((entry: Record<string, unknown>) => ({
    state: nearestIndex(run.t, Number(entry.seconds)),
    landmarks: Number(entry.landmarks) || 0,
    moved: Number(entry.moved_m) || 0,
  })).filter(({ state: i }) => Number.isFinite(x[i] + y[i] + z[i]));
}
