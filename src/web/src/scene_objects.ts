// What stands in the 3-D scene: paths, cameras, the floor plan, the ground.
import { BufferGeometry, Float32BufferAttribute, Group, Line, LineBasicMaterial, LineSegments, type Matrix4,
  type Object3D } from 'three';

import { niceStep } from './canvas';
import type { Axis, Vector } from './data';
import type { Run } from './runs';
import type { Box } from './scene_view';
import { palette } from './theme';
import { widePath, wideSegments } from './wide_lines';

type Path = Record<Axis, ArrayLike<number>>;

/** A path is drawn no better with more points than about this many. */
const ENOUGH = 2000;

/** The points of a path that are at least `step` apart, finite ones alone. */
function thinned({ x, y, z }: Path, shift: Vector, step: number): number[] {
  const points: number[] = [];
  let [lastX, lastY, lastZ] = [Infinity, Infinity, Infinity];
  for (let i = 0; i < x.length; i++) {
    const [px, py, pz] = [x[i] + shift[0], y[i] + shift[1], z[i] + shift[2]];
    const far = !(Math.hypot(px - lastX, py - lastY, pz - lastZ) < step);
    if (!Number.isFinite(px + py + pz) || (!far && i + 1 < x.length)) continue;
    points.push(px, py, pz);
    [lastX, lastY, lastZ] = [px, py, pz];
  }
  // A way that crosses itself over and over.
  const stride = Math.ceil(points.length / (3 * ENOUGH));
  return stride > 1 ? points.filter((_, k) => Math.floor(k / 3) % stride === 0) : points;
}

/** A path one pixel wide: whole, and with every fourth point for a scene in motion. */
export class LongPath extends Group {
  constructor(points: number[], colour: string) {
    super();
    const few = points.filter((_, k) => Math.floor(k / 3) % 4 === 0);
    for (const list of [points, few]) {
      const geometry = new BufferGeometry();
      geometry.setAttribute('position', new Float32BufferAttribute(list, 3));
      this.add(new Line(geometry, new LineBasicMaterial({ color: palette[colour] })));
    }
  }

  setCoarse(coarse: boolean): void {
    const [whole, few] = this.children;
    whole.visible = !coarse;
    few.visible = coarse;
  }
}

/** `fine`: one pixel wide and whole, for a processor that has to draw a long way. */
export interface PathStyle { colour: string; width: number; dash?: number; shift?: Vector; fine?: boolean }

/** A line of that width [px] along the path; dash is the length of a stroke [m]. */
export function pathLine(path: Path, size: number, { colour, width, dash, shift, fine }:
    PathStyle):
    Object3D | null {
  const points = thinned(path, shift ?? [0, 0, 0], size / ENOUGH);
  if (points.length < 6) return null;
  if (fine) return new LongPath(points, colour);
  return widePath(points, { color: palette[colour], linewidth: width,
    ...(dash === undefined ? {} : { dashed: true, dashSize: dash, gapSize: 0.7 * dash }) });
}

/** Pieces of line between pairs of points, over whatever else is there. */
function segments(points: number[], color: string, linewidth: number): Object3D {
  const lines = wideSegments(points, { color, linewidth, depthTest: false });
  lines.renderOrder = 2;
  return lines;
}

/** Level rings of that radius [m]. */
export function rings(centres: Vector[], radius: number, colour: string): Object3D {
  const corners = 24, points: number[] = [];
  for (const [x, y, z] of centres) {
    for (let k = 0; k < corners; k++) {
      for (const at of [k, k + 1]) {
        const angle = (2 * Math.PI * at) / corners;
        points.push(x + radius * Math.cos(angle), y + radius * Math.sin(angle), z);
      }
    }
  }
  return segments(points, palette[colour], 2);
}

/** The body's axes, x red, y green, z blue, of that length [m]. */
export function bodyAxes(length: number): Object3D[] {
  return ['#d62a2a', '#1c9a36', '#2f5cf0'].map((colour, k) =>
    segments([0, 0, 0, ...[0, 1, 2].map((axis) => (axis === k ? length : 0))], colour, 2.6));
}

/** A camera as summary.json may state it. */
export interface Camera {
  imu_T_cam: number[][];
  intrinsics: [number, number, number, number];
  /** Where it is not stated, the principal point is taken for the middle. */
  resolution?: [number, number];
}

const isNumbers = (v: unknown, n: number): v is number[] =>
  Array.isArray(v) && v.length === n && v.every(Number.isFinite);

export function camerasOf(run: Run): Camera[] {
  const { cameras } = run.summary;
  return (Array.isArray(cameras) ? cameras as Partial<Camera>[] : []).filter((c): c is Camera =>
    isNumbers(c?.intrinsics, 4) && Array.isArray(c.imu_T_cam) &&
    c.imu_T_cam.length === 4 && c.imu_T_cam.every((row) => isNumbers(row, 4)));
}

/** What a camera sees to that depth [m], in the body's axes. Lens distortion is left out. */
export function frustum({ imu_T_cam: T, intrinsics: [fx, fy, cx, cy], resolution }: Camera,
    depth: number): Object3D {
  const [w, h] = resolution ?? [2 * cx, 2 * cy];
  const corner = (u: number, v: number) => [depth * (u - cx) / fx, depth * (v - cy) / fy, depth];
  const [a, b, c, d] = [corner(0, 0), corner(w, 0), corner(w, h), corner(0, h)], o = [0, 0, 0];
  const up = corner(w / 2, -0.12 * h);
  const pairs = [o, a, o, b, o, c, o, d, a, b, b, c, c, d, d, a, a, up, up, b];
  const object = segments(pairs.flat(), palette.cursor, 1.6);
  object.matrix.set(...T.flat() as Parameters<Matrix4['set']>);
  object.matrixAutoUpdate = false;
  return object;
}

/** The lines of a floor plan at a height, which NaN ends; pieces no longer than `piece`: long ones
 *  that pass behind the camera are not drawn by every driver. */
export function planLines({ x, y }: Pick<Path, 'x' | 'y'>, z: number, piece: number, colour: string,
    width: number): Object3D {
  const points: number[] = [];
  for (let i = 0; i + 1 < x.length; i++) {
    const [dx, dy] = [x[i + 1] - x[i], y[i + 1] - y[i]], length = Math.hypot(dx, dy);
    if (!Number.isFinite(length)) continue;
    const n = Math.max(1, Math.ceil(length / piece));
    for (let k = 0; k < n; k++) {
      points.push(x[i] + (dx * k) / n, y[i] + (dy * k) / n, z,
        x[i] + (dx * (k + 1)) / n, y[i] + (dy * (k + 1)) / n, z);
    }
  }
  return wideSegments(points, { color: palette[colour], linewidth: width });
}

/** A grid on the ground below a box; the distance of its lines [m] is returned too. A piece of
 *  line a cell: long ones that pass behind the camera are not drawn by every driver. */
export function groundGrid(size: number, { low, high }: Box, z: number): [Object3D, number] {
  const x = 0.5 * (low.x + high.x), y = 0.5 * (low.y + high.y);
  const step = niceStep(2 * size, 16), half = Math.ceil(1.3 * size / step);
  const [x0, y0] = [Math.round(x / step), Math.round(y / step)], points: number[] = [];
  for (let i = -half; i <= half; i++) {
    for (let k = -half; k < half; k++) {
      const along = [k * step, (k + 1) * step], at = i * step;
      points.push(at, along[0], 0, at, along[1], 0, along[0], at, 0, along[1], at, 0);
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new Float32BufferAttribute(points, 3));
  const grid = new LineSegments(geometry, new LineBasicMaterial({ color: palette.line }));
  grid.position.set(x0 * step, y0 * step, z);
  return [grid, step];
}
