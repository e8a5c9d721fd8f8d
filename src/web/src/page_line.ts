// The name of what a page shows, and the line below it.
import { byId, isScalar } from './format';

export interface Subject {
  name: string;
  label: string;  // among several, and in the title of the window
  summary: Record<string, unknown>;
}

/** `facts`: the parts of the line; those that are empty are left out. */
export function showLine({ name, label, summary }: Subject, facts: unknown[]): void {
  byId('run-line').textContent = facts.filter(Boolean).join('  ·  ');
  byId('run-name').textContent = name || 'Chasles';
  byId('run-name').title = name;
  document.title = `${label} – Chasles`;
  const version = isScalar(summary.version) && summary.version ? ` ${summary.version}` : '';
  byId('version').textContent = `Chasles${version}.`;
}
