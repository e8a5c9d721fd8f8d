// The runs of one recording on the truth, or, without a truth, on its floor plan.
import { type Column, type Columns, decodeColumns, quantile } from './data';
import { app } from './store';

export interface Way { x: ArrayLike<number>; y: ArrayLike<number> }
export interface MeanNees { position: number; attitude: number; pose: number }

/** What a truth says of a run: its way less the true one, and what its errors come to. */
export interface AgainstTruth {
  meanNees: MeanNees;
  nees: Column;
  error: Way;
  distance: Float32Array;
}

/** A run in a scene. */
export interface SceneRun {
  index: number;
  t: Column;
  at: Way;
  against: AgainstTruth | null;
}

export interface Scene {
  axes: [string, string];
  truth: Way | null;
  plan: { wall: Way; furniture: Way };
  runs: SceneRun[];
}

type RawColumns = Record<string, string>;
type RawSceneRun = RawColumns & { run: unknown; mean_nees?: unknown };
export interface RawScene {
  truth?: RawColumns; plan: { wall: RawColumns; furniture: RawColumns }; runs: RawSceneRun[];
}

const span = (values: ArrayLike<number>) => quantile(values, 1) - quantile(values, 0);

/** A scene as it is drawn: one that is taller than wide lies on its side, y to the right. */
export function decodeScene(raw: RawScene): Scene {
  const truth = raw.truth ? decodeColumns(raw.truth) : null;
  const plan = { wall: decodeColumns(raw.plan.wall), furniture: decodeColumns(raw.plan.furniture) };
  const frame = !truth || plan.wall.x.length ? plan.wall : truth;
  const turned = span(frame.y) > 1.2 * span(frame.x);
  const placed = ({ x, y }: Columns): Way => (turned ? { x: y, y: x.map((v) => -v) } : { x, y });
  return {
    axes: turned ? ['y', '−x'] : ['x', 'y'],
    truth: truth && placed(truth),
    plan: { wall: placed(plan.wall), furniture: placed(plan.furniture) },
    runs: raw.runs.map((rawRun) => decodeSceneRun(rawRun, placed)),
  };
}

function decodeSceneRun({ run, mean_nees: meanNees, ...columns }: RawSceneRun,
    placed: (columns: Columns) => Way): SceneRun {
  const c = decodeColumns(columns as RawColumns);
  return {
    index: run as number, t: c.t, at: placed(c),
    against: meanNees ? {
      meanNees: meanNees as MeanNees, nees: c.nees, error: placed({ x: c.ex, y: c.ey }),
      distance: Float32Array.from(c.ex, (_, i) => Math.hypot(c.ex[i], c.ey[i], c.ez[i])),
    } : null,
  };
}

const scenes: Scene[] = [];

export function readScenes(raw: RawScene[] | undefined): void {
  scenes.splice(0, scenes.length, ...(raw ?? []).map(decodeScene));
}

/** The scene of the run of that index, where it has one. */
export const sceneOf = (index = app.active): Scene | undefined =>
  scenes.find((s) => s.runs.some((r) => r.index === index));
