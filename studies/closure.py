#!/usr/bin/env python3
"""python3 -m studies.closure [RUNS]: 100 simulated walks, twice around a block, in every error chart, with and
without landmarks that return by their ids. Fills studies/recognition.md. A quarter of an hour. Needs NumPy."""

import textwrap
import typing

import numpy

from studies.arrays import Array
from studies.bands import mean_band
from studies.pages import fill, table
from studies.program import ROOT, assignments, chasles, count, parser, read_json_lines, scene_sets, sets

OUT = ROOT / "out/closure"
PAGE = ROOT / "studies/recognition.md"
MARKERS = {PAGE: ("closure",)}
CHARTS = ("right-sen3", "standard", "left-se3", "right-se3")
SCENE = {"sections": 8, "keep_ids": "true", "hall_length": 10, "hall_width": 8, "frame_rate": 10}
DOF = {"nees_position": 3, "nees_attitude": 3, "nees_pose": 6}
FIGURES = ("position_error_m", "attitude_error_deg", *DOF)

Figures = dict[str, dict[str, Array]]  # of the parts "seconds" and "smoothed", by name: [run, second]


def study(recognise: str, runs: int) -> dict[str, Figures]:
    """Of every chart: the figures of the filter and of the smoothed path."""
    chasles("montecarlo", "hallway", "--runs", runs, "--workers", 1, "--charts", ",".join(CHARTS),
            "--landmarks", "inverse-depth", "--init", "multi-view", *scene_sets(*assignments(SCENE)),
            *sets(f"recognise={recognise}", "exact_map=true"), "--quiet", "--resume", "-o", OUT / recognise)
    found: dict[str, dict[str, list[typing.Any]]] = {chart: {"seconds": [], "smoothed": []} for chart in CHARTS}
    for line in read_json_lines(OUT / recognise / "trials.jsonl"):
        if line["diverged"]:
            raise SystemExit(f"studies/closure.py: run {line['run']} of {line['filter']} diverged")
        for part, runs_of in found[line["filter"].split("+")[0]].items():
            runs_of.append(line[part])
    return {chart: {part: {name: numpy.array([run[name] for run in runs_of], float) for name in FIGURES}
                    for part, runs_of in parts.items()} for chart, parts in found.items()}


def main() -> None:
    arguments = parser(__doc__)
    arguments.add_argument("runs", nargs="?", type=count, default=100, metavar="RUNS")
    runs = arguments.parse_args().runs
    open_loop, closed = study("none", runs), study("ids", runs)
    low, high = mean_band(6, runs)
    nees_rows: list[list[str]] = []
    error_rows: list[list[str]] = []
    closures: set[int] = set()
    for chart in CHARTS:
        both = {"none": open_loop[chart], "ids": closed[chart]}
        errors = [figures["seconds"]["position_error_m"] for figures in both.values()]
        closure = int(numpy.argmax((errors[0] != errors[1]).any(0)))  # the first landmarks return in this second
        closures.add(closure)
        columns = [("seconds", s) for s in (closure - 1, closure, closure + 1, closure + 10, -1)]
        columns += [("smoothed", s) for s in (closure // 2, closure - 1)]

        def means(figures: Figures, name: str) -> list[typing.Any]:
            return [numpy.mean(figures[part][name][:, s]) / DOF.get(name, 1) for part, s in columns]

        for recognise, figures in both.items():
            cells = [f"{pose:.2f} ({position:.2f}/{attitude:.2f})" for pose, position, attitude in
                     zip(*(means(figures, name) for name in ("nees_pose", "nees_position", "nees_attitude")))]
            mean = numpy.mean(figures["smoothed"]["nees_pose"], 0) / 6
            mean = mean[~numpy.isnan(mean)]
            cells.append(f"{100 * numpy.mean((low <= mean) & (mean <= high)):.0f} %")
            nees_rows.append([chart, recognise, *cells])
        cells = [
            f"{a:.3f} → {b:.3f}" for a, b in zip(*(means(figures, "position_error_m") for figures in both.values()))
        ]
        ratio = [numpy.mean(e[:, closure + 1:], 0) for e in errors]
        cells.append(f"{numpy.mean(ratio[1]) / numpy.mean(ratio[0]):.2f} ({max(ratio[1] / ratio[0]):.2f})")
        error_rows.append([chart, *cells])
    instants = [
        "before", "at closure", "1 s later", "10 s later", "at the end", "smoothed, middle of round 1",
        "smoothed, before"
    ]
    nees_head = ["chart", "recognition", *instants, "smoothed, seconds in the band"]
    error_head = ["chart", *instants, "ratio after closure, mean (largest)"]
    bands = [f"{least:.2f} to {most:.2f}" for least, most in (mean_band(3, runs), mean_band(6, runs))]
    note = (
        f"{runs} runs in every chart; the first landmarks return in second {', '.join(map(str, sorted(closures)))}. "
        f"95 % bands of the mean: {bands[1]} for the pose, {bands[0]} for position and attitude.")
    texts = ["NEES of the pose (position/attitude), by degree of freedom:", table(nees_head, nees_rows),
             "Mean position error in m, without → with recognition:", table(error_head, error_rows),
             textwrap.fill(note, 100)]
    fill(PAGE, "closure", "\n\n".join(texts))


if __name__ == "__main__":
    main()
