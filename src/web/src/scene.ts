// The run in three dimensions: what is drawn, and how it answers.
import { ColorManagement, LinearSRGBColorSpace, Scene, Vector3, WebGLRenderer } from 'three';

import { closuresOf, showClosureTip } from './closures';
import { byId } from './format';
import { landmarkShown, showLandmarkTip } from './map';
import { layerShown, type MapOptions } from './map_draw';
import { nearestOnScreen } from './map_input';
import { activeRun } from './runs';
import { mapText } from './saved_map';
import { markShown, showMarkTip } from './saved_map_draw';
import { SceneContent } from './scene_content';
import { type Box, boxOf, SceneView, sizeOf } from './scene_view';
import { app, listen, setCursor, throttled } from './store';
import { SMOOTH } from './webgl';

/** Where a processor draws, a scene that was drawn less than so long ago [ms] is in motion: it is drawn
 *  coarsely, and in full once it is still. */
const STILL = 250;

// The colours of the page as they are: there is no light to mix.
ColorManagement.enabled = false;

export class ScenePanel {
  readonly canvas = byId<HTMLCanvasElement>('scene');
  readonly draw = throttled(() => this.drawNow());
  private readonly renderer = new WebGLRenderer({ canvas: this.canvas, antialias: SMOOTH, alpha: true });
  private readonly view = new SceneView(this.canvas, this.draw);
  private readonly scene = new Scene();
  private content: SceneContent | null = null;
  private box: Box = { low: new Vector3(), high: new Vector3() };
  /** The canvas is on the screen or near it. */
  private near = false;
  /** The run has grown while the scene was not drawn. */
  private outdated = false;
  /** What was drawn before: its shaders serve what is drawn in its place, so it goes after that. */
  private old: SceneContent[] = [];
  private drawnAt = -Infinity;
  private announcedAt = -Infinity;
  private stillTimer = 0;
  /** Of the canvas [css px]; 0 while it is not shown. */
  private width = 0;
  private height = 0;

  constructor(private readonly options: MapOptions, private readonly hint: () => void) {
    this.renderer.outputColorSpace = LinearSRGBColorSpace;
    this.listenToInput();
    listen('run', () => { this.box = boxOf(activeRun()); this.build(); this.fit(); });
    listen('rows', () => this.growRun());
    for (const kind of ['theme', 'shown'] as const) listen(kind, () => { this.build(); this.draw(); });
    listen('cursor', () => { if (this.visible()) { this.moveBody(); this.draw(); } });
    new ResizeObserver(() => this.resized()).observe(this.canvas);
    new IntersectionObserver((entries) => {
      this.near = entries[entries.length - 1].isIntersecting;
      if (this.near) this.catchUp();
    }, { rootMargin: '200px' }).observe(this.canvas);
  }

  private shown(): boolean {
    return this.width > 0 && app.subjects.length > 0;
  }

  /** Far from the screen nothing is drawn: a plot moves the cursor with each move of the pointer. */
  private visible(): boolean {
    return this.near && this.shown();
  }

  /** Does what was left out while nothing was drawn. */
  private catchUp(): void {
    if (!this.visible()) return;
    if (this.outdated) this.growRun();
    this.moveBody();
    this.draw();
  }

  /** A view that shows everything goes on to do so. */
  private growRun(): void {
    this.outdated = !this.visible();
    if (this.outdated) return;
    this.box = boxOf(activeRun());
    this.build();
    if (this.view.atFit()) this.fit();
    this.draw();
  }

  setView(view: string): void {
    this.view.choose(view);
    this.resize();
    if (this.outdated) this.growRun();
    this.fit();
  }

  private clear(): void {
    for (const content of this.old.splice(0)) content.dispose();
  }

  private build(): void {
    if (!app.subjects.length) return;
    this.clear();
    if (this.content) {
      this.scene.remove(this.content.group);
      this.old.push(this.content);
    }
    this.content = new SceneContent(activeRun(), this.options, this.box);
    this.scene.add(this.content.group);
    byId('scene-note').textContent = this.content.note;
    this.moveBody();
  }

  /** Puts the body, and what follows it, to where the cursor is. */
  private moveBody(): void {
    const { states, t } = activeRun();
    this.content?.setRow(app.cursor);
    if (this.view.follows()) this.view.follow(states, t, app.cursor, sizeOf(this.box));
  }

  fit(): void {
    this.resize();
    this.view.fit(this.box);
    this.moveBody();
    this.draw();
  }

  zoom(factor: number): void {
    this.view.zoom(factor);
  }

  /** A view that shows everything goes on to do so. */
  private resized(): void {
    this.resize();
    if (this.shown() && this.view.atFit()) this.fit(); else this.draw();
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    this.width = width;
    this.height = height;
    if (!width || !height) return;
    this.renderer.setPixelRatio(SMOOTH ? Math.min(window.devicePixelRatio || 1, 2) : 1);
    this.renderer.setSize(width, height, false);
    this.view.setShape(width, height);
  }

  drawNow(): void {
    if (!this.visible()) return;
    const coarse = !SMOOTH && performance.now() - this.drawnAt < STILL;
    this.drawOnce(coarse);
    clearTimeout(this.stillTimer);
    // Counted from when it is on the screen, however long that took.
    requestAnimationFrame(() => {
      this.drawnAt = performance.now();
      clearTimeout(this.stillTimer);
      if (coarse) this.stillTimer = window.setTimeout(this.draw, STILL + 20);
    });
  }

  /** As it is when it is still. */
  drawInFull(): void {
    if (!this.shown()) return;
    this.moveBody();
    this.drawOnce(false);
  }

  private drawOnce(coarse: boolean): void {
    const { canvas } = this, run = activeRun(), marks = run.landmarks.id.length;
    const dots = this.content?.arrange(this.view.screen(this.width, this.height), coarse) ?? 0;
    this.renderer.render(this.scene, this.view.camera);
    this.clear();
    canvas.dataset.detail = coarse ? `coarse: ${dots} of ${marks} dots` : 'full';
    // While it moves it changes with every drawing.
    if (coarse && performance.now() - this.announcedAt < 1000) return;
    this.announcedAt = performance.now();
    const { savedMap } = run;
    canvas.setAttribute('aria-label', savedMap && !run.count ? mapText(savedMap) : `The run in three dimensions: ${run.count} estimated poses and ` +
      `${marks} landmarks, ${this.content?.landmarksInView() ?? 0} of them in view. Arrow keys turn it.`);
  }

  private listenToInput(): void {
    const { canvas } = this;
    canvas.addEventListener('wheel', () => { if (!this.view.wheelZooms()) this.hint(); },
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
      ArrowLeft: () => this.view.turn(-angle, 0), ArrowRight: () => this.view.turn(angle, 0),
      ArrowUp: () => this.view.turn(0, angle), ArrowDown: () => this.view.turn(0, -angle),
      '+': () => this.zoom(1.25), '=': () => this.zoom(1.25), '-': () => this.zoom(0.8),
      0: () => this.fit(),
      '[': () => setCursor(app.cursor - 1), ']': () => setCursor(app.cursor + 1),
    };
    const action = actions[e.key];
    if (!action || e.ctrlKey || e.metaKey || e.altKey) return;
    e.preventDefault();
    action();
  }

  /** A landmark shows its numbers, the estimate takes the time cursor. */
  private point(place: { x: number; y: number }): void {
    const run = activeRun(), { width, height } = this;
    const mark = this.view.onScreen(run.landmarks, width, height);
    const shown = (i: number): [number, number] =>
      (landmarkShown(this.options, i) ? mark(i) : [-1e9, -1e9]);
    const found = nearestOnScreen(run.landmarks.id.length, shown, place, 6);
    if (found >= 0) {
      showLandmarkTip(found, ...mark(found), width, height);
      return;
    }
    byId('map-tip').hidden = true;
    if (run.savedMap) {
      const { marks } = run.savedMap, at = this.view.onScreen(marks, width, height);
      const saved = nearestOnScreen(marks.id.length,
        (i) => (markShown(this.options, marks, i) ? at(i) : [-1e9, -1e9]), place, 6);
      if (saved >= 0) {
        showMarkTip(run.savedMap, saved, run.origin, ...at(saved), width, height);
        return;
      }
    }
    if (this.view.follows()) return;
    const path = this.view.onScreen(run.states, width, height);
    const list = layerShown(this.options, 'closures') ? closuresOf(run) : [];
    const closed = nearestOnScreen(list.length, (i) => path(list[i].state), place, 8);
    if (closed >= 0) showClosureTip(run, list[closed], ...path(list[closed].state), width, height);
    const state = closed >= 0 ? list[closed].state : nearestOnScreen(run.count, path, place, 10);
    if (state >= 0) setCursor(state);
  }
}
