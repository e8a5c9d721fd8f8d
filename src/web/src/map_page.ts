// Starts the page of a saved map, which is a run without states to the parts that draw it.
import '../styles/page.css';
import '../styles/map.css';

import { pageData, quantile } from './data';
import { startExact } from './exact';
import { byId, grouped, isNumber, isScalar, make, number } from './format';
import { type Bins, evenBins, histogram, logBins } from './histogram';
import { activeRun, decodeRun, labelRuns, type RawRun } from './runs';
import { type SavedMap, sessionColour } from './saved_map';
import { app, setActive } from './store';
import { table } from './tables';
import { startTheme } from './theme';
import { World } from './world';

function showHead({ marks, sessions }: SavedMap): void {
  const run = activeRun(), { version } = run.summary;
  byId('run-name').textContent = run.name || 'Chasles';
  byId('run-name').title = run.name;
  byId('run-line').textContent = `saved map  ·  ${grouped(marks.id.length)} landmarks  ·  ` +
    `${sessions.length} session${sessions.length === 1 ? '' : 's'}`;
  document.title = `${run.label} – Chasles`;
  byId('version').textContent = `Chasles${isScalar(version) && version ? ` ${version}` : ''}.`;
}

function showCards({ marks, sigma }: SavedMap): void {
  const { summary: s } = activeRun(), bytes = isNumber(s.bytes) ? s.bytes : NaN;
  const [low, high] = [s.least_m, s.most_m] as [number[], number[]];
  const size = low.map((l, k) => number(high[k] - l, 2)).join(' × ');
  const cards: [string, string, string, string][] = [
    ['Landmarks', grouped(marks.id.length), '', 'that can be recognised'],
    ['Extent', size, 'm', 'x, y, z'],
    ['Median σ', number(quantile(sigma, 0.5)), 'm', `largest ${number(quantile(sigma, 1))} m`],
    ['Shared', number(100 * (1 - quantile(marks.own, 0.5)), 2), '%', 'of a variance, median'],
    ['Shared errors', String(s.shared_errors ?? '–'), '', 'directions of all landmarks'],
    ['File', number(1e-3 * bytes), 'kB', `${number(bytes / marks.id.length)} bytes a landmark`],
  ];
  byId('cards').replaceChildren(...cards.map(([label, value, unit, meaning]) =>
    make('div', { class: 'card' }, make('div', { class: 'card-label' }, label),
      make('div', { class: 'card-value' }, value, make('span', { class: 'unit' }, unit)),
      make('div', { class: 'muted small' }, meaning))));
}

/** A recording may count its time from anywhere. */
function when(begin: number): string {
  const year2000 = 946684800;
  if (begin < year2000) return `${number(begin, 4)} s on its clock`;
  return new Date(1000 * begin).toISOString().slice(0, 19).replace('T', ' ') + ' UTC';
}

function showSessions({ sessions, marks, sigma }: SavedMap): void {
  const cell = (text: string, style = 'figure') => make('td', { class: style }, text);
  const rows = sessions.map((session, k) => {
    const own = Array.from(marks.session, (of, i) => (of === k ? i : -1)).filter((i) => i >= 0);
    const of = (values: ArrayLike<number>) => own.map((i) => values[i]);
    return [make('span', { class: 'key' },
      make('i', { class: 'swatch dots', style: `--c: var(--${sessionColour(k)})` }),
      make('span', { dir: 'auto' }, session.name || '–')),
    cell(when(session.begin), ''), cell(`${number(session.seconds, 4)} s`),
    cell(String(session.cameras)), cell(grouped(own.length)),
    cell(`${number(quantile(of(sigma), 0.5))} m`), cell(`${number(quantile(of(sigma), 1))} m`),
    cell(`${number(100 * (1 - quantile(of(marks.own), 0.5)), 2)} %`)];
  });
  byId('sessions').replaceChildren(table(['Session', 'began', 'duration', 'cameras', 'landmarks',
    'median σ', 'largest σ', 'shared, median'], rows));
}

function showHistograms(map: SavedMap): void {
  const { marks, sigma } = map, mostViews = quantile(marks.views, 1);
  const shared = Float64Array.from(marks.own, (own) => 100 * (1 - own));
  const list: [string, string, ArrayLike<number>, Bins][] = [
    ['Uncertainty', 'σ of a landmark [m]', sigma, logBins(sigma, 30)],
    ['Shared', 'part of a landmark’s variance that others share [%]', shared, evenBins(0, 100, 25)],
    ['Observations', 'used for a landmark', marks.observations, logBins(marks.observations, 30)],
    ['Views', 'kept of a landmark', marks.views, evenBins(0.5, mostViews + 0.5, mostViews)]];
  byId('histograms').replaceChildren(...list.filter(([, , values]) => values.length).map(
    ([title, label, values, bins]) => histogram(title, label, values, bins, marks.session)));
}

const { runs: [raw], bounds } = pageData() as { runs: RawRun[]; bounds: Record<string, number> };
const run = decodeRun(raw, bounds), map = run.savedMap;
if (!map) throw new Error('the page has no map');
labelRuns([run]);
app.subjects = [run];
startTheme();
startExact();
new World();
setActive(0);
showHead(map);
showCards(map);
showSessions(map);
showHistograms(map);
