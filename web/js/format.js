// Numbers as a reader wants them, and small helpers to make elements. All text goes through
// textContent: a recording's name is never markup.

function number(v, digits = 3) {
  if (v === null || v === undefined || !Number.isFinite(v)) return '–';
  if (v === 0) return '0';
  const size = Math.abs(v);
  if (size >= 1e6 || size < 1e-4) return v.toExponential(2).replace('-', '−').replace('-', '−');
  if (Number.isInteger(v)) return grouped(v);
  const decimals = clamp(digits - 1 - Math.floor(Math.log10(size)), 0, 6);
  return grouped(v, decimals);
}

function grouped(v, decimals = 0) {
  const [whole, fraction] = Math.abs(v).toFixed(decimals).split('.');
  const text = whole.length > 4 ? whole.replace(/\B(?=(\d{3})+$)/g, '\u202f') : whole;
  const negative = v < 0 && Number(v.toFixed(decimals)) !== 0;
  return (negative ? '−' : '') + text + (fraction ? '.' + fraction : '');
}

function fixed(v, decimals) {
  return Number.isFinite(v) ? grouped(v, decimals) : '–';
}

function percent(share) {
  if (!Number.isFinite(share)) return '–';
  const nearlyAll = share > 0.98 && share < 1;
  return grouped(100 * share, nearlyAll ? 1 : 0) + ' %';
}

/** An element: make('p', {class: 'muted'}, 'text', child…). */
function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else if (value !== null && value !== undefined) element.setAttribute(name, value);
  }
  element.append(...children.filter((c) => c !== null && c !== undefined));
  return element;
}

const byId = (id) => document.getElementById(id);

/** A name that is safe as a file's name. */
function fileName(...parts) {
  const clean = parts.join('-').replace(/[^A-Za-z0-9._-]+/g, '_').replace(/^[._]+/, '');
  return clean.slice(0, 80) || 'chasles';
}

function download(name, blob) {
  const link = make('a', { href: URL.createObjectURL(blob), download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

/** Columns [{label, values}] as a csv file; quotes and leading = + - @ of a label are defused. */
function downloadCsv(name, columns) {
  const quoted = (label) => '"' + label.replace(/^[=+@-]/, "'$&").replace(/"/g, '""') + '"';
  const rows = [columns.map((c) => quoted(c.label)).join(',')];
  const n = Math.max(0, ...columns.map((c) => c.values.length));
  for (let i = 0; i < n; i++) rows.push(columns.map((c) => csvCell(c.values[i])).join(','));
  download(name + '.csv', new Blob([rows.join('\n') + '\n'], { type: 'text/csv' }));
}

function csvCell(v) {
  return Number.isFinite(v) ? String(Number(v.toPrecision(9))) : '';
}
