// Numbers as a reader wants them, and small helpers to make elements. All text goes through
// textContent: a recording's name is never markup.
import { clamp } from './data';

export function number(v: unknown, digits = 3): string {
  if (typeof v !== 'number' || !Number.isFinite(v)) return '–';
  if (v === 0) return '0';
  const size = Math.abs(v);
  if (size >= 1e6 || size < 1e-4) return v.toExponential(2).replace('-', '−').replace('-', '−');
  if (Number.isInteger(v)) return grouped(v);
  const decimals = clamp(digits - 1 - Math.floor(Math.log10(size)), 0, 6);
  return grouped(v, decimals);
}

export function grouped(v: number, decimals = 0): string {
  const [whole, fraction] = Math.abs(v).toFixed(decimals).split('.');
  const text = whole.length > 4 ? whole.replace(/\B(?=(\d{3})+$)/g, '\u202f') : whole;
  const negative = v < 0 && Number(v.toFixed(decimals)) !== 0;
  return (negative ? '−' : '') + text + (fraction ? '.' + fraction : '');
}

export function fixed(v: number, decimals: number): string {
  return Number.isFinite(v) ? grouped(v, decimals) : '–';
}

export function percent(share: number): string {
  if (!Number.isFinite(share)) return '–';
  const nearlyAll = share > 0.98 && share < 1;
  return grouped(100 * share, nearlyAll ? 1 : 0) + ' %';
}

export const isNumber = (v: unknown): v is number => typeof v === 'number' && Number.isFinite(v);
export const asNumber = (v: unknown): number => (typeof v === 'number' ? v : NaN);
export const isScalar = (v: unknown): boolean =>
  v === null || ['number', 'string', 'boolean'].includes(typeof v);

/** A setting as it was given: no rounding, no grouping. */
export function plainText(v: unknown): string {
  if (v === null || v === undefined) return '–';
  return typeof v === 'object' ? JSON.stringify(v) : String(v);
}

/** {a: {b: 1}} → {'a.b': '1'}; lists become text. */
export function flattened(value: unknown, prefix = '', out: Record<string, string> = {}):
    Record<string, string> {
  for (const [key, v] of Object.entries(value ?? {})) {
    const path = prefix ? prefix + '.' + key : key;
    if (v && typeof v === 'object' && !Array.isArray(v)) flattened(v, path, out);
    else out[path] = Array.isArray(v) ? v.map(plainText).join(', ') : plainText(v);
  }
  return out;
}

export function titleCase(name: string): string {
  const words = name.replace(/_/g, ' ').trim();
  return words.charAt(0).toUpperCase() + words.slice(1);
}

/** Puts a text into an element, where it is another: one that stays costs the browser nothing. */
export function setText(element: Element, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}

type Attribute = string | number | null | undefined | (() => void);
export type Child = Node | string | null | undefined;

/** An element: make('p', {class: 'muted'}, 'text', child…). */
export function make<K extends keyof HTMLElementTagNameMap>(tag: K,
    attributes: Record<string, Attribute> = {}, ...children: Child[]): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === 'function') element.addEventListener(name.slice(2), value);
    else if (value !== null && value !== undefined) element.setAttribute(name, String(value));
  }
  element.append(...children.filter((c): c is Node | string => c !== null && c !== undefined));
  return element;
}

/** An element that the page's html has for certain. */
export function byId<T extends HTMLElement = HTMLElement>(id: string): T {
  const element = document.getElementById(id);
  if (!element) throw new Error(`the page has no #${id}`);
  return element as T;
}

/** A line, band or area of a legend; the colour is a variable of the style sheet. */
export function swatch(style: string, colour = 'estimate'): HTMLElement {
  return make('i', { class: `swatch ${style}`, style: `--c: var(--${colour})` });
}

/** An entry of a legend that can be switched off. */
export function toggle(sign: Node, label: Child, on: boolean, change: (on: boolean) => void):
    HTMLElement {
  const box = make('input', { type: 'checkbox' });
  box.checked = on;
  box.addEventListener('change', () => change(box.checked));
  return make('label', { class: 'key toggle' }, box, sign, label);
}

export function button(text: string, title: string, onclick: () => void): HTMLElement {
  return make('button', { type: 'button', title, onclick }, text);
}
