// Starts the page of a calibration.
import '../styles/page.css';
import '../styles/calibration.css';

import { camerasContent } from './calibration_cameras';
import type { CamerasData } from './calibration_data';
import { type NoiseData, noiseContent } from './calibration_noise';
import { pageData } from './data';
import { byId, make } from './format';
import { startTheme } from './theme';

const data = pageData() as CamerasData | NoiseData;
const { title, line, cards, panels } = data.kind === 'noise' ? noiseContent(data) : camerasContent(data);

startTheme();
byId('run-name').textContent = title;
byId('run-line').textContent = line;
byId('cards').replaceChildren(...cards.map(({ label, value, unit, meaning }) =>
  make('div', { class: 'card' }, make('div', { class: 'card-label' }, label),
    make('div', { class: 'card-value' }, value, make('span', { class: 'unit' }, unit)),
    make('div', { class: 'muted small' }, meaning))));
byId('panels').replaceChildren(...panels);
