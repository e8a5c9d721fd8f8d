#!/usr/bin/env python3
"""python3 -m studies.closure [RUNS]: 100 simulated walks, twice around a block, in every error chart, with and without landmarks that
return by their ids. Fills studies/recognition.md. A quarter of an hour. Needs NumPy."""

import json
import os
import pathlib
import statistics
import subprocess
import sys
import textwrap

import numpy

from studies.pages import fill

ROOT = pathlib.Path(__file__).resolve().parent.parent
CHASLES = pathlib.Path(os.environ.get("CHASLES_BINARY", ROOT / "build/release/bin/chasles"))
OUT = ROOT / "out/closure"
DOCS = ROOT / "studies/recognition.md"
CHARTS = ("right-sen3", "standard", "left-se3", "right-se3")
SCENE = {"sections": 8, "keep_ids": "true", "hall_length": 10, "hall_width": 8, "frame_rate": 10}
DOF = {"nees_position": 3, "nees_attitude": 3, "nees_pose": 6}
FIGURES = ("position_error_m", "attitude_error_deg", *DOF)


def study(recognise, runs):
    """Of every chart: figures by name, [run, second], of the filter and of the smoothed path."""
    settings = [f"--scene-set={key}={value}" for key, value in SCENE.items()]
    subprocess.run([CHASLES, "montecarlo", "hallway", "--runs", str(runs), "--workers", "1", "--charts", ",".join(CHARTS),
                    "--landmarks", "inverse-depth", "--init", "multi-view", *settings, "--set", f"recognise={recognise}",
                    "--set", "exact_map=true", "--quiet", "--resume", "-o", OUT / recognise],
                   check=True, stdout=subprocess.DEVNULL)
    found = {chart: {"seconds": [], "smoothed": []} for chart in CHARTS}
    with open(OUT / recognise / "trials.jsonl") as lines:
        for line in map(json.loads, lines):
            if line["diverged"]:
                raise SystemExit(f"studies/closure.py: run {line['run']} of {line['filter']} diverged")
            for part, runs_of in found[line["filter"].split("+")[0]].items():
                runs_of.append(line[part])
    return {chart: {part: {name: numpy.array([run[name] for run in runs_of], float) for name in FIGURES}
                    for part, runs_of in parts.items()} for chart, parts in found.items()}


def band(dof, runs):
    """95 % of the mean of `runs` values of chi squared, by its degrees of freedom (Wilson & Hilferty)."""
    n = dof * runs
    return [(1 - 2 / (9 * n) + z * (2 / (9 * n)) ** 0.5) ** 3 for z in
            map(statistics.NormalDist().inv_cdf, (0.025, 0.975))]


def main():
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    open_loop, closed = study("none", runs), study("ids", runs)
    low, high = band(6, runs)
    nees_rows, error_rows, closures = [], [], set()
    for chart in CHARTS:
        both = {"none": open_loop[chart], "ids": closed[chart]}
        errors = [figures["seconds"]["position_error_m"] for figures in both.values()]
        closure = int(numpy.argmax((errors[0] != errors[1]).any(0)))  # the first landmarks return in this second
        closures.add(closure)
        columns = [("seconds", s) for s in (closure - 1, closure, closure + 1, closure + 10, -1)]
        columns += [("smoothed", s) for s in (closure // 2, closure - 1)]

        def means(figures, name):
            return [numpy.mean(figures[part][name][:, s]) / DOF.get(name, 1) for part, s in columns]

        for recognise, figures in both.items():
            cells = [f"{pose:.2f} ({position:.2f}/{attitude:.2f})" for pose, position, attitude in
                     zip(*(means(figures, name) for name in ("nees_pose", "nees_position", "nees_attitude")))]
            mean = numpy.mean(figures["smoothed"]["nees_pose"], 0) / 6
            mean = mean[~numpy.isnan(mean)]
            cells.append(f"{100 * numpy.mean((low <= mean) & (mean <= high)):.0f} %")
            nees_rows.append(f"| {chart} | {recognise} | " + " | ".join(cells) + " |")
        cells = [f"{a:.3f} → {b:.3f}" for a, b in zip(*(means(figures, "position_error_m") for figures in both.values()))]
        ratio = [numpy.mean(e[:, closure + 1:], 0) for e in errors]
        cells.append(f"{numpy.mean(ratio[1]) / numpy.mean(ratio[0]):.2f} ({max(ratio[1] / ratio[0]):.2f})")
        error_rows.append(f"| {chart} | " + " | ".join(cells) + " |")
    instants = "before | at closure | 1 s later | 10 s later | at the end | smoothed, middle of round 1 | smoothed, before"
    nees_head = [f"| chart | recognition | {instants} | smoothed, seconds in the band |", "|---" * 10 + "|"]
    error_head = [f"| chart | {instants} | ratio after closure, mean (largest) |", "|---" * 9 + "|"]
    bands = [f"{least:.2f} to {most:.2f}" for least, most in (band(3, runs), band(6, runs))]
    note = (f"{runs} runs in every chart; the first landmarks return in second {', '.join(map(str, sorted(closures)))}. "
            f"95 % bands of the mean: {bands[1]} for the pose, {bands[0]} for position and attitude.")
    fill(DOCS, "closure", "\n".join(["NEES of the pose (position/attitude), by degree of freedom:", "", *nees_head, *nees_rows,
                                     "", "Mean position error in m, without → with recognition:", "", *error_head,
                                     *error_rows, "", textwrap.fill(note, 100)]))


if __name__ == "__main__":
    main()
