// A plot as a vector picture: for files and for the paper.
import { FONT_FAMILY, ticksOf } from './canvas';
import { at, clamp, type Values } from './data';
import { isBand, legendSeries, type Panel, panelTitle, type PlotSpec, type Series } from './plot_spec';
import { isKnown, panelLimits, tickTexts, unwell, valueTicks } from './plot_scale';
import { activeSubject, app } from './store';
import { palette } from './theme';

const LEFT = 58, RIGHT = 14, PANEL_HEIGHT = 150, PANEL_GAP = 28, AXIS = 26, LINE = 17;

export interface SvgPicture { svg: string; width: number; height: number }

const escaped = (text: string) => text.replace(/[<>&"']/g, (c) => `&#${c.charCodeAt(0)};`)
  // What XML 1.0 has no place for.
  .replace(/[\u0000-\u0008\u000b\u000c\u000e-\u001f\ufffe\uffff]/g, '�');
const f = (v: number) => v.toFixed(1);

function text(x: number, y: number, content: string, colour: string, more = ''): string {
  return `<text x="${f(x)}" y="${f(y)}" fill="${palette[colour]}" ${more}>${escaped(content)}</text>`;
}

/** Where a panel's numbers are in the picture. */
interface Frame { x: (t: number) => number; y: (v: number) => number; top: number; right: number }

/** The rows of the visible span, with one on either side. */
function visibleRows(): [number, number] {
  const { t, count } = activeSubject();
  let from = 0, to = count - 1;
  while (from + 1 < count && t[from + 1] < app.span[0]) from++;
  while (to > from && t[to - 1] > app.span[1]) to--;
  return [from, to];
}

/** A path through the numbers; where many fall on a pixel only the first, the least, the greatest
 *  and the last of them. */
function linePath(values: Values, frame: Frame): string {
  const { t } = activeSubject(), [from, to] = visibleRows();
  let path = '', pen = false;
  for (let i = from; i <= to; i++) {
    if (!isKnown(values, i)) { pen = false; continue; }
    const pixel = Math.floor(2 * frame.x(t[i]));
    let least = i, most = i, last = i;
    while (last < to && isKnown(values, last + 1) && Math.floor(2 * frame.x(t[last + 1])) === pixel) {
      last++;
      if (at(values, last) < at(values, least)) least = last;
      if (at(values, last) > at(values, most)) most = last;
    }
    for (const k of [...new Set([i, Math.min(least, most), Math.max(least, most), last])]) {
      path += `${pen ? 'L' : 'M'}${f(frame.x(t[k]))} ${f(frame.y(at(values, k)))}`;
      pen = true;
    }
    i = last;
  }
  return path;
}

/** The outline of a band; each gap in the numbers ends a piece. */
function bandPath(low: Values, high: Values, frame: Frame): string {
  const { t } = activeSubject(), [from, to] = visibleRows();
  // Bands are smooth: two points a pixel are enough.
  const stride = Math.max(1, Math.floor((to - from) / 2000));
  let path = '';
  for (let i = from; i <= to; i++) {
    if (!isKnown(low, i) || !isKnown(high, i)) continue;
    const rows = [i];
    while (i < to && isKnown(low, i + 1) && isKnown(high, i + 1)) {
      i++;
      if (i % stride === 0 || i === to) rows.push(i);
    }
    const edge = (column: Values, k: number) => `${f(frame.x(t[k]))} ${f(frame.y(at(column, k)))}`;
    path += 'M' + rows.map((k) => edge(high, k)).join('L') + 'L' +
      rows.reverse().map((k) => edge(low, k)).join('L') + 'Z';
  }
  return path;
}

function seriesSvg(series: Series, frame: Frame): string {
  const colour = palette[series.colour];
  if (isBand(series) && series.low !== undefined && series.high !== undefined) {
    return `<path d="${bandPath(series.low, series.high, frame)}" fill="${colour}" ` +
      `fill-opacity="${series.style === 'stack' ? '.6' : '.25'}" stroke="${colour}" ` +
      'stroke-width=".7" stroke-opacity=".7"/>';
  }
  if (series.values === undefined) return '';
  const area = series.style === 'area' ? `<path d="${bandPath(0, series.values, frame)}" ` +
    `fill="${colour}" fill-opacity=".35"/>` : '';
  const dash = series.dash?.length ? series.dash : series.style === 'level' ? [5, 4] : [];
  return area + `<path d="${linePath(series.values, frame)}" fill="none" stroke="${colour}" ` +
    `stroke-width="1.3" stroke-linejoin="round" stroke-dasharray="${dash.join(' ')}"/>`;
}

function axesSvg(panel: Panel, limits: [number, number], frame: Frame): string {
  const ticks = valueTicks(limits, panel.log), texts = tickTexts(ticks, panel.log);
  return ticks.map((v, k) => {
    const y = f(frame.y(v));
    return `<path d="M${LEFT} ${y}H${f(frame.right)}" stroke="${palette.line}"/>` +
      text(LEFT - 6, frame.y(v) + 4, texts[k], 'muted', 'text-anchor="end"');
  }).join('') + `<rect x="${LEFT}" y="${f(frame.top)}" width="${f(frame.right - LEFT)}" ` +
    `height="${PANEL_HEIGHT}" fill="none" stroke="${palette.line}"/>`;
}

function panelSvg(panel: Panel, top: number, width: number, hidden: Set<string>): string {
  const drawn = panel.series.filter((s) => !hidden.has(s.label));
  const limits = panelLimits(panel, drawn), [from, to] = app.span, right = width - RIGHT;
  const map = panel.log ? (v: number) => Math.log10(Math.max(v, limits[0])) : (v: number) => v;
  const [a, b] = limits.map(map);
  const frame: Frame = { top, right,
    x: (t) => LEFT + ((t - from) / (to - from)) * (right - LEFT),
    y: (v) => top + PANEL_HEIGHT * (1 - clamp((map(v) - a) / (b - a), -1, 2)) };
  const health = unwell().map(([t0, t1, name]) => {
    const x0 = clamp(frame.x(t0), LEFT, right), x1 = clamp(frame.x(t1), LEFT, right);
    return `<rect x="${f(x0)}" y="${f(top)}" width="${f(Math.max(0, x1 - x0))}" fill-opacity=".16" ` +
      `height="${PANEL_HEIGHT}" fill="${palette[name === 'lost' ? 'bad' : 'warn']}"/>`;
  }).join('');
  return health + axesSvg(panel, limits, frame) +
    // A nested svg cuts off what sticks out.
    `<svg x="${LEFT}" y="${f(top)}" width="${f(right - LEFT)}" height="${PANEL_HEIGHT}" ` +
    `viewBox="${LEFT} ${f(top)} ${f(right - LEFT)} ${PANEL_HEIGHT}">` +
    drawn.map((s) => seriesSvg(s, frame)).join('') + '</svg>' +
    text(LEFT, top - 6, panelTitle(panel), 'ink') +
    text(right, top - 6, panel.summary ?? '', 'muted', 'text-anchor="end"');
}

/** The key in rows: a line or a patch and its name. Widths are estimated: text has none here. */
function keySvg(spec: PlotSpec, hidden: Set<string>, top: number, width: number): [string, number] {
  const entries = [...legendSeries(spec).filter((s) => !hidden.has(s.label))
    .map(({ label, colour, dash, style }) => ({ label, colour, dash, style: style as string })),
  ...(spec.key ?? []).map(({ text: label, colour, dash }) => ({ label, colour, dash, style: 'line' }))];
  let x = 12, y = top, svg = '';
  for (const { label, colour, dash, style } of entries) {
    const shown = label.length > 60 ? label.slice(0, 59) + '…' : label;
    const wide = 44 + 6.6 * shown.length;
    if (x > 12 && x + wide > width) [x, y] = [12, y + LINE];
    const patch = ['band', 'stack', 'area'].includes(style);
    svg += `<path d="M${f(x)} ${f(y - 4)}h24" stroke="${palette[colour]}" stroke-width="` +
      `${patch ? 9 : 2}" stroke-opacity="${patch ? 0.4 : 1}" stroke-dasharray="` +
      `${(dash ?? (style === 'level' ? [5, 4] : [])).join(' ')}"/>` + text(x + 30, y, shown, 'ink');
    x += wide;
  }
  return [svg, entries.length ? y + LINE : top];
}

function timeAxisSvg(top: number, width: number): string {
  const [from, to] = app.span, right = width - RIGHT;
  const ticks = ticksOf(from, to, 8), texts = tickTexts(ticks);
  return ticks.map((t, k) => text(LEFT + ((t - from) / (to - from)) * (right - LEFT), top + LINE,
    texts[k] + (k === ticks.length - 1 ? ' s' : ''), 'muted', 'text-anchor="middle"')).join('');
}

/** The plot over the visible span, without the series whose labels are hidden. */
export function plotSvg(spec: PlotSpec, hidden: Set<string>, width = 760): SvgPicture {
  const [key, below] = keySvg(spec, hidden, 46, width);
  let top = below + 14;
  const panels = spec.panels.map((panel) => {
    const svg = panelSvg(panel, top, width, hidden);
    top += PANEL_HEIGHT + PANEL_GAP;
    return svg;
  });
  const bottom = top - PANEL_GAP, height = Math.ceil(bottom + AXIS);
  const title = `${spec.title} – ${activeSubject().label}`;
  const svg = `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${width} ${height}" ` +
    `width="${width}" height="${height}" font-family='${FONT_FAMILY}' font-size="12">` +
    `<rect width="100%" height="100%" fill="${palette.panel}"/>` +
    text(12, 24, title, 'ink', 'font-size="15" font-weight="600"') + key + panels.join('') +
    timeAxisSvg(bottom, width) + '</svg>';
  return { svg, width, height };
}
