// From where the scene is seen: orbit, from above, or behind the body.
import { type Matrix4, PerspectiveCamera, Quaternion, Vector3 } from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';

import { AXES, clamp, type Columns, extremes, quantile } from './data';
import type { Run } from './runs';
import { marksBox } from './saved_map';

/** What of a run is to be seen [m]. */
export interface Box { low: Vector3; high: Vector3 }

/** The box of a run's path, of the landmarks about it, and of the map in which it found its place. */
export function boxOf({ states, landmarks, savedMap }: Run): Box {
  const box: Box = { low: new Vector3(), high: new Vector3() };
  const spans = AXES.map((axis) => extremes(states[axis]));
  const far = 0.5 * Math.hypot(...spans.map(([a, b]) => Math.max(0, b - a)));
  const saved = savedMap ? marksBox(savedMap) : null;
  AXES.forEach((axis, k) => {
    const [a, b] = spans[k], marks = landmarks[axis];
    const ends = [a, b, Math.max(a - far, quantile(marks, 0.05)),
      Math.min(b + far, quantile(marks, 0.95)), ...(saved?.[axis] ?? [])].filter(Number.isFinite);
    box.low.setComponent(k, ends.length ? Math.min(...ends) : -1);
    box.high.setComponent(k, ends.length ? Math.max(...ends) : 1);
  });
  return box;
}

/** Half its diameter. */
export const sizeOf = ({ low, high }: Box): number => Math.max(0.5 * high.distanceTo(low), 0.5);

/** How the world is seen: to clip coordinates, on a canvas of that size [px]. At the depth d a metre
 *  takes spread / d of half its height. */
export interface Screen { clip_T_world: Matrix4; width: number; height: number; spread: number }

const UP = new Vector3(0, 0, 1);

export class SceneView {
  readonly camera = new PerspectiveCamera(50, 1, 0.01, 1e5);
  private readonly controls: OrbitControls;
  private kind = 'orbit';
  /** Somebody has turned, moved or zoomed the view since it was fitted. */
  private moved = false;
  private heading = new Vector3(1, 0, 0);

  constructor(canvas: HTMLCanvasElement, private readonly changed: () => void) {
    this.camera.up.copy(UP);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener('change', changed);
    this.controls.addEventListener('start', () => { this.moved = true; });
    this.controls.enableZoom = false;
    // The wheel scrolls the page until the scene has been clicked.
    canvas.addEventListener('focus', () => { this.controls.enableZoom = true; });
    canvas.addEventListener('blur', () => { this.controls.enableZoom = false; });
  }

  choose(kind: string): void {
    this.kind = kind;
    this.controls.enableRotate = kind === 'orbit';
    this.controls.enabled = kind !== 'follow';
  }

  follows(): boolean {
    return this.kind === 'follow';
  }

  /** It shows what fit() made it show. */
  atFit(): boolean {
    return !this.moved && !this.follows();
  }

  wheelZooms(): boolean {
    return this.controls.enableZoom;
  }

  setShape(width: number, height: number): void {
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
  }

  /** Shows everything; what follows the body stays behind it. */
  fit(box: Box): void {
    const { camera, controls } = this, size = sizeOf(box);
    this.moved = false;
    camera.near = size / 200;
    camera.far = 60 * size;
    camera.updateProjectionMatrix();
    if (this.follows()) return;
    const from = this.kind === 'above' ? [0, -1e-4, 1] : [-0.35, -0.72, 0.6];
    this.viewFrom(new Vector3(...from).normalize(), box);
    controls.update();
  }

  /** Looks from that direction, so near that the box just fits. */
  private viewFrom(direction: Vector3, { low, high }: Box): void {
    const { camera, controls: { target } } = this;
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((k) => new Vector3(
      k & 1 ? high.x : low.x, k & 2 ? high.y : low.y, k & 4 ? high.z : low.z));
    let distance = 4 * sizeOf({ low, high });
    target.copy(low).add(high).multiplyScalar(0.5);
    for (let round = 0; round < 6; round++) {
      camera.position.copy(target).addScaledVector(direction, distance);
      camera.lookAt(target);
      camera.updateMatrixWorld();
      const reach = corners.map((c) => c.clone().project(camera));
      distance *= Math.max(...reach.map((p) => Math.max(Math.abs(p.x), Math.abs(p.y)))) / 0.86;
    }
    camera.position.copy(target).addScaledVector(direction, distance);
  }

  /** Behind the body at row i and above it, looking where it goes. */
  follow(s: Columns, t: ArrayLike<number>, i: number, size: number): void {
    let [from, to] = [i, i];
    while (from > 0 && t[i] - t[from] < 0.6) from--;
    while (to + 1 < s.x.length && t[to] - t[i] < 0.6) to++;
    const place = new Vector3(s.x[i], s.y[i], s.z[i]);
    if (!Number.isFinite(place.x + place.y + place.z)) return;
    const way = new Vector3(s.x[to] - s.x[from], s.y[to] - s.y[from], 0);
    if (way.length() > 0.02) this.heading.lerp(way.normalize(), 0.25).normalize();
    const reach = clamp(size / 3, 1, 14);
    this.controls.target.copy(place).addScaledVector(this.heading, 0.6 * reach);
    this.camera.position.copy(place).addScaledVector(this.heading, -reach);
    this.camera.position.z += 0.55 * reach;
    this.camera.lookAt(this.controls.target);
  }

  zoom(factor: number): void {
    const { target } = this.controls;
    this.moved = true;
    this.camera.position.sub(target).divideScalar(factor).add(target);
    this.camera.lookAt(target);
    this.changed();
  }

  /** Turns about the target [rad]: around the vertical, and up or down. */
  turn(around: number, up: number): void {
    const offset = this.camera.position.clone().sub(this.controls.target);
    this.moved = true;
    offset.applyAxisAngle(UP, around);
    const side = new Vector3().crossVectors(UP, offset).normalize();
    const tilted = offset.clone().applyQuaternion(new Quaternion().setFromAxisAngle(side, -up));
    const steep = Math.abs(tilted.z) / tilted.length() > 0.998;
    this.camera.position.copy(this.controls.target).add(steep ? offset : tilted);
    this.controls.update();
    this.changed();
  }

  private clip_T_world(): Matrix4 {
    return this.camera.projectionMatrix.clone().multiply(this.camera.matrixWorldInverse);
  }

  screen(width: number, height: number): Screen {
    this.camera.updateMatrixWorld();
    return { clip_T_world: this.clip_T_world(), width, height,
      spread: this.camera.projectionMatrix.elements[5] };
  }

  /** Where a row of columns is on a canvas of that size; far away where it is behind the view. */
  onScreen({ x, y, z }: Columns, width: number, height: number): (i: number) => [number, number] {
    const project = this.clip_T_world();
    const p = new Vector3();
    return (i) => {
      p.set(x[i], y[i], z[i]).applyMatrix4(project);
      return p.z > 1 ? [-1e9, -1e9] : [0.5 * (p.x + 1) * width, 0.5 * (1 - p.y) * height];
    };
  }
}
