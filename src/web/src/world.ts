// The panel of the scene and the map: which of them is shown, its legend and its choices.
import { downloadPng } from './canvas';
import { fileName } from './files';
import { byId } from './format';
import { downloadLandmarks, layersKey, layersText, MapPanel, showMapLegend } from './map';
import { layerShown, type MapOptions } from './map_draw';
import { knowsInitial } from './map_initial';
import { activeRun } from './runs';
import { downloadSavedMap } from './saved_map_draw';
import { ScenePanel } from './scene';
import { app, listen, notify } from './store';
import { canDraw } from './webgl';

/** Views of the scene; all others are planes of the map. */
const SCENE_VIEWS = ['orbit', 'above', 'follow'];

/** Shows or hides an element that not every page has. */
function show(id: string, shown: boolean): void {
  const element = document.getElementById(id);
  if (element) element.hidden = !shown;
}

export class World {
  private readonly options: MapOptions = {
    show: { estimate: true, truth: true, dead: true, plan: true, view: true, retired: true, later: true },
    colour: 'sigma', ellipses: 'auto', truth: 'first',
  };
  private readonly map = new MapPanel(this.options);
  private readonly scene = canDraw() ? new ScenePanel(this.options, () => this.map.hint()) : null;
  private readonly select = byId<HTMLSelectElement>('map-view');
  private mapShown = true;
  private shownLayers = '';

  constructor() {
    if (!this.scene) this.goWithoutScene();
    this.select.addEventListener('change', () => this.setView(this.select.value));
    this.choose('map-colour', (v) => { this.options.colour = v; });
    this.choose('map-truth', (v) => { this.options.truth = v; });
    this.choose('map-ellipses', (v) => { this.options.ellipses = v; });
    byId('map-fit').addEventListener('click', () => this.shown().fit());
    byId('map-in').addEventListener('click', () => this.shown().zoom(1.6));
    byId('map-out').addEventListener('click', () => this.shown().zoom(1 / 1.6));
    byId('map-png').addEventListener('click', () => this.savePicture());
    byId('map-csv').addEventListener('click', () => {
      const run = activeRun();
      if (run.landmarks.id.length || !run.savedMap) downloadLandmarks(run);
      else downloadSavedMap(run.name, run.savedMap);
    });
    listen('run', () => this.showRun());
    listen('rows', () => this.followLayers());
    // Paper gets the map: a scene is worth nothing where it cannot be turned.
    listen('print', () => { this.showMap(true); this.map.print(); });
    window.addEventListener('afterprint', () => this.showMap(!this.sceneChosen()));
    // The scene does not draw the initial positions, which are the result of a mapping run.
    if (app.subjects.length && layerShown(this.options, 'initial')
        && knowsInitial(activeRun().landmarks)) this.select.value = 'top';
    this.showMap(!this.sceneChosen());
  }

  private goWithoutScene(): void {
    for (const option of [...this.select.options]) {
      if (SCENE_VIEWS.includes(option.value)) option.remove();
    }
    for (const group of this.select.querySelectorAll('optgroup:empty')) group.remove();
    byId('scene-missing').hidden = false;
  }

  /** A choice that the page may not offer. */
  private choose(id: string, apply: (value: string) => void): void {
    const select = document.getElementById(id) as HTMLSelectElement | null;
    select?.addEventListener('change', () => {
      apply(select.value);
      notify('shown');
    });
  }

  private sceneChosen(): boolean {
    return this.scene !== null && SCENE_VIEWS.includes(this.select.value);
  }

  private shown(): MapPanel | ScenePanel {
    return this.scene && this.sceneChosen() ? this.scene : this.map;
  }

  private showMap(shown: boolean): void {
    this.mapShown = shown;
    byId('map').hidden = !shown;
    for (const id of ['scene', 'scene-note', 'scene-help']) byId(id).hidden = shown;
    byId('map-help').hidden = !shown;
    byId('map-tip').hidden = true;
    this.followLayers();
  }

  /** The legend has the layers that there are: the map and the scene have not the same. */
  private followLayers(): void {
    if (app.subjects.length && layersKey(this.mapShown) !== this.shownLayers) this.showRun();
  }

  private setView(view: string): void {
    this.showMap(!this.sceneChosen());
    if (this.scene && this.sceneChosen()) this.scene.setView(view);
    else this.map.setPlane(view);
  }

  private savePicture(): void {
    const { name } = activeRun(), shown = this.shown();
    // What WebGL has drawn can be read only right after it.
    shown.drawInFull();
    downloadPng(fileName(name, 'map'), shown.canvas, `Map – ${name}`,
      layersText(this.options, this.mapShown));
  }

  private showRun(): void {
    const run = activeRun(), bare = run.landmarks.id.length === 0;
    show('truth-field', Boolean(run.truth));
    show('map-colour-field', !bare);
    show('map-csv', !bare || run.savedMap !== null);
    show('initial-help', knowsInitial(run.landmarks));
    show('saved-help', run.savedMap !== null);
    this.shownLayers = layersKey(this.mapShown);
    showMapLegend(this.options, this.mapShown, () => notify('shown'));
  }
}
