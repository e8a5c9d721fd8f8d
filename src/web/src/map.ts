// The map: what it shows and how it answers.
import { closuresOf, showClosureTip } from './closures';
import { AXES } from './data';
import { downloadCsv, fileName } from './files';
import { byId, fixed, grouped, make, number, swatch, toggle } from './format';
import { LIFE_LABELS, lifeAt, lifeText } from './landmark_life';
import { estimateColour, layerShown, type MapOptions } from './map_draw';
import { distanceMoved, knowsInitial } from './map_initial';
import { type MapHost, MapInput, nearestOnScreen, placeTip } from './map_input';
import { MapLayers } from './map_layers';
import { COVARIANCES, MapView } from './map_view';
import { activeRun, type Run } from './runs';
import { mapText, type SavedMap, sessionColour, sessionKey } from './saved_map';
import { markShown, showMarkTip } from './saved_map_draw';
import { app, listen, setCursor, throttled } from './store';

export class MapPanel implements MapHost {
  readonly canvas = byId<HTMLCanvasElement>('map');
  readonly view = new MapView();
  private readonly layers: MapLayers;
  private readonly drawSoon = throttled(() => this.drawNow());
  private ready = false;
  private hintTimer = 0;

  constructor(private readonly options: MapOptions) {
    this.layers = new MapLayers(this.view, options);
    new MapInput(this);
    listen('cursor', this.drawSoon);
    listen('shown', () => { this.view.colourBy(this.options.colour); this.draw(); });
    listen('theme', () => {
      if (this.ready) this.view.colourBy(this.options.colour);
      this.draw();
    });
    listen('run', () => this.showRun());
    listen('rows', () => this.growRun());
    new ResizeObserver(() => { this.resize(); this.draw(); }).observe(this.canvas);
  }

  private showRun(): void {
    this.ready = true;
    this.view.setRun(activeRun());
    this.view.colourBy(this.options.colour);
    this.view.measure(this.canvas);
    this.fit();
  }

  /** A view that shows everything goes on to do so. */
  private growRun(): void {
    const { view } = this, run = activeRun(), whole = view.atFit();
    if (view.landmarks !== run.landmarks || view.savedMap !== run.savedMap) {
      view.setRun(run);
      view.colourBy(this.options.colour);
    }
    if (whole) view.fit(run);
    this.draw();
  }

  private resize(): void {
    if (this.view.measure(this.canvas) && this.ready) this.view.fit(activeRun());
  }

  /** Draws all of it: another view, another choice, more rows. */
  draw(): void {
    this.layers.invalidate();
    this.drawSoon();
  }

  fit(): void {
    this.view.fit(activeRun());
    this.draw();
  }

  zoom(factor: number): void {
    this.view.zoomAbout(this.view.width / 2, this.view.height / 2, factor);
    this.draw();
  }

  drawNow(): void {
    // Nothing is drawn while the scene is shown in its place.
    if (!this.ready || this.canvas.clientWidth === 0) return;
    this.layers.draw(this.canvas);
    this.canvas.setAttribute('aria-label', mapDescription(activeRun(), this.options));
  }

  drawInFull(): void {
    this.drawNow();
  }

  print(): void {
    this.resize();
    this.layers.invalidate();
    this.drawNow();
  }

  setPlane(name: string): void {
    this.view.setPlane(name);
    this.view.measure(this.canvas);
    this.fit();
  }

  /** Answers to the pointer: a landmark shows its numbers, the estimate takes the time cursor. */
  point(place: { x: number; y: number } | null): void {
    const { view } = this, run = activeRun();
    const found = place ? nearestOnScreen(view.landmarks.id.length,
      (i) => (landmarkShown(this.options, i) ? view.landmarkAt(i) : [-1e9, -1e9]), place, 8) : -1;
    if (found !== view.hovered) {
      view.hovered = found;
      this.drawSoon();
    }
    if (found >= 0) {
      const [x, y] = view.landmarkAt(found);
      showLandmarkTip(found, x, y, view.width, view.height);
      return;
    }
    this.hideTip();
    if (place && this.pointAtClosure(run, place)) return;
    if (view.savedMap && place && this.pointAtSaved(view.savedMap, place)) return;
    const state = place ? nearestOnScreen(run.count, (i) => view.stateAt(run, i), place, 14) : -1;
    if (state >= 0) setCursor(state);
  }

  private pointAtClosure(run: Run, place: { x: number; y: number }): boolean {
    if (!layerShown(this.options, 'closures')) return false;
    const { view } = this, list = closuresOf(run);
    const found = nearestOnScreen(list.length, (i) => view.stateAt(run, list[i].state), place, 7);
    if (found < 0) return false;
    setCursor(list[found].state);
    showClosureTip(run, list[found], ...view.stateAt(run, list[found].state), view.width, view.height);
    return true;
  }

  private pointAtSaved(map: SavedMap, place: { x: number; y: number }): boolean {
    const { view } = this, { marks } = map;
    const found = nearestOnScreen(marks.id.length,
      (i) => (markShown(this.options, marks, i) ? view.markAt(marks, i) : [-1e9, -1e9]), place, 8);
    if (found < 0) return false;
    showMarkTip(map, found, view.origin, ...view.markAt(marks, found), view.width, view.height);
    return true;
  }

  hint(): void {
    const hint = byId('map-hint');
    hint.hidden = false;
    clearTimeout(this.hintTimer);
    this.hintTimer = window.setTimeout(() => { hint.hidden = true; }, 1400);
  }

  hideTip(): void {
    byId('map-tip').hidden = true;
  }
}

/** Whether the choices of the legend show that landmark at the time of the cursor. */
export const landmarkShown = ({ show }: MapOptions, i: number): boolean =>
  show[lifeAt(activeRun(), i, activeRun().t[app.cursor])];

/** The numbers of a landmark beside its place on the screen. */
export function showLandmarkTip(i: number, x: number, y: number, width: number, height: number): void {
  const run = activeRun(), m = run.landmarks, tip = byId('map-tip');
  const sigma = ['cxx', 'cyy', 'czz'].map((c) => number(Math.sqrt(m[c][i]), 2)).join(', ');
  const place = AXES.map((axis, k) => fixed(m[axis][i] + run.origin[k], 2)).join(', ');
  const moved = distanceMoved(m, i);
  tip.replaceChildren(make('strong', {}, `Landmark ${m.id[i]}`),
    make('div', {}, `x, y, z  ${place} m`), make('div', {}, `σ  ${sigma} m`),
    make('div', {}, `${grouped(m.observations[i])} observations used`), make('div', {}, lifeText(i)),
    Number.isFinite(moved) ? make('div', {}, `moved ${number(moved, 2)} m since initialisation`) : '');
  placeTip(tip, x, y, width, height);
}

type Layer = [key: string, label: string, style: string, colour: string];

/** What the map of the active run can show, or else its scene. */
function legendLayers(map: boolean): Layer[] {
  const run = activeRun();
  const list: Layer[] = [];
  if (run.count || !run.savedMap) list.push(['estimate', 'Estimate', 'line', estimateColour()]);
  if (run.truth) list.push(['truth', 'Truth', 'dashed', 'truth']);
  if (run.deadReckoning) list.push(['dead', 'Dead reckoning', 'dotted', 'dead']);
  if (run.landmarks.id.length) {
    list.push(['view', LIFE_LABELS.view, 'dots in-view', 'landmark'],
      ['retired', LIFE_LABELS.retired, 'dots', 'landmark'],
      ['later', LIFE_LABELS.later, 'dots faint', 'muted']);
  }
  if (map && knowsInitial(run.landmarks)) {
    list.push(['initial', 'Initial positions', 'dots lined', 'initial']);
  }
  if (closuresOf(run).length) list.push(['closures', 'Loop closures', 'rings', 'cursor']);
  run.savedMap?.sessions.forEach((session, k) => {
    const label = run.count ? `Map: ${session.name}` : session.name;
    list.push([sessionKey(k), label, 'dots', sessionColour(k)]);
  });
  if (run.plan) list.push(['plan', 'Floor plan', 'line', 'muted']);
  (app.subjects as Run[]).forEach((other, k) => {
    if (k !== app.active) list.push([`run-${k}`, other.label, 'dashdot', other.colour]);
  });
  return list;
}

/** Distinguishes one choice of layers from another. */
export const layersKey = (map: boolean): string => JSON.stringify(legendLayers(map));

export function layersText(options: MapOptions, map: boolean): string {
  return legendLayers(map).filter(([key]) => layerShown(options, key))
    .map(([, label, style]) => `${label} (${style.split(' ')[0]})`).join(' · ');
}

export function showMapLegend(options: MapOptions, map: boolean, changed: () => void): void {
  byId('map-legend').replaceChildren(...legendLayers(map).map(([key, label, style, colour]) =>
    toggle(swatch(style, colour), make('span', { dir: 'auto' }, label), layerShown(options, key),
      (on) => { options.show[key] = on; changed(); })));
}

function mapDescription(run: Run, options: MapOptions): string {
  if (run.savedMap && !run.count) return mapText(run.savedMap);
  const parts = [`${run.count} estimated poses`, `${run.landmarks.id.length} landmarks`];
  if (knowsInitial(run.landmarks) && layerShown(options, 'initial')) {
    parts.push('their initial positions');
  }
  if (run.truth) parts.push('the truth');
  if (run.deadReckoning) parts.push('dead reckoning');
  return `Map with ${parts.join(', ')}.`;
}

export function downloadLandmarks(run: Run): void {
  const m = run.landmarks;
  const shifted = (name: string, k: number) => Float64Array.from(m[name], (v) => v + run.origin[k]);
  const columns: [string, ArrayLike<number>][] = [['id', m.id], ['x_m', shifted('x', 0)],
    ['y_m', shifted('y', 1)], ['z_m', shifted('z', 2)], ['observations', m.observations],
    ['first_seen_s', m.first], ['last_seen_s', m.last], ['in_state', m.in_state],
    ...Object.values(COVARIANCES).map((c): [string, ArrayLike<number>] => [c + '_m2', m[c]])];
  if (knowsInitial(m)) {
    AXES.forEach((axis, k) => columns.push([`initial_${axis}_m`, shifted(`i${axis}`, k)]));
  }
  downloadCsv(fileName(run.name, 'landmarks'),
    columns.map(([label, values]) => ({ label, values })));
}
