// A saved map on the map of a page, and the numbers of its landmarks.
import type { Pen } from './canvas';
import { AXES, clamp, type Columns, type Vector } from './data';
import { downloadCsv, fileName } from './files';
import { byId, fixed, grouped, make, number, percent } from './format';
import { layerShown, type MapOptions, strokeEllipse } from './map_draw';
import { placeTip } from './map_input';
import type { MapView } from './map_view';
import { opacities, type SavedMap, sessionColour, sessionKey } from './saved_map';
import { palette } from './theme';

/** Whether the legend shows the session of that landmark. */
export const markShown = (options: MapOptions, { session }: Columns, i: number): boolean =>
  layerShown(options, sessionKey(session[i]));

/** Round where a run's own landmarks are square; those that returned have a rim. */
export function drawSavedMap(g: Pen, view: MapView, map: SavedMap, options: MapOptions,
    ellipses: boolean): void {
  const { marks } = map, alpha = opacities(map), radius = clamp(0.7 * Math.sqrt(view.scale), 1.3, 2.6);
  g.lineWidth = 1;
  for (let i = 0; i < marks.id.length; i++) {
    if (!markShown(options, marks, i)) continue;
    const [x, y] = view.markAt(marks, i);
    g.fillStyle = g.strokeStyle = palette[sessionColour(marks.session[i])];
    if (ellipses) strokeEllipse(g, view, x, y, view.planeCovariance(marks, i), 0.06, 0.5 * alpha[i]);
    g.globalAlpha = alpha[i];
    disc(g, x, y, radius);
    g.fill();
    if (!marks.returned[i]) continue;
    g.globalAlpha = 1;
    g.strokeStyle = palette.ink;
    disc(g, x, y, radius + 2);
    g.stroke();
  }
  g.globalAlpha = 1;
}

function disc(g: Pen, x: number, y: number, radius: number): void {
  g.beginPath();
  g.arc(x, y, radius, 0, 2 * Math.PI);
}

export function showMarkTip({ marks, sessions, sigma }: SavedMap, i: number, origin: Vector, x: number,
    y: number, width: number, height: number): void {
  const tip = byId('map-tip'), sigmas = ['cxx', 'cyy', 'czz'].map((c) => Math.sqrt(marks[c][i]));
  const place = AXES.map((axis, k) => fixed(marks[axis][i] + origin[k], 2)).join(', ');
  tip.replaceChildren(make('strong', {}, `Landmark ${marks.id[i]} of the map`),
    make('div', { dir: 'auto' }, sessions[marks.session[i]]?.name),
    make('div', {}, `x, y, z  ${place} m`),
    make('div', {}, `σ  ${sigmas.map((s) => number(s, 2)).join(', ')} m`),
    make('div', {}, `${percent(1 - marks.own[i])} of ${number(sigma[i] ** 2, 2)} m² shared`),
    make('div', {}, `${grouped(marks.observations[i])} observations, ${marks.views[i]} views`),
    marks.returned[i] ? make('div', {}, 'recognised by this run') : '');
  placeTip(tip, x, y, width, height);
}

export function downloadSavedMap(name: string, { marks, sigma }: SavedMap): void {
  const columns: [string, ArrayLike<number>][] = [['landmark', marks.id], ['session', marks.session],
    ['x_m', marks.x], ['y_m', marks.y], ['z_m', marks.z], ['sigma_m', sigma], ['own', marks.own],
    ['observations', marks.observations], ['views', marks.views]];
  downloadCsv(fileName(name, 'map'), columns.map(([label, values]) => ({ label, values })));
}
