// A study as the page uses it: its filters, and what the plots need of it.
import { type Axis, type Column, type Columns, column, decodeColumns, type Vector } from './data';
import { activeSubject, type Subject } from './store';

/** An entry of `filters` in summary.json. */
export interface Figures {
  [key: string]: unknown;
  nees_position?: number; nees_attitude?: number; nees_pose_per_dof?: number; nees_state?: number;
  position_error_m?: number; attitude_error_deg?: number; position_rms_m?: number;
  ate_posyaw_m?: number; landmarks?: number; innovation_correlation?: number;
  band?: [number, number]; median?: Record<string, number>; seconds_inside_band?: number;
  runs?: number; diverged?: number; settings?: Record<string, unknown>;
}

/** Points of the map, relative to the study's origin; empty columns where there are none. */
export type Points = Record<Axis, Column>;

export interface Filter {
  label: string;
  figures: Figures;
  /** A colour of the palette, and which kind of line: see colourFilters(). */
  colour: string;
  line: number;
  estimate: Points;
  /** The landmarks as the filter estimates them. */
  landmarks: Points;
  curves: Columns;
}

export interface Study extends Subject {
  folder: string;
  summary: Record<string, unknown>;
  single: boolean;
  bands: Record<string, number>;
  origin: Vector;
  filters: Filter[];
  /** Which of the filters are drawn. */
  shown: boolean[];
  trials: Columns;
  truth: Points | null;
  /** The true ones. */
  landmarks: Points;
}

type RawColumns = Record<string, string>;
type RawFilter = RawColumns & { estimate?: unknown; landmarks?: unknown };
export interface RawStudy {
  folder: string; single_run: boolean; summary?: Record<string, unknown>;
  bands: Record<string, number>; origin: Vector; seconds: string; filters: RawFilter[];
  trials: RawColumns; truth?: RawColumns; landmarks?: RawColumns;
}

export const activeStudy = (): Study => activeSubject() as Study;

/** The figures of the study's filters as summary.json has them. */
export const figuresOf = (study: Study): Figures[] => study.filters.map((f) => f.figures);

export function decodeStudy(raw: RawStudy): Study {
  const summary = raw.summary ?? {}, t: Column = column(raw.seconds);
  const figures = (summary.filters ?? []) as Figures[];
  return {
    name: typeof summary.name === 'string' && summary.name ? summary.name : raw.folder,
    label: '', folder: raw.folder, summary, single: raw.single_run, bands: raw.bands,
    origin: raw.origin, count: t.length, t, health: new Int32Array(t.length), healthNames: ['ok'],
    filters: raw.filters.map((f, k) => decodeFilter(f, figures[k] ?? {}, k)),
    shown: raw.filters.map(() => true),
    trials: decodeColumns(raw.trials),
    truth: raw.truth ? decodePoints(raw.truth) : null,
    landmarks: decodePoints(raw.landmarks),
  };
}

const decodePoints = (raw: unknown): Points => ({ x: new Float32Array(), y: new Float32Array(),
  z: new Float32Array(), ...decodeColumns(raw as RawColumns | undefined) });

function decodeFilter({ name, estimate, landmarks, ...columns }: RawFilter, figures: Figures, k: number):
    Filter {
  const label = name.length > 60 ? `${k + 1}: ${name.slice(0, 56)}…` : name;
  return { label, figures, colour: '', line: 0, estimate: decodePoints(estimate),
    landmarks: decodePoints(landmarks), curves: decodeColumns(columns as RawColumns) };
}

/** Where Kleinert & Stilla's paper shows a scene. */
export interface PaperPlace { table: string; figure: number; scene: string }

const PAPER_PLACES: Record<string, PaperPlace> = {
  hallway: { table: 'I', figure: 2, scene: 'hallway' },
  turntable: { table: 'II', figure: 3, scene: 'cube' },
};

/** The shape of a simulated scene; '' without one. */
export function geometryOf({ summary }: Study): string {
  const { geometry } = (summary.scene ?? {}) as Record<string, unknown>;
  return typeof geometry === 'string' ? geometry : '';
}

/** The place of the study's scene in the paper; undefined for scenes that it does not have. */
export const paperPlace = (study: Study): PaperPlace | undefined => PAPER_PLACES[geometryOf(study)];

/** The title of a part of the paper's figure; without the letter where it is none of theirs. */
export const partTitle = (study: Study, letter: string, title: string): string =>
  (paperPlace(study) ? `(${letter}) ${title}` : title);

/** Short names, different for each. */
export function labelStudies(studies: Study[]): void {
  studies.forEach((study, k) => {
    const short = study.name.length > 40 ? study.name.slice(0, 39) + '…' : study.name;
    study.label = studies.length > 1 ? `${k + 1}: ${short}` : short;
  });
}
