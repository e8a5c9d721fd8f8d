// The command that does one run of a study again, by itself.
import type { Study } from './studies';

type Settings = Record<string, unknown>;

const PLAIN = /^[A-Za-z0-9_.,:=+-]+$/;
const quoted = (word: string) => (PLAIN.test(word) ? word : `'${word.replace(/'/g, "'\\''")}'`);

/** `option key=value` of each setting but those that have an option of their own. */
function settingsOf(option: string, settings: unknown, without: string[]): string[] {
  return Object.entries((settings ?? {}) as Settings)
    .filter(([key, value]) => !without.includes(key) && value !== null && typeof value !== 'object')
    .flatMap(([key, value]) => [option, `${key}=${String(value)}`]);
}

/** Of filter k. All settings are named, whatever the defaults of another version are. */
export function commandOf(study: Study, k: number, run: number): string {
  const { summary } = study, { figures } = study.filters[k], name = String(summary.name ?? 'SCENE');
  const { chart, landmarks, init } = (figures.settings ?? {}) as Settings;
  const chosen = Object.entries({ '--charts': chart, '--landmarks': landmarks, '--init': init,
    '--estimators': figures.estimator === 'batch' ? 'batch' : undefined })
    .flatMap(([option, value]) => (typeof value === 'string' ? [option, value] : []));
  const folder = `out/${name}-run${run}`;
  const words = ['chasles', 'compare', name, '--seed', String(summary.seed ?? 1), '--run', String(run),
    ...settingsOf('--scene-set', summary.scene, ['name', 'geometry', 'seed']),
    ...chosen, ...settingsOf('--set', figures.settings, ['chart', 'landmarks', 'init']), '-o', folder];
  return `${words.map(quoted).join(' ')} && chasles report ${quoted(folder)} -o ${
    quoted(`${folder}.html`)}`;
}
