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
import pathlib
import shutil
import typing

from studies import pages
from studies.pages import fill, number, take_picture
from studies.program import CONFIGS, LOST, ROOT, Arguments, chasles, parser, sets

OUT = ROOT / "out/walk"
STUDY, PAPERS, PICTURE = ROOT / "studies/pixels.md", ROOT / "docs/papers.md", ROOT / "docs/images/walk.png"
MARKERS = {STUDY: ("walk",), PAPERS: ("ks-walk",)}
NAV = sets("nav_attitude=true", "guessed_depth_observations=12")
COMPOSED = [*NAV, *sets("composition_interval=1")]
# The run's name: recording, chart, settings.
RUNS: dict[str, tuple[str, str, Arguments]] = {
    "standard": ("recording", "standard", COMPOSED),
    "left-se3": ("recording", "left-se3", COMPOSED),
    "right-se3": ("recording", "right-se3", COMPOSED),
    "right-sen3": ("recording", "right-sen3", COMPOSED),
    "not-composed": ("recording", "right-sen3", NAV),
    "simulated-tracks": ("tracks", "right-sen3", NAV),
}
# On the floor plan, by a compass, as theirs. The walk begins at its origin, with the camera turned by
# the walker's yaw_amplitude.
ON_THE_PLAN = sets("start.heading=0.03")
THEIRS: Arguments = ["--config", CONFIGS / "kleinert-stilla.yaml", *ON_THE_PLAN]
PAPER_CHARTS = ("left-se3", "right-se3", "standard")
PAPER_RUNS: dict[str, tuple[str, str, Arguments]] = {
    **{f"ks-{chart}": ("sensor", chart, THEIRS) for chart in PAPER_CHARTS},
    **{f"here-{chart}": ("sensor", chart, [*COMPOSED, *ON_THE_PLAN]) for chart in PAPER_CHARTS},
    "here-default": ("sensor", "right-sen3", ON_THE_PLAN),
}
ACCEPTED = (0, LOST)


def estimate(name: str) -> None:
    recording, chart, settings = {**RUNS, **PAPER_RUNS}[name]
    chasles("run", OUT / recording, "--chart", chart, *settings, "--threads", 1, "--quiet", "-o", OUT / name,
            accepted=ACCEPTED)


def page_data(page: pathlib.Path) -> typing.Any:
    return json.loads(page.read_text().split('id="report-data">')[1].split("</script>")[0])


def table(page: pathlib.Path) -> str:
    header = [
        "run", "ATE m", "attitude °", "NEES position", "attitude", "pose", "`nees_pose` / 6", "walked m", "resets",
        "health"
    ]
    rows = []
    data = page_data(page)
    for entry in data["scenes"][0]["runs"]:
        run = data["runs"][entry["run"]]
        s, nees = run["summary"], entry["mean_nees"]
        rows.append([run["label"], number(s["ate_posyaw_m"], 3), number(s["attitude_posyaw_deg"], 2),
                     number(nees["position"], 2, per=3), number(nees["attitude"], 2, per=3),
                     number(nees["pose"], 2, per=6), number(s["nees_pose"], 2, per=6), number(s["path_m"], 0),
                     str(s["resets"]), s["health"]])
    return pages.table(header, rows)


def main() -> None:
    parser(__doc__).parse_args()
    shutil.rmtree(OUT, ignore_errors=True)
    OUT.mkdir(parents=True)
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        scenes: list[Arguments] = [
            ["--images", "-o", OUT / "recording"], ["-o", OUT / "tracks"],
            ["--images", "--config", CONFIGS / "scene-kleinert-stilla.yaml", "-o", OUT / "sensor"]]
        list(pool.map(lambda scene: chasles("simulate", "walk", *scene, accepted=ACCEPTED), scenes))
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        list(pool.map(estimate, [*RUNS, *PAPER_RUNS]))
    show()


def show() -> None:
    page = OUT / "page.html"
    chasles("report", *(OUT / name for name in RUNS), "-o", page, accepted=ACCEPTED)
    fill(STUDY, "walk", table(page))
    take_picture(page, PICTURE)
    paper = OUT / "kleinert-stilla.html"
    chasles("report", *(OUT / name for name in PAPER_RUNS), "-o", paper, accepted=ACCEPTED)
    fill(PAPERS, "ks-walk", table(paper))


if __name__ == "__main__":
    main()
