#!/usr/bin/env python3
"""python3 -m studies.loops [loops] [held-out]: runs with and without recognition, on rendered walks that see places again, on a block of
corridors that all look alike, and on real recordings. Without an argument both. Fills studies/recognition.md and, with
Chromium, takes the picture docs/images/loop.png. The recordings are rendered to out/loops, once: half an hour, 5 GB.
Needs NumPy."""

import concurrent.futures
import json
import math
import os
import pathlib
import shutil
import statistics
import subprocess
import sys

from studies.pages import fill, take_picture
from studies.block import Revisits

ROOT = pathlib.Path(__file__).resolve().parent.parent
CHASLES = pathlib.Path(os.environ.get("CHASLES_BINARY", ROOT / "build/release/bin/chasles"))
DATA = ROOT.parent / "shared/data/euroc"
OUT = ROOT / "out/loops"
DOCS, PICTURE = ROOT / "studies/recognition.md", ROOT / "docs/images/loop.png"
SMALL = {"rest_duration": 1, "frame_rate": 10, "focal_length": 250, "image_width": 376, "image_height": 240,
         "center_u": 187.5, "center_v": 119.5, "hall_length": 10, "sections": 8}
# The recording's name: scene, seed, settings.
SCENES = {"block-twice": ("hallway", 1, {"sections": 8}),
          "walk": ("walk", 1, {}),
          "block-12-times": ("hallway", 1, {"sections": 48, "frame_rate": 14}),
          **{f"small-{n}": ("hallway", n, SMALL) for n in range(1, 5)},
          **{f"alike-{n}": ("hallway", n, {**SMALL, "texture_period": 2.5}) for n in range(1, 5)}}
# On these nothing was chosen.
HELD_OUT = {"small": SMALL, "alike": {**SMALL, "texture_period": 2.5}}
SEEDS = range(11, 31)
FALSE = 0.5  # [m], between the true points of what was taken for one landmark
HELD_OUT_SCENES = {f"{kind}-{n}": ("hallway", n, settings) for kind, settings in HELD_OUT.items() for n in SEEDS}
REAL = {"MH_01, one camera": ("MH_01_easy_17s", ["--cameras", "mono"]),
        "MH_01, stereo": ("MH_01_easy_17s", []),
        "MH_01 backwards, one camera": ("MH_01_easy_17s", ["--cameras", "mono", "--backwards"]),
        "MH_01 backwards, stereo": ("MH_01_easy_17s", ["--backwards"]),
        "MH_03": ("MH_03_medium_27s_mono", []),
        "MH_03 backwards": ("MH_03_medium_27s_mono", ["--backwards"])}


def chasles(*arguments):
    done = subprocess.run([CHASLES, *map(str, arguments)], stdout=subprocess.DEVNULL)
    if done.returncode != 0:
        raise SystemExit(f"studies/loops.py: chasles {' '.join(map(str, arguments))} ended with {done.returncode}")


def render(name):
    if (OUT / name).exists():
        return
    scene, seed, settings = (SCENES | HELD_OUT_SCENES)[name]
    chosen = [part for key, value in settings.items() for part in ("--set", f"{key}={value}")]
    chasles("simulate", scene, "--seed", seed, *chosen, "--images", "--threads", "1", "--quiet", "-o", OUT / name)


def estimate(name, *more):
    recording, options = (DATA / REAL[name][0], REAL[name][1]) if name in REAL else (OUT / name, [])
    folder = OUT / ("runs/" + name.replace(", ", "-").replace(" ", "-"))
    summaries = []
    for recognise in ("none", "appearance"):
        run = folder.with_name(f"{folder.name}-{recognise}")
        chasles("run", recording, *options, *more, "--set", f"recognise={recognise}", "--threads", "1", "--quiet", "-o", run)
        summary = json.loads((run / "summary.json").read_text())
        summary["cpu"] = json.loads((run / "timing.json").read_text())["seconds_cpu"]
        summaries.append(summary)
    return name, summaries


def estimate_held_out(name):
    """The same, and how its recognition compares with the truth. The kept points take 20 MB a run."""
    name, summaries = estimate(name, "--keep-images", 1)
    for folder in (OUT / f"runs/{name}-{recognise}" for recognise in ("none", "appearance")):
        if folder.name.endswith("appearance"):
            revisits = Revisits(folder, (SCENES | HELD_OUT_SCENES)[name][2])
            summaries[1]["distances"], summaries[1]["returned"] = revisits.distances(), revisits.returned
            summaries[1]["recall"] = revisits.recall()
        shutil.rmtree(folder / "images")
        (folder / "features.csv").unlink()
    return name, summaries


def row(name, summaries):
    def pair(value):
        return " → ".join(map(value, summaries))

    def ate(figures):
        return f"{figures['ate_m']:.4f}"

    def nees(figures):
        return f"{figures['nees_position'] / 3:.1f}/{figures['nees_attitude'] / 3:.1f}"

    cells = [name, pair(ate), pair(lambda s: ate(s["smoothed"])), pair(lambda s: nees(s["smoothed"])),
             str(len(summaries[1]["closures"])), f"{summaries[1]['cpu'] / summaries[0]['cpu']:.2f}"]
    return "| " + " | ".join(cells) + " |"


def held_out_row(kind, results):
    """Means over the seeds; geometric ones of errors."""
    pairs = [results[f"{kind}-{n}"] for n in SEEDS]
    smoothed = [[run["smoothed"]["ate_m"] for run in pair] for pair in pairs]

    def errors(value):
        return " → ".join(f"{math.exp(statistics.mean(math.log(value(p[k])) for p in pairs)):.3f}" for k in (0, 1))

    def nees(k):
        return "/".join(f"{statistics.mean(p[k]['smoothed'][f'nees_{part}'] / 3 for p in pairs):.1f}"
                        for part in ("position", "attitude"))

    cells = [kind, errors(lambda s: s["ate_m"]), errors(lambda s: s["smoothed"]["ate_m"]), f"{nees(0)} → {nees(1)}",
             str(sum(len(p[1]["closures"]) for p in pairs)), str(sum(b > a for a, b in smoothed)),
             f"{max(c['moved_m'] for p in pairs for c in p[1]['closures']):.2f} m"]
    return "| " + " | ".join(cells) + " |"


def recall_cells(found):
    """Of (seconds to the first one, whether there is one in each piece)."""
    pieces = [piece for _, run in found for piece in run]
    return [f"{sum(first <= 2 for first, _ in found)} / {sum(first <= 5 for first, _ in found)} of {len(found)}",
            f"{100 * statistics.mean(pieces):.0f} % of {len(pieces)}"]


def truth_row(kind, results):
    runs = [results[f"{kind}-{n}"][1] for n in SEEDS]
    distances = [d for run in runs for d in run["distances"]]
    cells = [kind, f"{sum(run['returned'] for run in runs)} ({sum(run['returned'] for run in runs) - len(distances)})",
             f"{statistics.median(distances):.3f} m", f"{max(distances):.2f} m", str(sum(d > FALSE for d in distances)),
             *recall_cells([run["recall"]["found"] for run in runs]), *recall_cells([run["recall"]["back"] for run in runs])]
    return "| " + " | ".join(cells) + " |"


def loops_part(pool):
    list(pool.map(render, SCENES))
    results = dict(pool.map(estimate, [*SCENES, *REAL]))
    head = ["| recording | ATE m | of the smoothed path | its NEES, position/attitude | closures | time |",
            "|---|---|---|---|---|---|"]
    fill(DOCS, "loops", "\n".join(head + [row(name, both) for name, both in results.items()]))
    page = OUT / "page.html"
    chasles("report", OUT / "runs/block-twice-none", OUT / "runs/block-twice-appearance", "-o", page)
    take_picture(page, PICTURE, 20)


def held_out_part(pool):
    list(pool.map(render, HELD_OUT_SCENES))
    results = dict(pool.map(estimate_held_out, HELD_OUT_SCENES))
    head = ["| recordings | ATE m | of the smoothed path | its NEES, position/attitude | closures | worse paths | "
            "largest jump |", "|---|---|---|---|---|---|---|"]
    fill(DOCS, "held-out", "\n".join(head + [held_out_row(kind, results) for kind in HELD_OUT]))
    head = ["| recordings | landmarks returned (rejected later) | distance of the true points, median | largest | "
            f"above {FALSE} m | recognised within 2 / 5 s | pieces recognised | first closure within 2 / 5 s | "
            "pieces with a returned landmark |", "|---|---|---|---|---|---|---|---|---|"]
    fill(DOCS, "revisits", "\n".join(head + [truth_row(kind, results) for kind in HELD_OUT]))


PARTS = {"loops": loops_part, "held-out": held_out_part}


def main():
    (OUT / "runs").mkdir(parents=True, exist_ok=True)
    with concurrent.futures.ThreadPoolExecutor(int(os.environ.get("JOBS", 2))) as pool:
        for part in sys.argv[1:] or PARTS:
            PARTS[part](pool)


if __name__ == "__main__":
    main()
