"""The experiments of Du's report on his three recordings, with his parameters (studies/configs/du-*.yaml):
see studies/papers.py."""

import json
import os
import pathlib
import subprocess
import sys

import numpy as np

from studies.pages import fill
from studies.papers_page import CHASLES, DOCS, PNG, ROOT, number, page, plt, svg, table

DATA = pathlib.Path(os.environ.get("CHASLES_DATA", ROOT / "../shared/data")) / "kitti_tracks"
OUT = ROOT / "out/papers/du"
PICTURE = ROOT / "docs/images/du-figure-10.png"
TESTS = ("20", "27", "42")
REPAIRED = ["--set", "reader.stale_pixels=cut", "--set", "reader.extrinsics=auto"]
STALE_CUT, EXTRINSICS_REPAIRED = REPAIRED[:2], REPAIRED[2:]
# The run's name: configuration, further options.
RUNS = {
    "task1": ("du-task1", []),
    "task2-v10": ("du-task2-v10", []),
    "task2-v1000": ("du-task2-v1000", []),
    "set1": ("du-set1", []),
    "set2": ("du-set2", []),
    "set1-repaired": ("du-set1", REPAIRED),
    "set2-repaired": ("du-set2", REPAIRED),
    "set2-stale-cut": ("du-set2", STALE_CUT),
    "set2-gated": ("du-set2", ["--set", "gate=0.999", "--set", "loose_gate=0.999"]),
    "set2-extrinsics-repaired": ("du-set2", EXTRINSICS_REPAIRED),
}
# His figures: number, run, test, title.
FIGURES = [
    *[(1 + k, "task1", test, f"EKF prediction for test {test}") for k, test in enumerate(TESTS)],
    *[(4 + k, "task2-v10", test, f"EKF mapping for test {test}, V = 10 I") for k, test in enumerate(TESTS)],
    *[(7 + k, "set1", test, f"SLAM with parameters set 1, test {test}") for k, test in enumerate(TESTS)],
    *[(10 + k, "set2", test, f"SLAM with parameters set 2, test {test}") for k, test in enumerate(TESTS)],
]
PARAMETERS = [("V", "10⁵ I", "10³ I"), ("Σ_w", "10⁻⁶ I", "10⁻⁶ I"), ("initial Σ_robot", "10⁻² I", "10⁻² I"),
              ("initial Σ_robot_LM, Σ_LM_robot", "0", "0"), ("initial Σ_LM", "10⁻² I", "10⁻² I")]


def run(name, test):
    """The figures of a run, which it makes unless its folder is there."""
    config, options = RUNS[name]
    folder = OUT / f"{name}-{test}"
    if not (folder / "summary.json").exists():
        done = subprocess.run([CHASLES, "run", DATA / f"ece276a_2018/00{test}.npz", "--truth",
                               DATA / f"ground_truth/00{test}_gt_imu_stars.tum", "--config",
                               ROOT / f"studies/configs/{config}.yaml", *options, "--quiet", "-o", folder],
                              stdout=subprocess.DEVNULL)
        if done.returncode not in (0, 4):  # 4: the estimate was lost, which is a result here
            sys.exit(f"studies/papers.py: {name} on test {test} ended with {done.returncode}")
    return json.loads((folder / "summary.json").read_text())


def path(file):
    return np.loadtxt(file, ndmin=2)[:, 1:4]


def draw(axes, name, test, title):
    """A plan view: the estimate, the truth, and with task 2 the landmarks before and after."""
    folder = OUT / f"{name}-{test}"
    run(name, test)
    estimate, truth = path(folder / "trajectory.tum"), path(folder / "truth.tum")
    if name.startswith("task2"):
        marks = np.genfromtxt(folder / "landmarks.csv", delimiter=",", names=True)
        axes.plot([marks["initial_x"], marks["x"]], [marks["initial_y"], marks["y"]], color="0.6", linewidth=0.5)
        axes.plot(marks["initial_x"], marks["initial_y"], ".", color="tab:blue", markersize=4, label="initial")
        axes.plot(marks["x"], marks["y"], ".", color="gold", markersize=3, label="after the update")
        near = np.vstack([estimate[:, :2], np.column_stack([marks["initial_x"], marks["initial_y"]])])
        low, high = np.percentile(near, [1, 99], axis=0)
        room = 0.1 * (high - low).max()
        axes.set_xlim(low[0] - room, high[0] + room)
        axes.set_ylim(low[1] - room, high[1] + room)
    else:
        axes.plot(truth[:, 0], truth[:, 1], "--", color="0.4", linewidth=1, label="truth")
    axes.plot(estimate[:, 0], estimate[:, 1], color="tab:red", linewidth=1.2, label="estimate")
    axes.plot(*estimate[0, :2], "o", color="tab:green", markersize=4, label="start")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_title(title, fontsize=9)
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.legend(fontsize=7)


def results():
    rows = []
    for name, label in (("task1", "task 1: prediction alone"), ("set1", "set 1, as he had it"),
                        ("set2", "set 2, as he had it"), ("set1-repaired", "set 1, repaired data"),
                        ("set2-repaired", "set 2, repaired data")):
        figures = [run(name, test) for test in TESTS]
        rows.append([label, *[number(f, "ate_m", 1) for f in figures],
                     *[number(f, "nis_per_dof", 2) for f in figures], *[f["health"] for f in figures]])
    return table(["run", *[f"ATE {t} [m]" for t in TESTS], *[f"NIS/dof {t}" for t in TESTS],
                  *[f"health {t}" for t in TESTS]], rows)


def causes():
    rows = []
    for name, label in (("set2", "as recorded"), ("set2-stale-cut", "stale pixels cut"),
                        ("set2-extrinsics-repaired", "extrinsics repaired"), ("set2-repaired", "both"),
                        ("set2-gated", "as recorded, with a gate of 99.9 %")):
        rows.append([label, *[number(run(name, test), "ate_m", 1) for test in TESTS]])
    return table(["data", *[f"ATE {t} [m]" for t in TESTS]], rows)


def mapping():
    rows = []
    for test in TESTS:
        row = [test]
        for name in ("task2-v10", "task2-v1000"):
            run(name, test)
            marks = np.genfromtxt(OUT / f"{name}-{test}" / "landmarks.csv", delimiter=",", names=True)
            moved = np.sqrt(sum((marks[a] - marks[f"initial_{a}"]) ** 2 for a in "xyz"))
            row += [f"{np.median(moved):.2f}", f"{np.percentile(moved, 95):.2f}"]
        rows.append(row)
    return table(["test", "V = 10 I: median [m]", "95 % [m]", "V = 1000 I: median [m]", "95 % [m]"], rows)


def main():
    OUT.mkdir(parents=True, exist_ok=True)
    for file in OUT.glob("*/*"):  # of another program or configuration
        file.unlink()
    figures = []
    for figure_number, name, test, title in FIGURES:
        figure, axes = plt.subplots(figsize=(4.6, 4.0), layout="constrained")
        draw(axes, name, test, f"Figure {figure_number}: {title}")
        figures.append(svg(figure))
    parameters = table(["parameter", "set 1 (Table 1)", "set 2 (Table 2)"], PARAMETERS)
    fill(DOCS, "du-results", results())
    fill(DOCS, "du-causes", causes())
    fill(DOCS, "du-mapping", mapping())
    (OUT / "page.html").write_text(page("Du: “Visual-inertial SLAM using EKF”", """His three recordings as they
are, his equations with their misprints corrected, his parameters (studies/configs/du-*.yaml). docs/papers.md explains the
results.""", [("Tables 1 and 2", parameters), ("Results", results()), ("Set 2 with repaired data", causes()),
              ("Distance that the mapping update moves a landmark", mapping()), ("Figures 1 to 12", figures)]))
    figure, axes = plt.subplots(1, 2, figsize=(9, 4.2), layout="constrained")
    draw(axes[0], "set2", "20", "Test 20, set 2, as he had it")
    draw(axes[1], "set2-stale-cut", "20", "The same without stale pixels")
    figure.savefig(PICTURE, **PNG)
    print(OUT / "page.html")
