"""Pages whose tables and pictures the scripts here make."""

import pathlib
import shutil
import subprocess
import tempfile

# Keeps only the plan view, once to scale and once with enlarged errors.
PICTURE_SCRIPT = """<style>
body > :not(main), main > :not(#overview), .map-options, .map-buttons, #overview-help { display: none !important; }
#overview-map, .copy { height: 470px !important; width: 100%; display: block; }
.map-frame { border: 0; }
.note { font-size: 14px; margin: 8px 0; }
body { padding: 0; } #overview { border: 0; border-radius: 0; }
</style><script>
addEventListener('load', () => setTimeout(() => {
  const map = document.getElementById('overview-map'), frame = map.parentElement;
  const note = (text) => Object.assign(document.createElement('p'), { className: 'note', textContent: text });
  const copy = Object.assign(document.createElement('img'), { className: 'copy', src: map.toDataURL() });
  frame.before(note('True to scale'), copy, note('Deviations from the truth FACTOR times as large'));
  const factor = document.getElementById('overview-factor');
  factor.value = 'FACTOR';
  factor.dispatchEvent(new Event('change'));
}, 500));
</script>"""


def take_picture(page, picture, factor=20):
    """The plan view of a report, with deviations enlarged by one of the page's factors."""
    browser = next(filter(None, map(shutil.which, ("chromium-headless-shell", "chromium", "chromium-browser",
                                                   "google-chrome"))), None)
    if not browser:
        print(f"no Chromium: {picture} stays as it is")
        return
    with tempfile.TemporaryDirectory() as folder:
        copy = pathlib.Path(folder) / "page.html"
        copy.write_text(page.read_text() + PICTURE_SCRIPT.replace("FACTOR", str(factor)))
        subprocess.run([browser, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
                        f"--user-data-dir={folder}/profile", "--virtual-time-budget=4000", "--window-size=1200,1300",
                        f"--screenshot={picture}", f"file://{copy}"], check=True, stderr=subprocess.DEVNULL)


def fill(page, name, text):
    """Replaces the text of the file between the markers of this name."""
    begin, end = f"<!-- {name}:begin -->\n", f"<!-- {name}:end -->"
    head, rest = page.read_text().split(begin)
    page.write_text(head + begin + text + "\n" + end + rest.split(end)[1])
