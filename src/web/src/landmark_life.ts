// What a landmark is at a time of its run: tracked then, retired before, or not seen yet.
import { activeRun, type Run } from './runs';

export type Life = 'view' | 'retired' | 'later';

export const LIVES: readonly Life[] = ['later', 'retired', 'view'];

export const LIFE_LABELS: Record<Life, string> =
  { view: 'Landmarks in view', retired: 'retired', later: 'seen later' };

/** What is in view in the last map of a run that goes on is taken to be so until the next one. */
export function lifeAt({ landmarks, mapTime }: Run, i: number, t: number): Life {
  if (landmarks.last[i] < Math.min(t, mapTime)) return 'retired';
  return landmarks.first[i] > t ? 'later' : 'view';
}

/** What the tip of a landmark says of it. */
export function lifeText(i: number): string {
  const { first, last, in_state: inState } = activeRun().landmarks;
  const seen = `seen ${first[i].toFixed(2)} to ${last[i].toFixed(2)} s`;
  return `${seen}, ${inState[i] ? 'in the state at the end' : 'retired by the end'}`;
}
