// Starts the page of a study: reads the data, builds the parts, keeps them together.
import 'uplot/dist/uPlot.min.css';
import '../styles/page.css';
import '../styles/study.css';

import { pageData } from './data';
import { asNumber, byId, grouped, isNumber, isScalar, number } from './format';
import { startPicker } from './header';
import { followStore } from './plot_list';
import { app, listen, setActive } from './store';
import { activeStudy, decodeStudy, figuresOf, labelStudies, paperPlace, type RawStudy } from './studies';
import { boxPlots, showBoxes } from './study_boxes';
import { colourFilters, showFilterLegend, startFilterButtons } from './study_colours';
import { StudyMap } from './study_map';
import { showOutliers } from './study_outliers';
import { refreshPlots, showStudyPlots } from './study_plots';
import { showFilterSettings, showScene, showStudyCards, showStudyRemarks, showStudyTables }
  from './study_tables';
import { startTheme } from './theme';

function showStudyLine(): void {
  const study = activeStudy(), s = study.summary, { t } = study;
  const parts = [study.single ? 'one run' : `${grouped(asNumber(s.runs))} runs`,
    `${grouped(study.filters.length)} filter${study.filters.length === 1 ? '' : 's'}`,
    isNumber(s.seed) && `seed ${s.seed}`, t.length > 1 && `${number(t[t.length - 1])} s`,
    study.folder];
  byId('run-line').textContent = parts.filter(Boolean).join('  ·  ');
  byId('run-name').textContent = study.name;
  byId('run-name').title = study.name;
  document.title = `${study.label} – Chasles`;
  byId('version').textContent = `Chasles${isScalar(s.version) && s.version ? ' ' + s.version : ''}.`;
  byId('plots-help').hidden = t.length < 2;
}

function showFigureTitle(): void {
  const study = activeStudy(), place = paperPlace(study);
  const means = study.single ? '' : `, means over ${grouped(asNumber(study.summary.runs))} runs`;
  byId('figure-title').textContent =
    (place ? `Figure ${place.figure}: ${place.scene}` : 'Errors and NEES over time') + means;
}

function showDiverged(): void {
  const badge = byId('health-badge');
  const count = figuresOf(activeStudy()).reduce((n, f) => n + Math.max(0, f.diverged ?? 0), 0);
  badge.textContent = count ? `⚠ ${grouped(count)} diverged` : '✓ none diverged';
  badge.className = 'badge ' + (count ? 'degraded' : 'ok');
}

const { studies: raw } = pageData() as { studies: RawStudy[] };
const studies = raw.map(decodeStudy);
labelStudies(studies);
studies.forEach(colourFilters);
app.subjects = studies;
startTheme();
startPicker();
startFilterButtons();
new StudyMap();
for (const show of [showStudyLine, showDiverged, showStudyCards, showStudyTables, showStudyPlots,
  showBoxes, showOutliers, showScene, showFilterSettings, showStudyRemarks, showFilterLegend,
  showFigureTitle]) {
  listen('run', show);
}
listen('shown', () => {
  refreshPlots();
  for (const plot of boxPlots()) plot.draw();
});
listen('theme', () => { for (const plot of boxPlots()) plot.draw(); });
listen('print', () => { for (const plot of boxPlots()) plot.drawNow(); });
followStore();
setActive(0);
