// How a panel of a plot is drawn: scale, axes, series, legend.

/** The value axis of a panel at `top`: its limits over the visible time span, and y(value). */
function panelScale(panel, top) {
  const [low, high] = panel.log ? logLimits(panel) : linearLimits(panel);
  const map = panel.log ? (v) => Math.log10(Math.max(v, low)) : (v) => v;
  const [a, b] = [map(low), map(high)];
  const y = (v) => top + panelHeight * (1 - (map(v) - a) / (b - a));
  return { low, high, log: panel.log, top, y };
}

function* visibleValues(panel) {
  const t = activeRun().states.t;
  const [from, to] = app.span;
  for (const series of panel.series) {
    for (const values of [series.values, series.low, series.high]) {
      if (values === undefined) continue;
      if (typeof values === 'number') { yield values; continue; }
      for (let i = 0; i < t.length; i++) if (t[i] >= from && t[i] <= to) yield values[i];
    }
  }
}

function linearLimits(panel) {
  let low = Infinity, high = -Infinity;
  for (const v of visibleValues(panel)) {
    if (!Number.isFinite(v)) continue;
    if (v < low) low = v;
    if (v > high) high = v;
  }
  if (low > high) return [0, 1];
  if (panel.clip) high = clippedHigh(panel, high);
  if (panel.zero) low = Math.min(0, low);
  // Below this a constant is drawn as a line in the middle, not as magnified rounding.
  const least = Math.max(1e-9, 1e-6 * Math.max(Math.abs(low), Math.abs(high)));
  const room = high - low < least ? Math.max(least, Math.abs(high) * 0.1) : 0.06 * (high - low);
  return [panel.zero && low === 0 ? 0 : low - room, high + room];
}

/** Cuts off single spikes, so that the rest stays readable. */
function clippedHigh(panel, high) {
  const usual = quantile([...visibleValues(panel)], 0.99);
  return high > 3 * usual ? 2 * usual : high;
}

function logLimits(panel) {
  let low = Infinity, high = 0;
  for (const v of visibleValues(panel)) {
    if (!(v > 0) || !Number.isFinite(v)) continue;
    if (v < low) low = v;
    if (v > high) high = v;
  }
  if (!(high > 0)) return [0.1, 10];
  return [Math.max(low, high / 1e6, panel.floor || 0) / 1.4, high * 1.6];
}

function valueTicks(scale) {
  if (!scale.log) return ticksOf(scale.low, scale.high, 4);
  const ticks = [];
  for (let k = Math.ceil(Math.log10(scale.low)); 10 ** k <= scale.high; k++) ticks.push(10 ** k);
  return ticks;
}

/** A power of ten. */
function powerText(v) {
  return v >= 1e-4 && v < 1e5 ? String(Number(v.toPrecision(1))) : v.toExponential(0);
}

function drawValueAxis(g, scale, right) {
  const ticks = valueTicks(scale);
  const step = ticks.length > 1 ? ticks[1] - ticks[0] : 1;
  g.lineWidth = 1;
  g.textAlign = 'right';
  g.textBaseline = 'middle';
  for (const v of ticks) {
    const y = Math.round(scale.y(v)) + 0.5;
    g.strokeStyle = v === 0 ? palette.muted : palette.line;
    g.globalAlpha = v === 0 ? 0.6 : 1;
    g.beginPath();
    g.moveTo(LEFT, y);
    g.lineTo(right, y);
    g.stroke();
    g.globalAlpha = 1;
    g.fillStyle = palette.muted;
    g.fillText(scale.log ? powerText(v) : tickText(v, step), LEFT - 6,
      clamp(y, scale.top + 5, scale.top + panelHeight - 4));
  }
  g.strokeStyle = palette.line;
  g.strokeRect(LEFT + 0.5, scale.top + 0.5, right - LEFT - 1, panelHeight - 1);
}

/** What the panel shows and what it comes to; on a narrow screen only the beginning of that. */
function drawPanelLabel(g, panel, y, right) {
  const text = [panel.label, panel.unit ? `[${panel.unit}]` : ''].filter(Boolean).join(' ');
  g.textBaseline = 'top';
  g.textAlign = 'left';
  g.fillStyle = palette.ink;
  g.fillText(text, LEFT, y);
  const room = right - LEFT - g.measureText(text).width - 12;
  const full = panel.summary || '';
  const fits = [full, full.split(', ')[0]].find((t) => g.measureText(t).width <= room) || '';
  g.textAlign = 'right';
  g.fillStyle = palette.muted;
  g.fillText(fits, right, y);
}

/** Shades the times at which the filter did not call itself well. */
function drawHealth(g, xOf, top, right) {
  const { states, healthNames, count } = activeRun();
  for (let i = 0; i < count; i++) {
    const health = states.health[i], first = i;
    while (i + 1 < count && states.health[i + 1] === health) i++;
    const name = healthNames[health];
    if (name === 'ok') continue;
    const from = Math.max(LEFT, xOf(states.t[first]));
    const to = Math.min(right, Math.max(from + 1, xOf(states.t[Math.min(i + 1, count - 1)])));
    if (to <= from) continue;
    g.globalAlpha = 0.16;
    g.fillStyle = name === 'lost' ? palette.bad : palette.warn;
    g.fillRect(from, top, to - from, panelHeight);
    g.globalAlpha = 1;
  }
}

function drawSeries(g, series, x, scale) {
  const n = activeRun().count;
  const colour = palette[series.colour] || palette.estimate;
  if (series.style === 'band') return drawBand(g, series, x, scale, n, colour);
  if (series.style === 'area') return drawArea(g, series, x, scale, n, colour);
  g.strokeStyle = colour;
  g.lineWidth = series.style === 'level' ? 1 : 1.4;
  g.setLineDash(series.dash || (series.style === 'level' ? [5, 4] : []));
  const y = (i) => (Number.isFinite(at(series.values, i)) ? scale.y(at(series.values, i)) : NaN);
  polyline(g, n, x, y);
  g.setLineDash([]);
  if (n === 1) drawDot(g, x(0), scale.y(at(series.values, 0)), colour);
}

function drawDot(g, x, y, colour) {
  if (!Number.isFinite(y)) return;
  g.fillStyle = colour;
  g.beginPath();
  g.arc(x, y, 3, 0, 2 * Math.PI);
  g.fill();
}

/** Fills between low and high; each gap in the numbers ends a piece. */
function drawBand(g, series, x, scale, n, colour) {
  const known = (i) => Number.isFinite(at(series.low, i)) && Number.isFinite(at(series.high, i));
  for (let i = 0; i < n; i++) {
    if (!known(i)) continue;
    let end = i;
    while (end + 1 < n && known(end + 1)) end++;
    fillBetween(g, series, x, scale, i, end, colour);
    i = end;
  }
}

function fillBetween(g, series, x, scale, from, to, colour) {
  const edge = (values, i) => [x(i), scale.y(at(values, i))];
  g.beginPath();
  for (let i = from; i <= to; i++) g.lineTo(...edge(series.high, i));
  for (let i = to; i >= from; i--) g.lineTo(...edge(series.low, i));
  g.closePath();
  g.globalAlpha = 0.28;
  g.fillStyle = colour;
  g.fill();
  g.globalAlpha = 0.75;
  g.strokeStyle = colour;
  g.lineWidth = 0.8;
  g.stroke();
  g.globalAlpha = 1;
}

function drawArea(g, series, x, scale, n, colour) {
  const base = scale.y(0);
  g.beginPath();
  g.moveTo(x(0), base);
  for (let i = 0; i < n; i++) g.lineTo(x(i), scale.y(series.values[i] || 0));
  g.lineTo(x(n - 1), base);
  g.closePath();
  g.globalAlpha = 0.4;
  g.fillStyle = colour;
  g.fill();
  g.globalAlpha = 1;
  g.strokeStyle = colour;
  g.lineWidth = 1;
  g.stroke();
}

/** The distinct entries of a plot's legend. */
function legendTexts(spec) {
  const seen = new Map();
  for (const panel of spec.panels) {
    for (const s of panel.series) {
      if (s.legend !== false && !seen.has(s.label)) {
        seen.set(s.label, { text: s.label, style: s.style, colour: s.colour });
      }
    }
  }
  return [...seen.values()];
}

function legendOf(spec) {
  const entries = legendTexts(spec);
  return make('div', { class: 'legend' }, ...entries.map((entry) =>
    make('span', { class: 'key' }, swatch(entry.style, entry.colour), entry.text)));
}

function swatch(style, colour) {
  return make('i', { class: `swatch ${style}`, style: `--c: var(--${colour || 'estimate'})` });
}
