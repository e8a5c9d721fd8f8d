"""The experiments of Kleinert and Stilla's paper: see scripts/papers. Its walk (figure 4) comes from
scripts/walk, which runs first unless out/walk is there."""

import csv
import json
import subprocess

import numpy as np

from pages import fill
from papers_page import CHASLES, DOCS, ROOT, page, plt, save_picture, svg, table

OUT = ROOT / "out/papers/kleinert-stilla"
WALK = ROOT / "out/walk"
PICTURES = ROOT / "docs/images"
RUNS, RUNS_OF_VARIANTS = 100, 50
# Their order of the rows, and their colours (figure 2).
CHARTS = {"left-se3": "Left-invariant", "right-se3": "Right-invariant", "standard": "Standard"}
COLOURS = {"left-se3": "red", "right-se3": "green", "standard": "blue"}
# Tables I and II: mean NEES of position and attitude, mean error of position [m] and attitude [deg].
PUBLISHED = {
    "hallway": {"left-se3": (45.5793, 24.2785, 0.1895, 0.1015), "right-se3": (42.644443, 29.209042, 0.2192, 0.1081),
                "standard": (46.7471, 28.9725, 0.1876, 0.1077)},
    "turntable": {"left-se3": (4.0015, 5.5863, 0.0070, 0.0881), "right-se3": (6.6691, 5.3010, 0.0071, 0.0896),
                  "standard": (4.0421, 5.3024, 0.0070, 0.0896)},
}
TITLES = {"hallway": "Table I: hallway", "turntable": "Table II: cube"}
KEYS = ("nees_position", "nees_attitude", "position_error_m", "attitude_error_deg")
DIGITS = (2, 2, 4, 4)
# Settings of all filters of a study, and of its scene.
KNOWN_VELOCITY = ["--set", "initial_velocity_sigma=0.001"]
RANDOM_WALK = ["--scene-config", ROOT / "configs/scene-gyroscope-random-walk.yaml"]
WHITE_NOISE = ["--scene-config", ROOT / "configs/scene-gyroscope-white-noise.yaml"]


def scene_sets(*assignments):
    return [part for one in assignments for part in ("--scene-set", one)]


def sets(*assignments):
    return [part for one in assignments for part in ("--set", one)]


def study(name, scene, options=(), runs=RUNS):
    """The figures of the paper's three filters by chart: a study, which a second call reads again."""
    folder = OUT / name
    OUT.mkdir(parents=True, exist_ok=True)
    command = [CHASLES, "montecarlo", scene, "--runs", str(runs), "--preset", "paper", *options, "--json", "--quiet", "--resume", "-o", folder]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
    return {f["chart"]: f for f in json.loads(done.stdout)["filters"]}


def cells(figures):
    return [f"{figures[key]:.{digits}f}" for key, digits in zip(KEYS, DIGITS)]


def published_table(scene, figures):
    rows = []
    for chart, name in CHARTS.items():
        paper = [f"{value:.{digits}f}" for value, digits in zip(PUBLISHED[scene][chart], DIGITS)]
        rows.append([name, "paper", *paper])
        rows.append([name, "here, mean", *cells(figures[chart])])
        rows.append([name, "here, median", *cells(figures[chart]["median"])])
    return table(["error", "", "avg. NEES position", "avg. NEES attitude", "avg. error position [m]", "avg. error attitude [°]"], rows)


def variant_rows(scene, variants):
    """One row a variant: the standard filter, medians; the means are in parentheses."""
    rows = []
    for label, options in variants:
        name = f"{scene}-" + "".join(c if c.isalnum() else "-" for c in label).strip("-")
        figures = study(name, scene, options, RUNS_OF_VARIANTS)["standard"]
        both = [f"{middle} ({mean})" for middle, mean in zip(cells(figures["median"]), cells(figures))]
        rows.append([label, *both])
    return rows


VARIANT_HEAD = ["scene or filter", "NEES position", "NEES attitude", "position [m]", "attitude [°]"]


def curves(name):
    """The columns of a study's curves.csv by filter."""
    found = {}
    with (OUT / name / "curves.csv").open() as file:
        for row in csv.DictReader(file):
            for key, value in row.items():
                if key != "filter":
                    found.setdefault(row["filter"], {}).setdefault(key, []).append(float(value))
    return found


def over_time(name, columns, title, bound=None):
    """Attitude on top, position below, as in (b) and (c) of their figures 2 and 3."""
    figure, axes = plt.subplots(2, 1, figsize=(4.6, 4.0), sharex=True, layout="constrained")
    of = curves(name)
    for axis, (column, label) in zip(axes, columns):
        for chart in CHARTS:
            curve = of[f"paper-{chart}"]
            axis.plot(curve["second"], curve[column], color=COLOURS[chart], linewidth=1, label=CHARTS[chart])
        if bound:
            axis.axhline(bound, color="0.6", linewidth=0.8, linestyle="--")
        axis.set_ylabel(label)
        axis.set_ylim(bottom=0)
    axes[0].set_title(title, fontsize=9)
    axes[0].legend(fontsize=7)
    axes[1].set_xlabel("time [s]")
    return figure


ERRORS = [("attitude_error_deg", "attitude error [°]"), ("position_error_m", "position error [m]")]
NEES = [("nees_attitude", "NEES attitude"), ("nees_position", "NEES position")]


def points(file):
    return np.genfromtxt(file, delimiter=",", names=True)


def one_run(scene):
    """A folder with one run of the paper's filters."""
    folder = OUT / f"{scene}-one-run"
    subprocess.run([CHASLES, "compare", scene, "--preset", "paper", "--quiet", "-o", folder], check=True, stdout=subprocess.DEVNULL)
    return folder


def slanted(x, y, z, azimuth=np.radians(30), elevation=np.radians(30)):
    """An orthographic view from above and aside."""
    right = np.cos(azimuth) * x + np.sin(azimuth) * y
    away = -np.sin(azimuth) * x + np.cos(azimuth) * y
    return right, np.sin(elevation) * away + np.cos(elevation) * z


def flat(x, y, z):
    return x, y


def run_view(folder, title, view):
    """(a) of figures 2 and 3 in their colours: one run of the standard filter."""
    figure, axes = plt.subplots(figsize=(4.6, 4.0), layout="constrained")
    path = lambda file: np.loadtxt(folder / file, ndmin=2)[:, 1:4].T
    marks = lambda file: [points(folder / file)[axis] for axis in "xyz"]
    axes.plot(*view(*marks("landmarks_truth.csv")), ".", color="orange", markersize=4, label="reference landmarks")
    axes.plot(*view(*marks("paper-standard_landmarks.csv")), ".", color="deepskyblue", markersize=3, label="estimated landmarks")
    axes.plot(*view(*path("truth.tum")), color="red", linewidth=1.6, label="reference trajectory")
    axes.plot(*view(*path("paper-standard.tum")), color="green", linewidth=1, label="estimated trajectory")
    shown = np.column_stack([view(*path("truth.tum")), view(*marks("landmarks_truth.csv"))])
    low, high = shown.min(axis=1), shown.max(axis=1)
    room = 0.05 * (high - low).max()
    axes.set_xlim(low[0] - room, high[0] + room)
    axes.set_ylim(low[1] - room, high[1] + room)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_title(title, fontsize=9)
    axes.legend(fontsize=7)
    axes.set_xlabel("x [m]" if view is flat else "[m], across the view")
    axes.set_ylabel("y [m]" if view is flat else "[m], up in the view")
    return figure


def plan_lines(file):
    lines = {}
    with file.open() as rows:
        for row in csv.DictReader(rows):
            lines.setdefault((row["line"], row["kind"]), []).append((float(row["x"]), float(row["y"])))
    return lines


def figure_4(prefix, title):
    """The three trajectories over the floor plan: left-invariant, right-invariant, standard."""
    figure, axes = plt.subplots(3, 1, figsize=(5.6, 9.6), layout="constrained")
    for axis, (chart, name) in zip(axes, CHARTS.items()):
        folder = WALK / f"{prefix}{chart}"
        for (_, kind), line in plan_lines(folder / "plan.csv").items():
            axis.plot(*np.array(line).T, color="0.45" if kind == "wall" else "0.75", linewidth=0.8)
        path = np.loadtxt(folder / "trajectory.tum", ndmin=2)[:, 1:3]
        axis.plot(*path.T, color=COLOURS[chart], linewidth=1)
        axis.plot(*path[0], "x", color="blue", markersize=8)
        axis.plot(*path[-1], "D", color="blue", markersize=5)
        axis.set_aspect("equal", adjustable="datalim")
        axis.set_title(f"{title}: {name}", fontsize=9)
        axis.set_xlabel("x [m]")
        axis.set_ylabel("y [m]")
    return figure
