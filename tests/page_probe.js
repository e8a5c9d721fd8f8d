// Uses the report page as a reader would and says in the console what worked. Appended to a copy of
// the page by page_browser_check.sh. Every line but "PROBE ok: …" is a failure.
(() => {
  const byId = (id) => document.getElementById(id);
  const check = (name, passed) => console.log(`PROBE ${passed ? 'ok' : 'FAILED'}: ${name}`);
  // Drawing waits for a frame of the screen, which a busy machine delivers late.
  const frame = () => new Promise((done) => requestAnimationFrame(done));
  const pause = (ms) => new Promise((done) => setTimeout(done, ms));
  const rest = async () => { await pause(60); await frame(); await pause(60); };
  const picture = (canvas) => canvas.toDataURL();

  const pointer = (element, type, x, y, more = {}) => element.dispatchEvent(new PointerEvent(type, {
    bubbles: true, pointerType: 'mouse', pointerId: 1, button: 0,
    clientX: element.getBoundingClientRect().left + x,
    clientY: element.getBoundingClientRect().top + y, ...more }));
  const key = (element, name) =>
    element.dispatchEvent(new KeyboardEvent('keydown', { key: name, bubbles: true }));

  const colours = (canvas) => {
    const data = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
    return new Set(new Uint32Array(data.buffer).filter((_, i) => i % 7 === 0)).size;
  };

  function looksRight() {
    const name = JSON.parse(byId('report-data').textContent).runs[0].name;
    check('the name is shown as text', byId('run-name').textContent === (name || 'Chasles'));
    check('nothing came in with a name',
      window.hostile === undefined && !document.querySelector('img'));
    check('nothing was loaded', performance.getEntriesByType('resource').length === 0);
    check('nothing sticks out to the side',
      document.documentElement.scrollWidth <= document.documentElement.clientWidth);
    const canvases = [...document.querySelectorAll('canvas')].filter((c) => c.offsetParent !== null);
    check('there are plots', canvases.length >= 5);
    for (const canvas of canvases) {
      const label = canvas.getAttribute('aria-label') || '';
      check(`drawn: ${label.slice(0, 24)}`, colours(canvas) > 3);
    }
    const text = document.body.innerText;
    check('no number is NaN or undefined', !/\bNaN\b|undefined|Infinity/.test(text));
  }

  async function timeCursor() {
    const plot = document.querySelector('.plot canvas'), map = byId('map');
    const before = [byId('time-text').textContent, picture(map)];
    pointer(plot, 'pointermove', plot.clientWidth * 0.4, 60);
    await rest();
    check('a plot moves the cursor', byId('time-text').textContent !== before[0]);
    check('the map shows the pose of the cursor', picture(map) !== before[1]);
    const value = Number(byId('time').value);
    key(plot, 'ArrowLeft');
    await rest();
    check('the left arrow goes back a frame', Number(byId('time').value) === value - 1);
  }

  async function timeSpan() {
    const plot = document.querySelector('.plot canvas');
    pointer(plot, 'pointerdown', 100, 60);
    pointer(plot, 'pointermove', 200, 60);
    pointer(plot, 'pointerup', 200, 60);
    await rest();
    check('dragging zooms in time', !byId('zoom-reset').hidden);
    key(plot, 'Escape');
    await rest();
    check('escape shows all times', byId('zoom-reset').hidden);
  }

  async function mapMoves() {
    const map = byId('map');
    const wheel = () => map.dispatchEvent(new WheelEvent('wheel', { deltaY: -300, bubbles: true,
      cancelable: true, clientX: map.getBoundingClientRect().left + 150,
      clientY: map.getBoundingClientRect().top + 150 }));
    check('the wheel scrolls the page at first', wheel() === true && !byId('map-hint').hidden);
    map.focus();
    const before = picture(map);
    check('the wheel zooms after a click', wheel() === false);
    await rest();
    check('zooming changes the picture', picture(map) !== before);
    key(map, '0');
    await rest();
    check('0 shows everything', picture(map) === before);
    byId('map-view').value = 'side';
    byId('map-view').dispatchEvent(new Event('change'));
    await rest();
    check('the side view differs', picture(map) !== before);
    byId('map-view').value = 'top';
    byId('map-view').dispatchEvent(new Event('change'));
  }

  async function landmarkTip() {
    const map = byId('map'), tip = byId('map-tip');
    for (let y = 20; y < map.clientHeight && tip.hidden; y += 9) {
      for (let x = 20; x < map.clientWidth && tip.hidden; x += 9) pointer(map, 'pointermove', x, y);
    }
    await rest();
    check('a landmark tells its numbers', !tip.hidden && /Landmark \d+/.test(tip.textContent) &&
      tip.textContent.includes('σ'));
    const box = tip.getBoundingClientRect(), frame = map.getBoundingClientRect();
    check('the numbers stay within the map', box.left >= frame.left && box.right <= frame.right &&
      box.top >= frame.top && box.bottom <= frame.bottom);
  }

  /** The runs of one recording on their truth: only where the data has them. */
  async function overview() {
    const panel = byId('overview'), map = byId('overview-map');
    const scenes = JSON.parse(byId('report-data').textContent).scenes;
    const mine = scenes.find((s) => s.runs.some((r) => r.run === 0));
    check('the overview is there with several runs or a plan', panel.hidden === !mine);
    if (!mine) return;
    check('its table has a row a run',
      byId('overview-table').querySelectorAll('tbody tr').length === mine.runs.length);
    const labels = [...panel.querySelectorAll('.legend .key')].map((key) => key.textContent);
    check('each line has a name of its own', new Set(labels).size === labels.length);
    const before = picture(map), select = byId('overview-factor');
    const choose = async (value) => {
      select.value = value;
      select.dispatchEvent(new Event('change'));
      await rest();
    };
    await choose('20');
    check('deviations are drawn larger', picture(map) !== before);
    await choose('1');
    check('and true to scale again', picture(map) === before);
    const boxes = panel.querySelectorAll('.legend input');
    boxes[boxes.length - 1].click();
    await rest();
    check('its legend hides a run', picture(map) !== before);
    boxes[boxes.length - 1].click();
    map.focus();
    key(map, '+');
    await rest();
    check('it zooms', picture(map) !== before);
    key(map, '0');
    await rest();
    check('it shows everything again', picture(map) === before);
  }

  async function choices() {
    const map = byId('map'), before = picture(map);
    const box = document.querySelector('#map-legend input');
    box.click();
    await rest();
    check('the legend hides a layer', picture(map) !== before);
    box.click();
    const theme = document.documentElement.dataset.theme;
    byId('theme-button').click();
    await rest();
    check('the theme changes', document.documentElement.dataset.theme !== theme);
    byId('theme-button').click();
    await rest();
  }

  async function use() {
    await rest();
    looksRight();
    await timeCursor();
    await timeSpan();
    await mapMoves();
    if (document.querySelectorAll('#map-legend .dots').length) await landmarkTip();
    await overview();
    await choices();
    check('done', true);
  }
  use().catch((error) => check(String(error), false));
})();
