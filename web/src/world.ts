// The panel of the map: which view of it is shown, its legend and its choices.
import { byId } from './format';
import { downloadLandmarks, layersText, MapPanel, showMapLegend } from './map';
import type { MapOptions } from './map_draw';
import { activeRun } from './runs';
import { listen, notify } from './store';

export class World {
  private readonly options: MapOptions = {
    show: { estimate: true, truth: true, dead: true, landmarks: true },
    colour: 'sigma', ellipses: 'auto', truth: 'first',
  };
  private readonly map = new MapPanel(this.options);

  constructor() {
    this.choose('map-view', (v) => this.map.setPlane(v));
    this.choose('map-colour', (v) => { this.options.colour = v; });
    this.choose('map-truth', (v) => { this.options.truth = v; });
    byId('map-png').addEventListener('click', () =>
      this.map.savePicture(layersText(this.options)));
    byId('map-csv').addEventListener('click', () => downloadLandmarks(activeRun()));
    listen('run', () => this.showRun());
  }

  private choose(id: string, apply: (value: string) => void): void {
    const select = byId<HTMLSelectElement>(id);
    select.addEventListener('change', () => {
      apply(select.value);
      notify('shown');
    });
  }

  private showRun(): void {
    const run = activeRun(), bare = run.landmarks.id.length === 0;
    byId('truth-field').hidden = !run.truth;
    for (const id of ['map-colour-field', 'map-csv']) byId(id).hidden = bare;
    showMapLegend(this.options, () => notify('shown'));
  }
}
