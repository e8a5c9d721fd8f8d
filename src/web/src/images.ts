// What the cameras saw, as the run has kept it: pictures, points, and what became of those.
import { clamp, type Column, type Columns, column, decodeColumns, extremes, nearestIndex } from './data';

export const OUTCOMES = ['waiting', 'begun', 'used', 'rejected'] as const;
export type Outcome = (typeof OUTCOMES)[number];

interface RawImages {
  width: number; height: number; camera: number; jpeg: string[];
  [columns: string]: unknown;
}

/** A point in a picture; places in the camera's own pixels. */
export interface Point {
  id: number;
  age: number;
  outcome: Outcome;
  u: number;
  v: number;
  /** Where it was some frames before. */
  before: [number, number] | null;
  /** Where the filter expected it, and how uncertain that is [px^2]. */
  expected: { u: number; v: number; uu: number; uv: number; vv: number } | null;
}

export class CameraImages {
  readonly camera: number;
  readonly width: number;
  readonly height: number;
  readonly t: Column;
  readonly jpeg: string[];
  private readonly first: number[] = [0];
  private readonly points: Columns;

  constructor({ camera, width, height, jpeg, t, count, ...columns }: RawImages) {
    this.camera = camera;
    this.jpeg = jpeg;
    this.t = column(t as string);
    for (const n of column(count as string)) this.first.push(this.first[this.first.length - 1] + n);
    this.points = decodeColumns(columns as Record<string, string>);
    // A camera that does not state its size is as large as what it shows.
    this.width = width || Math.max(1, extremes(this.points.u)[1]) / 10;
    this.height = height || Math.max(1, extremes(this.points.v)[1]) / 10;
  }

  /** The frame nearest to a time. */
  nearest(t: number): number {
    return nearestIndex(this.t, t);
  }

  frame(k: number): Point[] {
    const [from, to] = [this.first[k], this.first[k + 1]];
    return Array.from({ length: to - from }, (_, i) => this.point(from + i));
  }

  private point(i: number): Point {
    const c = this.points, [u, v] = [c.u[i] / 10, c.v[i] / 10];
    const [su, sv] = [c.sigma_u[i] / 100, c.sigma_v[i] / 100];
    return {
      id: c.id[i], age: c.age[i], outcome: OUTCOMES[clamp(c.outcome[i], 0, 3)], u, v,
      before: c.before_u[i] || c.before_v[i]
        ? [u + c.before_u[i] / 100, v + c.before_v[i] / 100] : null,
      expected: su > 0 && sv > 0 ? { u: u + c.expected_u[i] / 100, v: v + c.expected_v[i] / 100,
        uu: su * su, uv: su * sv * c.correlation[i] / 100, vv: sv * sv } : null,
    };
  }
}

export const decodeImages = (raw: unknown): CameraImages[] =>
  (Array.isArray(raw) ? raw as RawImages[] : []).map((camera) => new CameraImages(camera));

/** How far the point is from where it was expected, in sigmas (Mahalanobis). */
export function sigmasAway({ u, v, expected: e }: Point): number {
  if (!e) return NaN;
  const [du, dv] = [u - e.u, v - e.v], det = e.uu * e.vv - e.uv * e.uv;
  return Math.sqrt((e.vv * du * du - 2 * e.uv * du * dv + e.uu * dv * dv) / det);
}

const MOST_PICTURES = 40;  // decoded, at a time

/** Pictures as they are drawn: each is decoded when it is first asked for. */
export class Pictures {
  private readonly decoded = new Map<string, ImageBitmap | 'coming' | 'none'>();

  /** `ready` is called once there is one that there was not yet. */
  constructor(private readonly ready: () => void) {}

  /** Null: there is none; undefined: it is on its way. */
  get(images: CameraImages, k: number): ImageBitmap | null | undefined {
    const base64 = images.jpeg[k];
    if (!base64) return null;
    const found = this.decoded.get(base64);
    if (!found) this.decode(base64);
    if (found === 'none') return null;
    return found === 'coming' ? undefined : found;
  }

  private decode(base64: string): void {
    this.decoded.set(base64, 'coming');
    const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
    createImageBitmap(new Blob([bytes], { type: 'image/jpeg' }))
      .then((bitmap) => this.decoded.set(base64, bitmap), () => this.decoded.set(base64, 'none'))
      .then(() => { this.discard(); this.ready(); });
  }

  /** The oldest. */
  private discard(): void {
    for (const [key, picture] of this.decoded) {
      if (this.decoded.size <= MOST_PICTURES) return;
      if (picture instanceof ImageBitmap) picture.close();
      this.decoded.delete(key);
    }
  }
}
