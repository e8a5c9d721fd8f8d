// The run in three dimensions: what is drawn, from where, and how it answers.
import { ColorManagement, Group, type InstancedMesh, LinearSRGBColorSpace, Matrix4, Mesh, type Object3D,
  PerspectiveCamera, Quaternion, Scene, Vector3, WebGLRenderer } from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';

import { type Axis, clamp, type Columns, extremes, quantile, type Vector } from './data';
import { byId, number } from './format';
import { landmarkShown, showLandmarkTip } from './map';
import { estimateColour, type MapOptions } from './map_draw';
import { nearestOnScreen } from './map_input';
import { landmarkScale } from './map_view';
import { activeRun, type Run, truthColumns } from './runs';
import { LandmarkDots } from './scene_landmarks';
import { bodyAxes, camerasOf, ellipsoidMatrix, ellipsoids, frustum, groundGrid, nearestRows, pathLine }
  from './scene_objects';
import { app, listen, setCursor, throttled } from './store';

/** States of a run that is long. */
const MANY = 20000;
const MOST_ELLIPSOIDS = { auto: 80, always: 2000, never: 0 } as Record<string, number>;

/** How the browser draws in three dimensions, if at all. */
function drawing(): 'none' | 'processor' | 'graphics card' {
  const gl = document.createElement('canvas').getContext('webgl2');
  if (!gl) return 'none';
  const told = gl.getExtension('WEBGL_debug_renderer_info');
  const name = String(told ? gl.getParameter(told.UNMASKED_RENDERER_WEBGL) : '');
  gl.getExtension('WEBGL_lose_context')?.loseContext();
  return /SwiftShader|llvmpipe|software/i.test(name) ? 'processor' : 'graphics card';
}

const DRAWING = drawing();
export const canDraw = (): boolean => DRAWING !== 'none';
/** Smooth edges cost a processor four times the work. */
const SMOOTH = DRAWING === 'graphics card';

// The colours of the page as they are: there is no light to mix.
ColorManagement.enabled = false;

const pathOf = ({ x, y, z }: Columns): Record<Axis, ArrayLike<number>> => ({ x, y, z });

export class ScenePanel {
  readonly canvas = byId<HTMLCanvasElement>('scene');
  readonly draw = throttled(() => this.drawNow());
  private readonly renderer = new WebGLRenderer({ canvas: this.canvas, antialias: SMOOTH, alpha: true });
  private readonly camera = new PerspectiveCamera(50, 1, 0.01, 1e5);
  private readonly controls: OrbitControls;
  private readonly scene = new Scene();
  private content = new Group();
  private body = new Group();
  private marks: InstancedMesh | null = null;
  private dots: LandmarkDots | null = null;
  private pose: InstancedMesh | null = null;
  private low = new Vector3();
  private high = new Vector3();
  private centre = new Vector3();
  private size = 1;
  private view = 'orbit';
  /** Somebody has turned, moved or zoomed the view since it was fitted. */
  private moved = false;
  /** The run has grown while the scene was not shown. */
  private outdated = false;
  /** What was drawn before: its shaders serve what is drawn in its place, so it goes after that. */
  private old: Group[] = [];
  private heading = new Vector3(1, 0, 0);

  constructor(private readonly options: MapOptions, private readonly hint: () => void) {
    this.renderer.outputColorSpace = LinearSRGBColorSpace;
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.addEventListener('change', this.draw);
    this.controls.addEventListener('start', () => { this.moved = true; });
    this.controls.enableZoom = false;
    this.listenToInput();
    listen('run', () => { this.measureRun(); this.build(); this.fit(); });
    listen('rows', () => this.growRun());
    for (const kind of ['theme', 'shown'] as const) listen(kind, () => { this.build(); this.draw(); });
    listen('cursor', () => { if (this.visible()) { this.moveBody(); this.draw(); } });
    new ResizeObserver(() => { this.resize(); this.draw(); }).observe(this.canvas);
  }

  private visible(): boolean {
    return this.canvas.clientWidth > 0 && app.subjects.length > 0;
  }

  /** A view that shows everything goes on to do so. */
  private growRun(): void {
    this.outdated = !this.visible();
    if (this.outdated) return;
    this.measureRun();
    this.build();
    if (!this.moved && this.view !== 'follow') this.fit();
    this.draw();
  }

  setView(view: string): void {
    this.view = view;
    if (this.outdated) this.growRun();
    this.controls.enableRotate = view === 'orbit';
    this.controls.enabled = view !== 'follow';
    this.resize();
    this.moveBody();
    this.fit();
  }

  /** The box of the path and of the landmarks about it, its middle and half its diameter. */
  private measureRun(): void {
    const run = activeRun(), { low, high } = this;
    const spans = (['x', 'y', 'z'] as const).map((axis) => extremes(run.states[axis]));
    const far = 0.5 * Math.hypot(...spans.map(([a, b]) => Math.max(0, b - a)));
    (['x', 'y', 'z'] as const).forEach((axis, k) => {
      const [a, b] = spans[k], marks = run.landmarks[axis];
      const ends = [a, b, Math.max(a - far, quantile(marks, 0.05)),
        Math.min(b + far, quantile(marks, 0.95))].filter(Number.isFinite);
      low.setComponent(k, ends.length ? Math.min(...ends) : -1);
      high.setComponent(k, ends.length ? Math.max(...ends) : 1);
    });
    this.centre = low.clone().add(high).multiplyScalar(0.5);
    this.size = Math.max(0.5 * high.distanceTo(low), 0.5);
  }

  private clear(): void {
    for (const group of this.old.splice(0)) {
      group.traverse((object) => {
        if (!(object instanceof Mesh) && !('geometry' in object)) return;
        const { geometry, material } = object as Mesh;
        geometry.dispose();
        for (const m of [material].flat()) m.dispose();
      });
    }
  }

  private build(): void {
    if (!app.subjects.length) return;
    this.clear();
    this.scene.remove(this.content, this.body);
    this.old.push(this.content, this.body);
    const run = activeRun();
    const objects: (Object3D | null)[] = [this.ground(run)];
    this.dots = this.marks = null;
    if (run.landmarks.id.length) {
      this.dots = new LandmarkDots(run, this.options);
      this.marks = ellipsoids(MOST_ELLIPSOIDS[this.options.ellipses], 'landmark', 0.16);
      objects.push(this.dots.group, this.marks);
    }
    objects.push(...this.paths(run));
    this.content = new Group();
    this.content.add(...objects.filter((o) => o !== null));
    this.body = this.buildBody(run);
    this.scene.add(this.content, this.body);
    this.moveBody();
  }

  private paths(run: Run): (Object3D | null)[] {
    const { show } = this.options, dash = this.size / 40;
    const fine = !SMOOTH && run.count > MANY;
    const others = (app.subjects as Run[]).map((other, k) => {
      if (k === app.active || !show[`run-${k}`]) return null;
      const shift = other.origin.map((o, i) => o - run.origin[i]) as Vector;
      return pathLine(pathOf(other.states), this.size, { colour: other.colour, width: 1.8, shift, fine });
    });
    return [...others,
      show.dead && run.deadReckoning ? pathLine(pathOf(run.deadReckoning), this.size,
        { colour: 'dead', width: 1.6, dash: dash / 4, fine }) : null,
      show.truth && run.truth ? pathLine(truthColumns(run, this.options.truth), this.size,
        { colour: 'truth', width: 2, dash, fine }) : null,
      show.estimate ? pathLine(pathOf(run.states), this.size,
        { colour: estimateColour(), width: 3, fine }) : null];
  }

  /** A grid below the path: at the height of the lowest landmarks about it, where there are any. */
  private ground(run: Run): Object3D {
    const [lowest] = extremes(run.states.z), marks = quantile(run.landmarks.z, 0.03);
    const floor = Number.isFinite(lowest) ? lowest : 0;
    const z = Number.isFinite(marks) ? clamp(marks, floor - 0.3 * this.size, floor) : floor;
    const [grid, step] = groundGrid(this.size, this.centre.x, this.centre.y, z);
    byId('scene-note').textContent = `grid: ${number(step)} m${this.colourNote(run)}`;
    return grid;
  }

  /** What the colours of the landmarks mean. */
  private colourNote(run: Run): string {
    const { colour, show } = this.options;
    if (colour === 'plain' || !(show.view || show.retired) || !run.landmarks.id.length) return '';
    const [low, high] = landmarkScale(run.landmarks, run.origin[2], colour).range;
    return `, landmarks: ${colour === 'height' ? 'z' : 'σ'} ${number(low, 2)} m dark to ` +
      `${number(high, 2)} m bright`;
  }

  private buildBody(run: Run): Group {
    const body = new Group(), reach = clamp(this.size / 9, 0.15, 6);
    body.add(...bodyAxes(0.6 * reach));
    for (const camera of camerasOf(run)) body.add(frustum(camera, reach));
    // Not turned with the body: the covariance is in the axes of the world.
    this.pose = ellipsoids(1, 'cursor', 0.3);
    this.content.add(this.pose);
    return body;
  }

  /** Puts the body, and the ellipsoids about it, to where the cursor is. */
  private moveBody(): void {
    const { states: s, count, landmarks, t } = activeRun(), i = app.cursor;
    this.dots?.setTime(t[i]);
    this.body.visible = count > 0 && Number.isFinite(s.x[i] + s.y[i] + s.z[i] + s.qw[i]);
    if (!this.body.visible) return;
    this.body.position.set(s.x[i], s.y[i], s.z[i]);
    this.body.quaternion.set(s.qx[i], s.qy[i], s.qz[i], s.qw[i]);
    const matrix = new Matrix4();
    if (this.pose) {
      this.pose.count = 1;
      this.pose.setMatrixAt(0, ellipsoidMatrix(s, i, matrix));
      this.pose.instanceMatrix.needsUpdate = true;
    }
    if (this.marks) {
      const room = MOST_ELLIPSOIDS[this.options.ellipses];
      const rows = room ? nearestRows(pathOf(landmarks), [s.x[i], s.y[i], s.z[i]], room) : [];
      // One that is as large as the scene would hide all others.
      const drawn = rows.filter((k) => landmarks.cxx[k] + landmarks.cyy[k] + landmarks.czz[k] <
        this.size ** 2 / 64 && landmarkShown(this.options, k));
      drawn.forEach((k, at) => this.marks?.setMatrixAt(at, ellipsoidMatrix(landmarks, k, matrix)));
      this.marks.count = drawn.length;
      this.marks.instanceMatrix.needsUpdate = true;
    }
    if (this.view === 'follow') this.follow();
  }

  /** Behind the body and above it, looking where it goes. */
  private follow(): void {
    const { states: s, t, count } = activeRun(), i = app.cursor;
    let [from, to] = [i, i];
    while (from > 0 && t[i] - t[from] < 0.6) from--;
    while (to + 1 < count && t[to] - t[i] < 0.6) to++;
    const way = new Vector3(s.x[to] - s.x[from], s.y[to] - s.y[from], 0);
    if (way.length() > 0.02) this.heading.lerp(way.normalize(), 0.25).normalize();
    const reach = clamp(this.size / 3, 1, 14), place = this.body.position;
    this.controls.target.copy(place).addScaledVector(this.heading, 0.6 * reach);
    this.camera.position.copy(place).addScaledVector(this.heading, -reach);
    this.camera.position.z += 0.55 * reach;
    this.camera.lookAt(this.controls.target);
  }

  /** Shows everything, from where the view is. */
  fit(): void {
    const { camera, controls, size } = this;
    this.moved = false;
    this.resize();
    camera.near = size / 200;
    camera.far = 60 * size;
    camera.updateProjectionMatrix();
    if (this.view === 'follow') {
      this.follow();
    } else {
      const from = this.view === 'above' ? [0, -1e-4, 1] : [-0.35, -0.72, 0.6];
      this.lookFrom(new Vector3(...from).normalize());
      controls.update();
    }
    this.draw();
  }

  /** Looks from that direction, so near that the box of the run just fits. */
  private lookFrom(direction: Vector3): void {
    const { camera, controls: { target }, low, high } = this;
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((k) => new Vector3(
      k & 1 ? high.x : low.x, k & 2 ? high.y : low.y, k & 4 ? high.z : low.z));
    let distance = 4 * this.size;
    target.copy(this.centre);
    for (let round = 0; round < 6; round++) {
      camera.position.copy(target).addScaledVector(direction, distance);
      camera.lookAt(target);
      camera.updateMatrixWorld();
      const reach = corners.map((c) => c.clone().project(camera));
      distance *= Math.max(...reach.map((p) => Math.max(Math.abs(p.x), Math.abs(p.y)))) / 0.86;
    }
    camera.position.copy(target).addScaledVector(direction, distance);
  }

  zoom(factor: number): void {
    const { target } = this.controls;
    this.moved = true;
    this.camera.position.sub(target).divideScalar(factor).add(target);
    this.camera.lookAt(target);
    this.draw();
  }

  /** Turns the view about its target [rad]: around the vertical, and up or down. */
  private turn(around: number, up: number): void {
    const offset = this.camera.position.clone().sub(this.controls.target);
    this.moved = true;
    offset.applyAxisAngle(new Vector3(0, 0, 1), around);
    const side = new Vector3().crossVectors(new Vector3(0, 0, 1), offset).normalize();
    const tilted = offset.clone().applyQuaternion(new Quaternion().setFromAxisAngle(side, -up));
    const steep = Math.abs(tilted.z) / tilted.length() > 0.998;
    this.camera.position.copy(this.controls.target).add(steep ? offset : tilted);
    this.controls.update();
    this.draw();
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width || !height) return;
    this.renderer.setPixelRatio(SMOOTH ? Math.min(window.devicePixelRatio || 1, 2) : 1);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
  }

  drawNow(): void {
    if (!this.visible()) return;
    this.renderer.render(this.scene, this.camera);
    this.clear();
    const run = activeRun();
    this.canvas.setAttribute('aria-label', `The run in three dimensions: ${run.count} estimated ` +
      `poses and ${run.landmarks.id.length} landmarks. Arrow keys turn it.`);
  }

  private listenToInput(): void {
    const { canvas } = this;
    // The wheel scrolls the page until the scene has been clicked.
    canvas.addEventListener('focus', () => { this.controls.enableZoom = true; });
    canvas.addEventListener('blur', () => { this.controls.enableZoom = false; });
    canvas.addEventListener('wheel', () => { if (!this.controls.enableZoom) this.hint(); },
      { passive: true });
    canvas.addEventListener('pointerdown', () => canvas.focus({ preventScroll: true }));
    canvas.addEventListener('keydown', (e) => this.key(e));
    let place: { x: number; y: number } | null = null;
    const point = throttled(() => { if (place) this.point(place); });
    canvas.addEventListener('pointermove', (e) => {
      place = e.buttons ? null : { x: e.offsetX, y: e.offsetY };
      if (place) point(); else byId('map-tip').hidden = true;
    });
    canvas.addEventListener('pointerleave', () => {
      place = null;
      byId('map-tip').hidden = true;
    });
  }

  private key(e: KeyboardEvent): void {
    const angle = e.shiftKey ? 0.4 : 0.1;
    const actions: Record<string, () => void> = {
      ArrowLeft: () => this.turn(-angle, 0), ArrowRight: () => this.turn(angle, 0),
      ArrowUp: () => this.turn(0, angle), ArrowDown: () => this.turn(0, -angle),
      '+': () => this.zoom(1.25), '=': () => this.zoom(1.25), '-': () => this.zoom(0.8),
      0: () => this.fit(),
      '[': () => setCursor(app.cursor - 1), ']': () => setCursor(app.cursor + 1),
    };
    const action = actions[e.key];
    if (!action || e.ctrlKey || e.metaKey || e.altKey) return;
    e.preventDefault();
    action();
  }

  /** Where a row of columns is on the screen; far away where it is behind the view. */
  private onScreen(columns: Columns): (i: number) => [number, number] {
    const { clientWidth: width, clientHeight: height } = this.canvas, p = new Vector3();
    const project = this.camera.projectionMatrix.clone().multiply(this.camera.matrixWorldInverse);
    return (i) => {
      p.set(columns.x[i], columns.y[i], columns.z[i]).applyMatrix4(project);
      return p.z > 1 ? [-1e9, -1e9] : [0.5 * (p.x + 1) * width, 0.5 * (1 - p.y) * height];
    };
  }

  /** A landmark tells its numbers, the estimate takes the time cursor. */
  private point(place: { x: number; y: number }): void {
    const run = activeRun(), mark = this.onScreen(run.landmarks);
    const shown = (i: number): [number, number] =>
      (landmarkShown(this.options, i) ? mark(i) : [-1e9, -1e9]);
    const found = nearestOnScreen(run.landmarks.id.length, shown, place, 6);
    if (found >= 0) {
      showLandmarkTip(found, ...mark(found), this.canvas.clientWidth, this.canvas.clientHeight);
      return;
    }
    byId('map-tip').hidden = true;
    if (this.view === 'follow') return;
    const state = nearestOnScreen(run.count, this.onScreen(run.states), place, 10);
    if (state >= 0) setCursor(state);
  }
}
