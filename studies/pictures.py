#!/usr/bin/env python3
"""python3 -m studies.pictures [run-page] [loop]: takes the pictures of README.md with Chromium, from the program as
it is: docs/images/run-page.png, the page of the walk of `make demo`, and docs/images/loop.png, twelve rounds
of a block of corridors with and without recognition. The figures of both runs go to studies/results.json,
and from there to README.md. Renders its recordings to out/pictures and out/loops, once: ten minutes, 1 GB."""

import concurrent.futures
import os
import pathlib
import shutil
import subprocess
import tempfile
import typing
import zlib

from studies import front_page
from studies.measured import measured, rounded
from studies.program import CHASLES, ROOT, Json, chasles, one_of, parser, read_json

IMAGES, OUT, LOOPS = ROOT / "docs/images", ROOT / "out/pictures", ROOT / "out/loops"
BROWSERS = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
LARGEST = 450_000  # [bytes] of a picture in the repository

# The scene hallway: the block's sides are centre lines of its corridors (studies/block.py).
BLOCK, LENGTH, WIDTH, CORRIDOR, SIDES = "block-12-times", 30, 12, 3, 4
SECTIONS = 48
FACTOR = 20  # one of the page's, that shows centimetres on a block of 30 m

# A corner of the page is red until the page is ready: a browser decodes images beside its virtual time.
NOT_READY = """<div id="not-ready" style="position:fixed;left:0;top:0;width:8px;height:8px;background:#f00;
z-index:9999"></div><script>
const ready = () => document.getElementById('not-ready').remove();
</script>"""
RED = b"\xff\x00\x00"

# The map, the camera and the errors; without what explains the page to its readers.
RUN_PAGE = """<style>
header, #cards, #overview, .tables, footer, p.muted, .map-options, #camera-legend, .small-buttons,
.plot-buttons { display: none !important; }
body { padding-top: 8px; }
</style><script>
addEventListener('load', () => setTimeout(() => {
  const time = document.getElementById('time'), atFirst = document.getElementById('time-text').textContent;
  time.value = String(Math.round(0.62 * Number(time.max)));
  time.dispatchEvent(new Event('input'));
  // The time of one frame on a machine that may have other work is no figure for a front page.
  setTimeout(() => document.querySelectorAll('#at-time dt').forEach((term) => {
    if (term.textContent === 'Time taken') {
      term.style.visibility = term.nextElementSibling.style.visibility = 'hidden';
    }
  }), 500);
  const seconds = (id) => parseFloat(document.getElementById(id).textContent);
  const waiting = setInterval(() => {
    if (document.getElementById('time-text').textContent === atFirst) return;
    // Not every frame is kept.
    if (!(Math.abs(seconds('camera-text') - seconds('time-text')) < 0.5)) return;
    clearInterval(waiting);
    setTimeout(ready, 1000);
  }, 50);
}, 1000));
</script>"""

# One run over the plan, with enlarged errors.
ONE_RUN = """<style>
body > :not(main):not(#not-ready), main > :not(#overview), .map-options, .map-buttons, #overview-help,
#overview-table, .panel-head .legend { display: none !important; }
#overview-map { height: 430px !important; width: 100%; display: block; }
.map-frame { border: 0; } body { padding: 0; background: #fff; } #overview { border: 0; box-shadow: none; }
</style><script>
addEventListener('load', () => setTimeout(() => {
  document.getElementById('overview-title').textContent = 'TITLE';
  const factor = document.getElementById('overview-factor');
  factor.value = 'FACTOR';
  factor.dispatchEvent(new Event('change'));
  document.getElementById('overview-out').click();
  setTimeout(ready, 1000);
}, 500));
</script>"""

# Pictures below each other.
ALL = "<script>addEventListener('load', () => setTimeout(ready, 200));</script>"


def take(page: pathlib.Path, script: str, picture: pathlib.Path, size: str) -> None:
    """The page as Chromium shows it, with WebGL in software: the same picture on every machine."""
    browser = next((found for name in BROWSERS if (found := shutil.which(name))), None)
    if not browser:
        raise SystemExit("studies/pictures.py: no Chromium: apt-get install chromium")
    with tempfile.TemporaryDirectory() as folder:
        copy = pathlib.Path(folder) / "page.html"
        copy.write_text(page.read_text() + NOT_READY + script)
        for budget in (15_000, 60_000, 240_000):  # [ms] of virtual time
            subprocess.run([browser, "--headless", "--no-sandbox", "--disable-gpu", "--use-gl=angle",
                            "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--hide-scrollbars",
                            f"--user-data-dir={folder}/profile",
                            f"--virtual-time-budget={budget}", f"--window-size={size}", f"--screenshot={picture}",
                            f"file://{copy}"], check=True, stderr=subprocess.DEVNULL, timeout=200)
            if first_pixel(picture) != RED:
                break
        else:
            raise SystemExit(f"studies/pictures.py: {page.name} does not become ready")
    if picture.stat().st_size > LARGEST:
        raise SystemExit(f"studies/pictures.py: {picture} has {picture.stat().st_size} bytes of at most {LARGEST}")


def first_pixel(picture: pathlib.Path) -> bytes:
    """Red, green and blue of a PNG file's corner: PNG's filters leave the first pixel as it is."""
    data, at, packed = picture.read_bytes(), 8, b""
    while at < len(data):
        length, kind = int.from_bytes(data[at:at + 4], "big"), data[at + 4:at + 8]
        packed += data[at + 8:at + 8 + length] if kind == b"IDAT" else b""
        at += 12 + length
    return zlib.decompress(packed)[1:4]


def summary(run: pathlib.Path) -> Json:
    figures: Json = read_json(run / "summary.json")
    return figures


def run_page() -> Json:
    recording, run, page = OUT / "walk", OUT / "walk-run", OUT / "walk.html"
    shutil.rmtree(run, ignore_errors=True)
    if not recording.exists():
        chasles("simulate", "walk", "--images", "--set", "walk_duration=40", "--quiet", "-o", recording)
    chasles("run", recording, "--keep-images", "--quiet", "-o", run)
    chasles("report", run, "--quiet", "-o", page)
    take(page, RUN_PAGE, IMAGES / "run-page.png", "1280,1318")
    figures = summary(run)
    keys = ["path_m", "ate_m", "nees_pose", *(f"within_3_sigma_{axis}" for axis in front_page.AXES)]
    return {"command": "chasles simulate walk --images --set walk_duration=40 -o walk; chasles run walk",
            "measured": measured(CHASLES), **{key: rounded(figures[key]) for key in keys}}


def write_plan(recording: pathlib.Path) -> None:
    """The walls of the block, about the middle of the true path."""
    truth = (recording / "mav0/state_groundtruth_estimate0/data.csv").read_text().splitlines()[1:]
    points = [[float(value) for value in line.split(",")[1:3]] for line in truth]
    middle = [(min(axis) + max(axis)) / 2 for axis in zip(*points)]
    lines = ["line,kind,x,y"]
    for number, beyond in enumerate((CORRIDOR / 2, -CORRIDOR / 2)):
        x, y = LENGTH / 2 + beyond, WIDTH / 2 + beyond
        for side_x, side_y in ((-x, -y), (x, -y), (x, y), (-x, y), (-x, -y)):
            lines.append(f"{number},wall,{middle[0] + side_x},{middle[1] + side_y}")
    (recording / "plan.csv").write_text("\n".join(lines) + "\n")


def round_the_block(recognise: str) -> tuple[pathlib.Path, Json]:
    """Page and summary of the run with this setting of `recognise`."""
    run, page = OUT / f"block-{recognise}", OUT / f"block-{recognise}.html"
    shutil.rmtree(run, ignore_errors=True)
    chasles("run", LOOPS / BLOCK, "--set", f"recognise={recognise}", "--threads", 1, "--quiet", "-o", run)
    chasles("report", run, "--quiet", "-o", page)
    return page, summary(run)


def loop() -> Json:
    recording = LOOPS / BLOCK
    if not recording.exists():
        chasles("simulate", "hallway", "--set", f"sections={SECTIONS}", "--set", "frame_rate=14", "--images", "--quiet",
                "-o", recording)
    write_plan(recording)
    with concurrent.futures.ThreadPoolExecutor(int(os.environ.get("JOBS", 2))) as pool:
        runs = list(pool.map(round_the_block, ("none", "appearance")))
    pictures = []
    for (page, figures), title in zip(runs, ("Without recognition", "With recognition")):
        pictures.append(OUT / f"{page.stem}.png")
        text = f"{title}: ATE {figures['ate_m']:.3f} m"
        take(page, ONE_RUN.replace("TITLE", text).replace("FACTOR", str(FACTOR)), pictures[-1], "900,478")
    both = OUT / "loop.html"
    tags = [f"<img style='display:block' src='file://{p}'>" for p in pictures]
    both.write_text(f"<body style='margin:0'>{''.join(tags)}")
    take(both, ALL, IMAGES / "loop.png", "900,956")
    without, with_recognition = ({"ate_m": rounded(figures["ate_m"]),
                                  "smoothed_ate_m": rounded(figures["smoothed"]["ate_m"]),
                                  "nees_pose": rounded(figures["nees_pose"]),
                                  "closures": len(figures.get("closures", []))}
                                 for _, figures in runs)
    return {"command": f"chasles simulate hallway --set sections={SECTIONS} --set frame_rate=14 --images -o block; "
                       "chasles run block --set recognise=none|appearance --threads 1",
            "measured": measured(CHASLES), "path_m": rounded(runs[0][1]["path_m"]), "rounds": SECTIONS / SIDES,
            "factor": FACTOR,
            "without": without, "with": with_recognition}


PICTURES: dict[str, tuple[str, typing.Callable[[], Json]]] = {"run-page": ("walk", run_page), "loop": ("loop", loop)}


def main() -> None:
    arguments = parser(__doc__)
    arguments.add_argument("pictures", nargs="*", type=one_of(PICTURES), metavar="PICTURE")
    pictures = arguments.parse_args().pictures or PICTURES
    OUT.mkdir(parents=True, exist_ok=True)
    for picture in pictures:
        section, make = PICTURES[picture]
        figures = make()
        front_page.save(front_page.load() | {section: figures})
    front_page.fill_pages(front_page.load())


if __name__ == "__main__":
    main()
