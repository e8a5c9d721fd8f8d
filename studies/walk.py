#!/usr/bin/env python3
"""python3 -m studies.walk: Kleinert & Stilla's figure 4 with a truth. It renders the whole walk through a
building, 319 m, for one camera and an IMU, with Chasles's sensors and with the paper's.

Chasles's sensors: it estimates the walk from the pixels in each error chart with the paper's
composition step, once without that step, and once from simulated tracks instead of images. It writes
out/walk/page.html, fills studies/pixels.md and, with Chromium, takes the picture docs/images/walk.png.

The paper's sensors: it estimates the walk with the paper's filter in its three charts, and with
Chasles's. It writes out/walk/kleinert-stilla.html and fills docs/papers.md."""

import concurrent.futures
import json
import os
import pathlib
import re
import shutil
import subprocess

from studies.pages import fill, take_picture

ROOT = pathlib.Path(__file__).resolve().parent.parent
CHASLES = pathlib.Path(os.environ.get("CHASLES_BINARY", ROOT / "build/release/bin/chasles"))
OUT = ROOT / "out/walk"
STUDY, PAPERS, PICTURE = ROOT / "studies/pixels.md", ROOT / "docs/papers.md", ROOT / "docs/images/walk.png"
NAV = ["--set", "nav_attitude=true", "--set", "guessed_depth_observations=12"]
COMPOSED = [*NAV, "--set", "composition_interval=1"]
# The run's name: recording, chart, settings.
RUNS = {"standard": ("recording", "standard", COMPOSED),
        "left-se3": ("recording", "left-se3", COMPOSED),
        "right-se3": ("recording", "right-se3", COMPOSED),
        "right-sen3": ("recording", "right-sen3", COMPOSED),
        "not-composed": ("recording", "right-sen3", NAV),
        "simulated-tracks": ("tracks", "right-sen3", NAV)}
# On the floor plan, by a compass, as theirs. The walk begins at its origin, with the camera turned by
# the walker's yaw_amplitude.
ON_THE_PLAN = ["--set", "start.heading=0.03"]
THEIRS = ["--config", ROOT / "studies/configs/kleinert-stilla.yaml", *ON_THE_PLAN]
PAPER_RUNS = {
    **{f"ks-{chart}": ("sensor", chart, THEIRS) for chart in ("left-se3", "right-se3", "standard")},
    **{f"here-{chart}": ("sensor", chart, [*COMPOSED, *ON_THE_PLAN]) for chart in ("left-se3", "right-se3", "standard")},
    "here-default": ("sensor", "right-sen3", ON_THE_PLAN),
}
def chasles(*arguments):
    done = subprocess.run([CHASLES, *arguments], stdout=subprocess.DEVNULL)
    if done.returncode not in (0, 4):  # 4: the estimate was lost, which is a result here
        raise SystemExit(f"studies/walk.py: chasles {' '.join(map(str, arguments))} ended with {done.returncode}")


def estimate(name):
    recording, chart, settings = {**RUNS, **PAPER_RUNS}[name]
    chasles("run", OUT / recording, "--chart", chart, *settings, "--threads", "1", "--quiet", "-o", OUT / name)


def page_data(page):
    return json.loads(re.search(r'id="report-data">(.*?)</script>', page.read_text(), re.S).group(1))


def figure(value, digits, per=1):
    return "-" if value is None else f"{value / per:.{digits}f}"


def table(page):
    rows = ["| run | ATE m | attitude ° | NEES position | attitude | pose | `nees_pose` / 6 | walked m | resets | health |",
            "|---|---|---|---|---|---|---|---|---|---|"]
    data = page_data(page)
    for entry in data["scenes"][0]["runs"]:
        run = data["runs"][entry["run"]]
        s, nees = run["summary"], entry["mean_nees"]
        cells = [figure(s["ate_posyaw_m"], 3), figure(s["attitude_posyaw_deg"], 2), figure(nees["position"], 2, 3), figure(nees["attitude"], 2, 3),
                 figure(nees["pose"], 2, 6), figure(s["nees_pose"], 2, 6), figure(s["path_m"], 0), str(s["resets"]), s["health"]]
        rows.append(f"| {run['label']} | " + " | ".join(cells) + " |")
    return "\n".join(rows)


def main():
    shutil.rmtree(OUT, ignore_errors=True)
    OUT.mkdir(parents=True)
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        for simulation in [pool.submit(chasles, "simulate", "walk", "--images", "-o", OUT / "recording"),
                           pool.submit(chasles, "simulate", "walk", "-o", OUT / "tracks"),
                           pool.submit(chasles, "simulate", "walk", "--images", "--config", ROOT / "studies/configs/scene-kleinert-stilla.yaml",
                                       "-o", OUT / "sensor")]:
            simulation.result()
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        list(pool.map(estimate, [*RUNS, *PAPER_RUNS]))
    show()


def show():
    page = OUT / "page.html"
    chasles("report", *(OUT / name for name in RUNS), "-o", page)
    fill(STUDY, "walk", table(page))
    take_picture(page, PICTURE)
    paper = OUT / "kleinert-stilla.html"
    chasles("report", *(OUT / name for name in PAPER_RUNS), "-o", paper)
    fill(PAPERS, "ks-walk", table(paper))


if __name__ == "__main__":
    main()
