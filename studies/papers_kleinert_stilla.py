"""The experiments of Kleinert and Stilla's paper: see studies/papers.py. out/papers/kleinert-stilla keeps
the studies, and an interrupted one resumes: remove the folder to start again. Figure 4 comes from
studies/walk.py, which runs first unless out/walk has its runs."""

import csv
import json
import subprocess
import sys

import numpy as np

from pages import fill
from papers_page import CHASLES, DOCS, PNG, ROOT, STUDY, page, plt, svg, table

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
STANDARD = ["--charts", "standard", "--landmarks", "cartesian", "--init", "fixed-depth", "--set", "nav_attitude=true", "--set", "gate=1"]


def scene_sets(*assignments):
    return [part for one in assignments for part in ("--scene-set", one)]


def sets(*assignments):
    return [part for one in assignments for part in ("--set", one)]


KNOWN_VELOCITY = sets("initial_velocity_sigma=0.001")
KNOWN_BIASES = [*scene_sets("accelerometer_bias_sigma=0", "gyroscope_bias_sigma=0"),
                *sets("initial_accelerometer_bias_sigma=1e-4", "initial_gyroscope_bias_sigma=1e-5")]
# The paper's filter as it is printed where this one differs.
OPTIONS = {
    "as here": [],
    "numeric Jacobians": sets("numeric_jacobians=true"),
    "I + Fτ, (14) and (15)": sets("first_order_transition=true"),
    "instant accelerations, incremental rotations": scene_sets("imu_convention=instant-force"),
    "all three": [*sets("numeric_jacobians=true", "first_order_transition=true"), *scene_sets("imu_convention=instant-force")],
}
# What the paper does not say of its scenes and its start, one change at a time, then together.
VARIANTS = {
    "hallway": {
        "as here": [],
        "known initial velocity": KNOWN_VELOCITY,
        "known biases": KNOWN_BIASES,
        "initial tilt of 1°": sets("initial_tilt_sigma=0.0175"),
        "50 landmarks in view": scene_sets("landmarks_in_view=50"),
        "landmarks at 5 to 12 m": scene_sets("min_range=5", "max_range=12", "wall_density=12"),
        "landmarks at 2 to 25 m": scene_sets("min_range=2", "max_range=25"),
        "depth of 8 ± 2 m": sets("fixed_depth_sigma=2"),
        "depth of 8 ± 5 m": sets("fixed_depth_sigma=5"),
        "gentle turns, of 3 s": scene_sets("turn_duration=3", "corridor_width=4"),
        "block of 15 × 10 m": scene_sets("hall_length=15", "hall_width=10"),
        "known velocity, block of 15 × 10 m": [*KNOWN_VELOCITY, *scene_sets("hall_length=15", "hall_width=10")],
        "known velocity, 2 sections": [*KNOWN_VELOCITY, *scene_sets("sections=2")],
        "known velocity, composition every second": [*KNOWN_VELOCITY, *sets("composition_interval=1")],
        "known velocity, composition every 20 s": [*KNOWN_VELOCITY, *sets("composition_interval=20")],
        "known velocity, depth of 8 ± 2 m": [*KNOWN_VELOCITY, *sets("fixed_depth_sigma=2")],
    },
    "turntable": {
        "as here": [],
        "known initial velocity": KNOWN_VELOCITY,
        "known biases": KNOWN_BIASES,
        "circle of 4 m": scene_sets("circle_radius=4"),
        "cube of 4 m": scene_sets("cube_edge=4"),
        "revolution in 8 s": scene_sets("revolution_duration=8"),
        "revolution in 35 s": scene_sets("revolution_duration=35"),
        "IMU at 400 Hz": scene_sets("imu_rate=400"),
        "known velocity, revolution in 8 s": [*KNOWN_VELOCITY, *scene_sets("revolution_duration=8")],
        "known velocity, known biases": [*KNOWN_VELOCITY, *KNOWN_BIASES],
    },
}
DEFAULT = "white-noise"
READINGS = {"white noise (default)": DEFAULT, "bias random walk": "random-walk"}


def folder_name(*parts):
    return "-".join("".join(c if c.isalnum() else "-" for c in part).strip("-") for part in parts)


def study(name, scene, options=(), runs=RUNS, filters=("--preset", "paper")):
    """The figures of the filters by chart."""
    OUT.mkdir(parents=True, exist_ok=True)
    command = [CHASLES, "montecarlo", scene, "--runs", str(runs), *filters, *options, "--json", "--quiet", "--resume", "-o", OUT / name]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True)
    if done.returncode not in (0, 4):  # 4: all runs diverged, which is a result here
        raise SystemExit(f"studies/papers.py: {name} ended with {done.returncode}")
    return {f["chart"]: f for f in json.loads(done.stdout)["filters"]}


def cells(figures):
    return ["-" if figures[key] is None else f"{figures[key]:.{digits}f}" for key, digits in zip(KEYS, DIGITS)]


def medians_and_means(figures):
    return [f"{median} ({mean})" for median, mean in zip(cells(figures["median"]), cells(figures))]


def published_table(scene, figures):
    rows = []
    for chart, name in CHARTS.items():
        paper = [f"{value:.{digits}f}" for value, digits in zip(PUBLISHED[scene][chart], DIGITS)]
        rows.append([name, "paper", *paper])
        rows.append([name, "here, mean", *cells(figures[chart])])
        rows.append([name, "here, median", *cells(figures[chart]["median"])])
    return table(["error", "", "avg. NEES position", "avg. NEES attitude", "avg. error position [m]", "avg. error attitude [°]"], rows)


FOUR = ["NEES position", "NEES attitude", "position [m]", "attitude [°]"]


def variants(scene):
    rows = [["paper", *[f"{value:.{digits}f}" for value, digits in zip(PUBLISHED[scene]["standard"], DIGITS)], ""]]
    for label, options in VARIANTS[scene].items():
        figures = study(folder_name(scene, "variant", label), scene, options, RUNS_OF_VARIANTS, STANDARD)["standard"]
        rows.append([label, *medians_and_means(figures), str(figures["diverged"])])
    return table(["`standard`", *FOUR, "diverged"], rows)


def options_table():
    rows = []
    for scene in TITLES:
        for label, options in OPTIONS.items():
            figures = study(folder_name(scene, "option", label), scene, options, RUNS_OF_VARIANTS)
            rows += [[scene, label, chart, *medians_and_means(figures[chart])] for chart in CHARTS]
    return table(["scene", "filter and IMU", "chart", *FOUR], rows)


def reading(scene, name):
    """The study of a scene with one reading of the gyroscope's figure."""
    return study(folder_name(scene, name), scene, ["--scene-config", ROOT / f"studies/configs/scene-gyroscope-{name}.yaml"])


def readings():
    rows = []
    for scene in TITLES:
        for label, name in READINGS.items():
            rows += [[scene, label, chart, *medians_and_means(reading(scene, name)[chart])] for chart in CHARTS]
    return table(["scene", "0.0056 °/(s √s) read as", "chart", *FOUR], rows)


def curves(name):
    """The columns of a study's curves.csv by filter."""
    found = {}
    with (OUT / name / "curves.csv").open() as file:
        for row in csv.DictReader(file):
            for key, value in row.items():
                if key != "filter":
                    found.setdefault(row["filter"], {}).setdefault(key, []).append(float(value))
    return found


def over_time(figure, name, columns, title, bound=None):
    """Attitude on top, position below, as in (b) and (c) of their figures 2 and 3."""
    axes = figure.subplots(2, 1, sharex=True)
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


def run_view(axes, folder, title, view):
    """(a) of figures 2 and 3 in their colours: one run of the standard filter."""
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


def plan_lines(file):
    lines = {}
    with file.open() as rows:
        for row in csv.DictReader(rows):
            lines.setdefault((row["line"], row["kind"]), []).append((float(row["x"]), float(row["y"])))
    return lines


def figure_4():
    """The trajectories over the floor plan: left-invariant, right-invariant, standard; beside them those
    of Chasles from the same images."""
    figure, axes = plt.subplots(3, 2, figsize=(13, 10.5), layout="constrained")
    # The building is longer along y: it lies on its side.
    lying = lambda points: np.array([points[:, 1], -points[:, 0]])
    for row, (chart, name) in zip(axes, CHARTS.items()):
        for axis, prefix, title in zip(row, ("ks-", "here-"), ("Figure 4: their filter", "the filter of Chasles")):
            folder = WALK / f"{prefix}{chart}"
            for (_, kind), line in plan_lines(folder / "plan.csv").items():
                axis.plot(*lying(np.array(line)), color="0.45" if kind == "wall" else "0.75", linewidth=0.8)
            path = lying(np.loadtxt(folder / "trajectory.tum", ndmin=2)[:, 1:3])
            axis.plot(*path, color=COLOURS[chart], linewidth=1)
            axis.plot(*path[:, 0], "x", color="blue", markersize=8)
            axis.plot(*path[:, -1], "D", color="blue", markersize=5)
            axis.set_aspect("equal", adjustable="datalim")
            axis.set_title(f"{title}, {name.lower()}", fontsize=9)
            axis.set_xlabel("y [m]")
            axis.set_ylabel("−x [m]")
    return figure


def figure_of(scene, number, view):
    """(a), (b), (c) of figure 2 or 3, side by side."""
    figure = plt.figure(figsize=(13, 4.4), layout="constrained")
    a, b, c = figure.subfigures(1, 3)
    title = f"Figure {number}: {'hallway' if scene == 'hallway' else 'cube'}"
    run_view(a.subplots(), one_run(scene), f"{title} (a), one run", view)
    over_time(b, folder_name(scene, DEFAULT), ERRORS, f"{title} (b), means over {RUNS} runs")
    over_time(c, folder_name(scene, DEFAULT), NEES, f"{title} (c), means over {RUNS} runs", bound=14)
    return figure


def main():
    tables = {scene: published_table(scene, reading(scene, DEFAULT)) for scene in TITLES}
    parts = []
    for (scene, title), (number, view) in zip(TITLES.items(), ((2, flat), (3, slanted))):
        fill(DOCS, f"ks-{scene}", tables[scene])
        figure = figure_of(scene, number, view)
        figure.savefig(PICTURES / f"ks-figure-{number}.png", **PNG)
        parts += [(title, tables[scene]), (f"Figure {number}", [svg(figure)])]
    if not (WALK / "ks-standard/trajectory.tum").exists():
        subprocess.run([sys.executable, "-m", "studies.walk"], check=True, cwd=ROOT)
    walks = figure_4()
    walks.savefig(PICTURES / "ks-figure-4.png", **PNG)
    parts.append(("Figure 4", [svg(walks)]))
    for name, title, text in (("gyroscope", "Both readings of the gyroscope's figure", readings()),
                              ("options", "Their Jacobians, transition and samples", options_table()),
                              ("hallway-variants", "Variants of the hallway", variants("hallway")),
                              ("turntable-variants", "Variants of the cube", variants("turntable"))):
        fill(STUDY, f"ks-{name}", text)
        parts.append((title, text))
    (OUT / "page.html").write_text(page("Kleinert and Stilla: “On Sensor Pose Parameterization for Inertial Aided Visual SLAM”",
        "Their filters (<code>--preset paper</code>) in scenes after theirs. Medians of the runs, means in parentheses, where two numbers stand. "
        "docs/papers.md explains the results.", parts))
    print(OUT / "page.html")
