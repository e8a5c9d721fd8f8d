// The 95 % ellipsoids of the scene: of the pose at the cursor, and of the landmarks nearest to it.
import { DynamicDrawUsage, InstancedMesh, Matrix4, MeshBasicMaterial, SphereGeometry } from 'three';

import type { Columns, Vector } from './data';
import { landmarkShown } from './map';
import type { MapOptions } from './map_draw';
import type { Screen } from './scene_view';
import { palette } from './theme';

/** The 95 % quantile of chi-square with three degrees of freedom. */
const CHI2_3 = 7.815;
const MOST = { auto: 80, always: 2000, never: 0 } as Record<string, number>;
/** Half of a landmark's dot [px]: a smaller ellipsoid is hidden by it. */
const HIDDEN = 1.5;
/** An ellipsoid that reaches less far [px] looks round with few triangles; in motion, a larger one. */
const SMALL = 10, SMALL_IN_MOTION = 18;
/** The share of the screen that a processor fills with ellipsoids of a scene in motion. */
const FILLED = 0.8;

/** Maps the unit sphere to the 95 % ellipsoid about row i: the Cholesky factor of its covariance. */
export function ellipsoidMatrix(c: Columns, i: number, out: Matrix4): Matrix4 {
  const root = (v: number) => Math.sqrt(Math.max(v, 1e-12));
  const a = root(c.cxx[i]), b = c.cxy[i] / a, d = c.cxz[i] / a;
  const e = root(c.cyy[i] - b * b), f = (c.cyz[i] - b * d) / e;
  const g = root(c.czz[i] - d * d - f * f), k = Math.sqrt(CHI2_3);
  return out.set(k * a, 0, 0, c.x[i], k * b, k * e, 0, c.y[i], k * d, k * f, k * g, c.z[i],
    0, 0, 0, 1);
}

/** Room for that many ellipsoids, of so many meridians. */
export function ellipsoids(room: number, colour: string, opacity: number, meridians = 16):
    InstancedMesh {
  const mesh = new InstancedMesh(new SphereGeometry(1, meridians, meridians / 2),
    new MeshBasicMaterial({ color: palette[colour], transparent: true, opacity, depthWrite: false }),
    room);
  mesh.instanceMatrix.setUsage(DynamicDrawUsage);
  mesh.frustumCulled = false;
  mesh.count = 0;
  return mesh;
}

/** The k-th smallest of the numbers, which are put into another order (Hoare's selection). */
function smallest(numbers: Float32Array, k: number): number {
  for (let low = 0, high = numbers.length - 1; low < high;) {
    const pivot = numbers[(low + high) >> 1];
    let [i, j] = [low, high];
    while (i <= j) {
      while (numbers[i] < pivot) i++;
      while (numbers[j] > pivot) j--;
      if (i > j) break;
      const held = numbers[i];
      numbers[i++] = numbers[j];
      numbers[j--] = held;
    }
    if (k <= j) high = j;
    else if (k >= i) low = i;
    else break;
  }
  return numbers[k];
}

/** The rows of the `count` landmarks that are nearest to a place, the nearest first. */
function nearestRows({ x, y, z }: Columns, [px, py, pz]: Vector, count: number): number[] {
  const distance = new Float32Array(x.length);
  for (let i = 0; i < x.length; i++) {
    const dx = x[i] - px, dy = y[i] - py, dz = z[i] - pz;
    distance[i] = dx * dx + dy * dy + dz * dz;
  }
  const limit = distance.length > count ? smallest(distance.slice(), count - 1) : Infinity;
  const rows: number[] = [];
  for (let i = 0; i < distance.length && rows.length < count; i++) {
    if (distance[i] <= limit) rows.push(i);
  }
  return rows.sort((a, b) => distance[a] - distance[b]);
}

/** Those of the landmarks that are nearest to the body: large ones and small ones. */
export class LandmarkEllipsoids {
  readonly meshes: [InstancedMesh, InstancedMesh];
  private rows: number[] = [];
  private readonly matrix = new Matrix4();

  constructor(private readonly landmarks: Columns, private readonly options: MapOptions) {
    const room = Math.min(MOST[options.ellipses], landmarks.id.length);
    this.meshes = [ellipsoids(room, 'landmark', 0.16), ellipsoids(room, 'landmark', 0.16, 8)];
  }

  /** Chooses those about a place that are shown at the cursor's time. One that is as large as the
   *  scene, of that size [m], would hide all others. */
  setPlace(place: Vector, size: number): void {
    const { landmarks: m, options } = this, room = MOST[options.ellipses];
    this.rows = (room ? nearestRows(m, place, room) : []).filter((k) =>
      m.cxx[k] + m.cyy[k] + m.czz[k] < size ** 2 / 64 && landmarkShown(options, k));
  }

  /** Draws of them those that look out from behind their dots; coarsely, the nearest ones that fill
   *  no more than a share of the screen. */
  arrange(screen: Screen, coarse: boolean): void {
    const { landmarks: m } = this, [large, small] = this.meshes;
    const all = screen.width * screen.height;
    let room = coarse ? FILLED * all : Infinity;
    large.count = small.count = 0;
    for (const k of this.rows) {
      const reach = Math.sqrt(CHI2_3 * (m.cxx[k] + m.cyy[k] + m.czz[k]));
      const pixels = reachOnScreen(screen, m.x[k], m.y[k], m.z[k], reach);
      if (pixels < HIDDEN) continue;
      room -= Math.min(Math.PI * pixels ** 2, all);
      if (room < 0) break;
      const mesh = pixels < (coarse ? SMALL_IN_MOTION : SMALL) ? small : large;
      mesh.setMatrixAt(mesh.count++, ellipsoidMatrix(m, k, this.matrix));
    }
    large.instanceMatrix.needsUpdate = small.instanceMatrix.needsUpdate = true;
  }
}

/** How many pixels a ball of the radius `reach` [m] reaches from its middle: 0 where it is beside the
 *  screen, infinitely many where the eye is in it. */
function reachOnScreen({ clip_T_world: clip, width, height, spread }: Screen, x: number, y: number,
    z: number, reach: number): number {
  const e = clip.elements, depth = e[3] * x + e[7] * y + e[11] * z + e[15];
  if (depth <= reach) return depth < -reach ? 0 : Infinity;
  // Its near side looks larger than its middle shows.
  const pixels = reach * 0.5 * height * spread / (depth - reach);
  const right = 0.5 * width * (e[0] * x + e[4] * y + e[8] * z + e[12]) / depth;
  const up = 0.5 * height * (e[1] * x + e[5] * y + e[9] * z + e[13]) / depth;
  const beside = Math.abs(right) - pixels > 0.5 * width || Math.abs(up) - pixels > 0.5 * height;
  return beside ? 0 : pixels;
}
