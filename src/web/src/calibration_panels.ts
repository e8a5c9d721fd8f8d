// What the pages of all calibrations are made of.
import { type Child, make } from './format';

export interface Card { label: string; value: string; unit: string; meaning: string }
export interface PageContent { title: string; line: string; cards: Card[]; panels: HTMLElement[] }

/** A panel with a heading. */
export function panel(title: string, ...content: Child[]): HTMLElement {
  const id = `panel-${title.toLowerCase().replace(/[^a-z0-9]+/g, '-')}`;
  return make('section', { class: 'panel', 'aria-labelledby': id },
    make('div', { class: 'panel-head' }, make('h2', { id }, title)), ...content);
}

const ENOUGH = 12;

/** Sentences of one kind, many of them folded; null: there are none. */
export function sentences(kind: string, badge: string, list: string[]): HTMLElement | null {
  if (!list.length) return null;
  const items = list.map((sentence) => make('li', {}, sentence));
  const rest = items.slice(ENOUGH);
  return make('div', { class: 'verdict' }, make('span', { class: `badge ${badge}` }, kind),
    make('ul', {}, ...items.slice(0, ENOUGH)),
    rest.length ? make('details', {}, make('summary', {}, `${rest.length} more`), make('ul', {}, ...rest)) : null);
}

/** A table that may be wider than the page. Its first column names the rows. */
export function table(label: string, heads: string[], rows: Child[][]): HTMLElement {
  return make('div', { class: 'scroll', tabindex: '0', role: 'region', 'aria-label': label },
    make('table', { class: 'calibration' },
      make('thead', {}, make('tr', {}, ...heads.map((head) => make(head ? 'th' : 'td', {}, head)))),
      make('tbody', {}, ...rows.map(([name, ...cells]) => make('tr', {}, make('th', { scope: 'row' }, name),
        ...cells.map((cell) => make('td', {}, cell)))))));
}

/** The figure of a row that matters most. */
export const strong = (text: string): HTMLElement => make('span', { class: 'figure' }, text);
