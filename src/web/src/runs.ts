// A run as the page uses it, and what distinguishes the runs of a page.
import { type Axis, AXES, type Column, column, type Columns, clamp, DEG, decodeColumns, type Vector }
  from './data';
import { type CameraImages, decodeImages } from './images';
import { openingRow } from './opening';
import { decodeSavedMap, type RawSavedMap, type SavedMap } from './saved_map';
import { activeSubject, type Subject } from './store';

export type Summary = Record<string, unknown>;

export interface Run extends Subject {
  folder: string;
  summary: Summary;
  /** Gravity shows what is vertical in the run's world. */
  level: boolean;
  origin: Vector;
  extraNames: string[];
  states: Columns;
  extra: { value: Column; sigma: Column }[];
  stageNames: string[];
  /** What each took [ms]. */
  stages: Column[];
  /** In which the run found its place. */
  savedMap: SavedMap | null;
  /** With ix, iy and iz, the initial position, only where the run knows it of a landmark. */
  landmarks: Columns;
  /** When the landmarks were like that [s]: of a run that goes on they come less often than states. */
  mapTime: number;
  truth: Columns | null;
  /** Walls and furniture seen from above, placed as the truth is. */
  plan: { wall: Columns; furniture: Columns } | null;
  errors: Columns | null;
  deadReckoning: Columns | null;
  neesCoordinates: string;
  truthProblem: string;
  landmarksLeftOut: number;
  images: CameraImages[];
  euler: { yaw: Float32Array; pitch: Float32Array; roll: Float32Array };
  bounds: Record<string, number>;
  colour: string;
  dash: number[];
}

type RawColumns = Record<string, string>;
export interface RawRun {
  name: string; label?: string; summary?: Summary; level?: boolean; origin: Vector;
  health_names: string[]; extra_names: string[]; states: RawColumns; extra: RawColumns[];
  stage_names?: string[]; stages?: string[];
  landmarks: RawColumns; truth?: RawColumns; errors?: RawColumns; dead_reckoning?: RawColumns;
  nees_coordinates?: string; truth_problem?: string; landmarks_left_out?: number; images?: unknown;
  plan?: { wall: RawColumns; furniture: RawColumns };
  map?: RawSavedMap;
}

export const activeRun = (): Run => activeSubject() as Run;

export function decodeRun(raw: RawRun, bounds: Record<string, number>): Run {
  const states = decodeColumns(raw.states);
  return {
    name: raw.name,
    label: raw.name,
    folder: raw.label ?? '',
    summary: raw.summary ?? {},
    level: Boolean(raw.level),
    origin: raw.origin,
    healthNames: raw.health_names,
    extraNames: raw.extra_names,
    count: states.t.length,
    t: states.t,
    health: states.health,
    opening: openingRow(states),
    states,
    extra: raw.extra.map((e) => decodeColumns(e) as { value: Column; sigma: Column }),
    stageNames: raw.stage_names ?? [],
    stages: (raw.stages ?? []).map(column),
    landmarks: decodeColumns(raw.landmarks),
    savedMap: decodeSavedMap(raw.map),
    mapTime: Infinity,
    truth: raw.truth ? decodeColumns(raw.truth) : null,
    plan: raw.plan ? { wall: decodeColumns(raw.plan.wall),
      furniture: decodeColumns(raw.plan.furniture) } : null,
    errors: raw.errors ? decodeColumns(raw.errors) : null,
    deadReckoning: raw.dead_reckoning ? decodeColumns(raw.dead_reckoning) : null,
    neesCoordinates: raw.nees_coordinates ?? 'standard',
    truthProblem: raw.truth_problem ?? '',
    landmarksLeftOut: raw.landmarks_left_out ?? 0,
    images: decodeImages(raw.images),
    euler: eulerAngles(states),
    bounds,
    colour: 'estimate',
    dash: [],
  };
}

/** Yaw, pitch, roll [deg] of world_T_imu, each state's (z-y-x). */
export function eulerAngles({ qx, qy, qz, qw }: Columns): Run['euler'] {
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

/** Positions in the truth's world as placed by the first pose or by the best fit. */
export function placedColumns(columns: Columns, placed: string): Record<Axis, Column> {
  const prefix = placed === 'fit' ? 'fit_' : 'first_';
  return Object.fromEntries(AXES.map((axis) => [axis, columns[prefix + axis]])) as Record<Axis, Column>;
}

export const truthColumns = (run: Run, placed: string): Record<Axis, Column> =>
  placedColumns(run.truth as Columns, placed);

const CHARTS = ['standard', 'left-se3', 'right-se3', 'right-sen3'];
const SPARE_HUES = ['f-5', 'f-6', 'f-7', 'f-8'];

export function chartOf({ summary }: Run): string {
  const settings = (summary.settings ?? {}) as Record<string, unknown>;
  return [settings.chart, summary.chart].find((v): v is string => typeof v === 'string') ?? '';
}

/** Each chart has its colour; a further run of the same chart takes a spare one and a broken line. */
export function colourRuns(runs: Run[]): void {
  const taken = new Set<string>();
  let spare = 0;
  for (const run of runs) {
    const own = `f-${1 + CHARTS.indexOf(chartOf(run))}`;
    const first = own !== 'f-0' && !taken.has(own);
    run.colour = first ? own : SPARE_HUES[spare++ % SPARE_HUES.length];
    run.dash = first ? [] : [8, 4];
    taken.add(run.colour);
  }
}

/** Names for legends: short, and different for each run: the recordings', or the folders' where two
 *  runs are of one recording. */
export function labelRuns(runs: Run[]): void {
  const count = (key: 'name' | 'folder', value: string) =>
    runs.filter((r) => r[key] === value).length;
  const short = (text: string) => (text.length > 40 ? text.slice(0, 39) + '…' : text);
  const twins = runs.some((run) => count('name', run.name) > 1);
  runs.forEach((run, k) => {
    const ownFolder = twins && run.folder !== '' && count('folder', run.folder) === 1;
    const name = (ownFolder ? run.folder : run.name) || 'run';
    const cut = runs.length > 1 && short(name) !== name;
    const numbered = (count('name', run.name) > 1 && !ownFolder) || cut;
    run.label = numbered ? `${k + 1}: ${short(name)}` : short(name);
  });
}
