// Mouse, touch and keyboard on the map.

class MapInput {
  constructor(panel) {
    this.panel = panel;
    this.view = panel.view;
    this.pointers = new Map();
    const canvas = this.canvas = panel.canvas;
    canvas.addEventListener('pointerdown', (e) => this.down(e));
    canvas.addEventListener('pointermove', (e) => this.move(e));
    canvas.addEventListener('pointerup', (e) => this.up(e));
    canvas.addEventListener('pointercancel', (e) => this.up(e));
    canvas.addEventListener('pointerleave', () => this.point(null));
    canvas.addEventListener('wheel', (e) => this.wheel(e), { passive: false });
    canvas.addEventListener('keydown', (e) => this.key(e));
    canvas.addEventListener('dblclick', (e) => this.zoomAt(e.offsetX, e.offsetY, 2));
  }

  down(e) {
    this.canvas.focus({ preventScroll: true });
    this.canvas.setPointerCapture(e.pointerId);
    this.pointers.set(e.pointerId, [e.offsetX, e.offsetY]);
    if (e.pointerType !== 'mouse') this.point(e);
  }

  up(e) {
    this.pointers.delete(e.pointerId);
  }

  move(e) {
    if (!this.pointers.has(e.pointerId)) return this.point(e);
    const before = this.pinch();
    const [x, y] = this.pointers.get(e.pointerId);
    this.pointers.set(e.pointerId, [e.offsetX, e.offsetY]);
    const after = this.pinch();
    this.view.pan(after.x - before.x, after.y - before.y);
    if (before.spread > 0) this.view.zoomAbout(after.x, after.y, after.spread / before.spread);
    if (Math.hypot(e.offsetX - x, e.offsetY - y) > 0) this.hideTip();
    this.panel.draw();
  }

  /** The middle of the fingers and their mean distance from it. */
  pinch() {
    const points = [...this.pointers.values()];
    const x = mean(points.map((p) => p[0])), y = mean(points.map((p) => p[1]));
    return { x, y, spread: mean(points.map((p) => Math.hypot(p[0] - x, p[1] - y))) };
  }

  /** The wheel scrolls the page until the map has been clicked: no trap on the way down. */
  wheel(e) {
    if (!e.ctrlKey && document.activeElement !== this.canvas) return this.hint();
    e.preventDefault();
    this.zoomAt(e.offsetX, e.offsetY, Math.exp(-0.0016 * e.deltaY * (e.deltaMode === 1 ? 20 : 1)));
  }

  hint() {
    const hint = byId('map-hint');
    hint.hidden = false;
    clearTimeout(this.hintTimer);
    this.hintTimer = setTimeout(() => { hint.hidden = true; }, 1400);
  }

  zoomAt(x, y, factor) {
    this.view.zoomAbout(x, y, factor);
    this.panel.draw();
  }

  key(e) {
    const step = e.shiftKey ? 160 : 40;
    const pan = (dx, dy) => () => { this.view.pan(dx, dy); this.panel.draw(); };
    const action = {
      ArrowLeft: pan(step, 0), ArrowRight: pan(-step, 0),
      ArrowUp: pan(0, step), ArrowDown: pan(0, -step),
      '+': () => this.panel.zoom(1.4), '=': () => this.panel.zoom(1.4),
      '-': () => this.panel.zoom(1 / 1.4), 0: () => this.panel.fit(),
      '[': () => setCursor(app.cursor - 1), ']': () => setCursor(app.cursor + 1),
    }[e.key];
    if (!action || e.ctrlKey || e.metaKey || e.altKey) return;
    e.preventDefault();
    action();
  }

  /** Answers to the pointer: a landmark tells its numbers, the estimate takes the time cursor. */
  point(e) {
    const found = e ? this.nearestLandmark(e.offsetX, e.offsetY) : -1;
    if (found !== this.view.hovered) {
      this.view.hovered = found;
      this.panel.draw();
    }
    if (found >= 0) return this.showTip(found);
    this.hideTip();
    if (e) this.followPath(e.offsetX, e.offsetY);
  }

  nearestLandmark(px, py) {
    if (!this.panel.options.show.landmarks) return -1;
    let best = -1, nearest = 8;
    for (let i = 0; i < this.view.landmarks.id.length; i++) {
      const [x, y] = this.view.landmarkAt(i);
      const distance = Math.hypot(x - px, y - py);
      if (distance < nearest) [best, nearest] = [i, distance];
    }
    return best;
  }

  followPath(px, py) {
    const run = activeRun();
    let best = -1, nearest = 14;
    for (let i = 0; i < run.count; i++) {
      const [x, y] = this.view.stateAt(run, i);
      const distance = Math.hypot(x - px, y - py);
      if (distance < nearest) [best, nearest] = [i, distance];
    }
    if (best >= 0) setCursor(best);
  }

  showTip(i) {
    const run = activeRun(), m = run.landmarks, tip = byId('map-tip');
    const sigma = ['cxx', 'cyy', 'czz'].map((c) => number(Math.sqrt(m[c][i]), 2)).join(', ');
    const place = AXES.map((axis, k) => fixed(m[axis][i] + run.origin[k], 2)).join(', ');
    tip.replaceChildren(make('strong', {}, `Landmark ${m.id[i]}`),
      make('div', {}, `x, y, z  ${place} m`), make('div', {}, `σ  ${sigma} m`),
      make('div', {}, `${grouped(m.observations[i])} observations used`));
    const [x, y] = this.view.landmarkAt(i);
    tip.hidden = false;
    const left = x + 14 + tip.offsetWidth > this.view.width ? x - 14 - tip.offsetWidth : x + 14;
    tip.style.left = clamp(left, 4, Math.max(4, this.view.width - tip.offsetWidth - 4)) + 'px';
    tip.style.top = clamp(y - 20, 4, this.view.height - tip.offsetHeight - 4) + 'px';
  }

  hideTip() {
    byId('map-tip').hidden = true;
  }
}
