// Uses the page of a study as a reader would and says in the console what worked. Appended to a copy
// of the page by page_browser_check.sh. Every line but "PROBE ok: …" is a failure.
(() => {
  const byId = (id) => document.getElementById(id);
  const check = (name, passed) => console.log(`PROBE ${passed ? 'ok' : 'FAILED'}: ${name}`);
  // Drawing waits for a frame of the screen, which a busy machine delivers late.
  const frame = () => new Promise((done) => requestAnimationFrame(done));
  const pause = (ms) => new Promise((done) => setTimeout(done, ms));
  const rest = async () => { await pause(60); await frame(); await pause(60); };
  const picture = (canvas) => canvas.toDataURL();
  const data = JSON.parse(byId('report-data').textContent).studies;

  const pointer = (element, type, x, y) => element.dispatchEvent(new PointerEvent(type, {
    bubbles: true, pointerType: 'mouse', pointerId: 1, button: 0,
    clientX: element.getBoundingClientRect().left + x,
    clientY: element.getBoundingClientRect().top + y }));

  const colours = (canvas) => {
    const pixels = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
    return new Set(new Uint32Array(pixels.buffer).filter((_, i) => i % 7 === 0)).size;
  };
  const isShown = (element) => element.offsetParent !== null;

  function looksRight(study) {
    const name = study.summary.name || study.folder;
    check('the name is shown as text', byId('run-name').textContent === name);
    check('nothing came in with a name',
      window.hostile === undefined && !document.querySelector('img'));
    check('nothing was loaded', performance.getEntriesByType('resource').length === 0);
    check('nothing sticks out to the side',
      document.documentElement.scrollWidth <= document.documentElement.clientWidth);
    const canvases = [...document.querySelectorAll('canvas')].filter(isShown);
    check('there are plots', canvases.length >= 5);
    for (const canvas of canvases) {
      const label = canvas.getAttribute('aria-label') || '';
      check(`drawn: ${label.slice(0, 24)}`, colours(canvas) > 3);
    }
    for (const table of ['nees-table', 'error-table']) {
      check(`${table} has a row a filter`,
        byId(table).querySelectorAll('tbody tr').length === study.filters.length);
    }
    check('the top view is there with the truth', isShown(byId('map')) === Boolean(study.truth));
    const several = !study.single_run;
    check('distributions are there with several runs', isShown(byId('boxes')) === several);
    if (several) check('the outlier is listed', 
      [...byId('outliers').querySelectorAll('td')].some((cell) => cell.textContent === '3'));
    const text = document.body.innerText;
    check('no number is NaN or undefined', !/\bNaN\b|undefined|Infinity|\bnull\b/.test(text));
  }

  async function timeCursor() {
    const plot = document.querySelector('#plots canvas');
    const values = () => document.querySelector('#plots .readout').textContent;
    const before = values();
    pointer(plot, 'pointermove', plot.clientWidth * 0.4, 60);
    await rest();
    check('a plot moves the cursor', values() !== before);
    pointer(plot, 'pointerdown', 100, 60);
    pointer(plot, 'pointermove', 200, 60);
    pointer(plot, 'pointerup', 200, 60);
    await rest();
    check('dragging zooms in time', !byId('zoom-reset').hidden);
    byId('zoom-reset').click();
    await rest();
    check('all times again', byId('zoom-reset').hidden);
  }

  async function choices() {
    const canvases = [...document.querySelectorAll('canvas')].filter(isShown);
    const before = canvases.map(picture);
    document.querySelector('#filters-legend input').click();
    await rest();
    check('a filter is taken out of every figure',
      canvases.every((canvas, k) => picture(canvas) !== before[k]));
    byId('no-filters').click();
    await rest();
    byId('all-filters').click();
    await rest();
    check('and comes back', picture(canvases[0]) === before[0]);
    const theme = document.documentElement.dataset.theme;
    byId('theme-button').click();
    await rest();
    check('the theme changes', document.documentElement.dataset.theme !== theme &&
      picture(canvases[0]) !== before[0]);
    byId('theme-button').click();
    await rest();
  }

  async function mapMoves() {
    const map = byId('map'), before = picture(map);
    byId('map-in').click();
    await rest();
    check('zooming changes the map', picture(map) !== before);
    byId('map-fit').click();
    await rest();
    check('and shows everything again', picture(map) === before);
  }

  async function dots() {
    const canvas = document.querySelector('#boxes canvas');
    const readout = document.querySelector('#boxes .readout');
    for (let y = 8; y < canvas.clientHeight && !readout.textContent; y += 4) {
      for (let x = 4; x < canvas.clientWidth && !readout.textContent; x += 8) {
        pointer(canvas, 'pointermove', x, y);
      }
    }
    check('a dot tells its run', /run \d+/.test(readout.textContent));
  }

  async function use() {
    await rest();
    looksRight(data[0]);
    if (data[0].summary.scene) {
      await timeCursor();
      await choices();
    }
    if (data[0].truth) await mapMoves();
    if (!data[0].single_run) await dots();
    if (data.length > 1) {
      byId('run-select').value = 1;
      byId('run-select').dispatchEvent(new Event('change'));
      await rest();
      looksRight(data[1]);
    }
    check('done', true);
  }
  use().catch((error) => check(String(error), false));
})();
