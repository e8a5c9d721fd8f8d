// Starts the page of a batch: its recordings with their verdicts, the worst first.
import '../styles/page.css';
import '../styles/batch.css';

import { type Batch, type Recording, type Verdict, VERDICTS } from './batch_data';
import { differenceList } from './batch_difference';
import { pageData } from './data';
import { asNumber, byId, fixed, grouped, make, number, percent, plainText } from './format';
import { startTheme } from './theme';

const { summary, recordings, difference } = pageData() as Batch;
const shown = new Set<Verdict>(VERDICTS);
let order: { column: number; down: boolean } | null = null;

/** The badges of the page of a run, by what they mean. */
const BADGES: Record<Verdict, string> = { no: 'lost', check: 'degraded', use: 'ok' };
const badge = (verdict: Verdict): HTMLElement =>
  make('span', { class: `badge ${BADGES[verdict]}` }, verdict);

function pathSketch({ sketch }: Recording): Node | string {
  if (!sketch || sketch.x.length < 2) return '–';
  const size = 64, margin = 4;
  const [left, right] = [Math.min(...sketch.x), Math.max(...sketch.x)];
  const [low, high] = [Math.min(...sketch.y), Math.max(...sketch.y)];
  const scale = (size - 2 * margin) / Math.max(right - left, high - low, 1e-6);
  const points = sketch.x.map((x, i) =>
    `${(size / 2 + scale * (x - (left + right) / 2)).toFixed(1)},` +
    `${(size / 2 - scale * (sketch.y[i] - (low + high) / 2)).toFixed(1)}`).join(' ');
  const space = 'http://www.w3.org/2000/svg';
  const svg = document.createElementNS(space, 'svg'), line = document.createElementNS(space, 'polyline');
  svg.setAttribute('class', 'sketch');
  svg.setAttribute('viewBox', `0 0 ${size} ${size}`);
  svg.setAttribute('role', 'img');
  svg.setAttribute('aria-label', `the path, ${number(Math.max(right - left, high - low))} m across`);
  line.setAttribute('points', points);
  svg.append(line);
  return svg;
}

const picture = ({ picture: jpeg, name }: Recording): Node | string =>
  jpeg ? make('img', { class: 'thumbnail', alt: `an image of ${name}`, loading: 'lazy',
    src: `data:image/jpeg;base64,${jpeg}` }) : '';

const reasonsOf = ({ reasons }: Recording): Node =>
  make('ul', { class: 'reasons' }, ...reasons.map(({ reason, what }) =>
    make('li', {}, make('b', {}, reason), ` ${what}`)));

interface Column {
  title: string;
  show: (r: Recording) => Node | string;
  key?: (r: Recording) => number | string;
}

const figure = (title: string, value: (r: Recording) => unknown, text: (v: number) => string): Column => ({
  title, show: (r) => text(asNumber(value(r))), key: (r) => asNumber(value(r)),
});
const hasTruth = recordings.some((r) => typeof r.ate_posyaw_m === 'number');

const COLUMNS: Column[] = [
  { title: 'Verdict', show: (r) => badge(r.verdict), key: (r) => VERDICTS.indexOf(r.verdict) },
  { title: 'Recording', show: (r) => make('span', { dir: 'auto', title: r.recording }, r.name), key: (r) => r.name },
  { title: 'Image', show: picture },
  { title: 'Path', show: pathSketch },
  { title: 'Reasons', show: reasonsOf, key: (r) => r.reasons.map(({ reason }) => reason).join() },
  figure('Coverage', (r) => r.coverage, percent),
  figure('σ [m]', (r) => r.worst_sigma_m, (v) => fixed(v, 3)),
  figure('m per 100 m', (r) => r.drift_m_per_100m, (v) => fixed(v, 2)),
  ...(hasTruth ? [figure('ATE [m]', (r) => r.ate_posyaw_m, (v) => fixed(v, 3))] : []),
  figure('Length [m]', (r) => r.length_m, (v) => fixed(v, 1)),
  figure('Duration [s]', (r) => r.recorded_seconds, (v) => fixed(v, 1)),
];

function compare(a: number | string, b: number | string): number {
  if (typeof a === 'string' || typeof b === 'string') return String(a).localeCompare(String(b));
  if (Number.isNaN(a) || Number.isNaN(b)) return Number(Number.isNaN(a)) - Number(Number.isNaN(b));
  return a - b;
}

function chosen(): Recording[] {
  const reason = byId<HTMLSelectElement>('reason').value;
  const part = byId<HTMLInputElement>('search').value.toLowerCase();
  const list = recordings.filter((r) => shown.has(r.verdict) && r.name.toLowerCase().includes(part) &&
    (!reason || r.reasons.some((one) => one.reason === reason)));
  const key = order && COLUMNS[order.column].key;
  if (!order || !key) return list;
  const sign = order.down ? -1 : 1;
  return list.sort((a, b) => sign * compare(key(a), key(b)));
}

function heading({ title, key }: Column, column: number): HTMLElement {
  const isOrder = order?.column === column;
  const sort = () => {
    order = isOrder && order?.down ? null : { column, down: isOrder };
    show();
  };
  return make('th', { scope: 'col', 'aria-sort': !isOrder ? null : order?.down ? 'descending' : 'ascending' },
    key ? make('button', { type: 'button', class: 'sort', onclick: sort },
      title + (!isOrder ? '' : order?.down ? ' ↓' : ' ↑')) : title);
}

function show(): void {
  const list = chosen();
  const rows = list.map((r) => make('tr', {},
    ...COLUMNS.map((column, i) => make(i === 1 ? 'th' : 'td', i === 1 ? { scope: 'row' } : {}, column.show(r)))));
  byId('recordings').replaceChildren(make('table', { class: 'batch' },
    make('thead', {}, make('tr', {}, ...COLUMNS.map(heading))), make('tbody', {}, ...rows)));
  byId('count').textContent = `${list.length} of ${recordings.length} recordings`;
}

function showHead(): void {
  const { estimator, version } = summary.plan;
  byId('run-name').textContent = 'Batch';
  byId('run-line').textContent = `${grouped(summary.recordings)} recordings · estimator ${plainText(estimator)}`;
  byId('version').textContent = `Chasles ${plainText(version)}.`;
  const cards: [string, string, string, string][] = [
    ...[...VERDICTS].reverse().map((verdict): [string, string, string, string] =>
      [verdict, grouped(summary.verdicts[verdict]), '',
        percent(summary.verdicts[verdict] / Math.max(1, summary.recordings))]),
    ['Recorded', number(summary.recorded_seconds / 60), 'min', 'from first to last frames'],
    ['Paths', number(summary.length_m), 'm', 'with an estimate'],
  ];
  byId('cards').replaceChildren(...cards.map(([label, value, unit, meaning]) =>
    make('div', { class: 'card' }, make('div', { class: 'card-label' }, label),
      make('div', { class: 'card-value' }, value, make('span', { class: 'unit' }, unit)),
      make('div', { class: 'muted small' }, meaning))));
}

function startFilters(): void {
  byId('verdicts').replaceChildren(...VERDICTS.map((verdict) => {
    const box = make('input', { type: 'checkbox' });
    box.checked = true;
    box.addEventListener('change', () => {
      if (box.checked) shown.add(verdict); else shown.delete(verdict);
      show();
    });
    return make('label', { class: 'key toggle' }, box, badge(verdict), ` ${summary.verdicts[verdict]}`);
  }));
  byId('reason').replaceChildren(make('option', { value: '' }, 'any'),
    ...Object.entries(summary.reasons).map(([reason, count]) =>
      make('option', { value: reason }, `${reason} (${count})`)));
  byId('reason').addEventListener('change', show);
  byId('search').addEventListener('input', show);
  byId('names').addEventListener('click', () => {
    void navigator.clipboard?.writeText(chosen().map((r) => r.recording).join('\n') + '\n');
  });
}

startTheme();
showHead();
startFilters();
if (difference) {
  byId('difference-panel').hidden = false;
  byId('difference').replaceChildren(...differenceList(difference, badge));
}
show();
