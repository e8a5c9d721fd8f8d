#!/usr/bin/env python3
"""python3 -m studies.truth_errors [RUNS]: what `--truth-errors auto` finds of a truth, and what it leaves of NEES.
Simulated runs (RUNS noise realisations, 20) with their exact truth and with one that has known errors, runs of EuRoC,
and what `chasles check` measures by the IMU alone. It fills studies/evaluation.md between its markers. Ten minutes of
one core."""

import json
import math
import pathlib
import statistics
import tempfile

import numpy as np

from studies.arrays import Array
from studies.pages import fill, table
from studies.program import DATA, EUROC, LOST, ROOT, Argument, Arguments, Json, chasles, count, parser, sets

PAGE = ROOT / "studies/evaluation.md"
MARKERS = {PAGE: ("truth-errors-simulated", "truth-errors-real", "truth-errors-imu")}
LATE, BODY, WORLD = 0.012, np.radians([0.5, -0.4, 0.6]), np.radians([0.3, -0.5, 1.5])
SCENES: list[tuple[str, Arguments]] = [
    ("hallway, filter", []),
    ("hallway, half of the pixel noise stated", sets("track_sigma=0.5")),
]
REAL: list[tuple[str, pathlib.Path, Arguments]] = [
    ("MH_01, one camera", EUROC / "MH_01_easy_17s", ["--cameras", "mono"]),
    ("MH_01, two cameras", EUROC / "MH_01_easy_17s", []),
    ("MH_03, one camera", EUROC / "MH_03_medium_27s_mono", []),
]
ESTIMATORS = ("filter", "window:20", "batch")
TRUTHS: list[tuple[str, pathlib.Path]] = [
    ("MH_01, cut of 17 s", EUROC / "MH_01_easy_17s"),
    ("MH_03, cut of 27 s", EUROC / "MH_03_medium_27s_mono"),
    *[(f"{name}, whole", EUROC / f"imu_gt/{name}_imu.csv.gz")
      for name in ("MH_01_easy", "MH_03_medium", "V1_01_easy", "V1_02_medium", "V2_01_easy")],
    *[(f"TUM-VI {name}", DATA / f"tumvi_imu_gt/{name}_imu.csv.gz") for name in ("room1", "room2", "room3")],
]


def quaternion(rotation: Array) -> Array:
    """x, y, z, w of a rotation vector."""
    angle = float(np.linalg.norm(rotation))
    return np.append(rotation / angle * math.sin(angle / 2), math.cos(angle / 2))


def product(a: Array, b: Array) -> Array:
    """Of quaternions x, y, z, w, row by row."""
    a, b = np.atleast_2d(a), np.atleast_2d(b)
    vector = a[:, 3:] * b[:, :3] + b[:, 3:] * a[:, :3] + np.cross(a[:, :3], b[:, :3])
    return np.column_stack([vector, a[:, 3] * b[:, 3] - np.sum(a[:, :3] * b[:, :3], axis=1)])


def with_errors(file: pathlib.Path, changed: pathlib.Path) -> None:
    """Writes the truth with errors: R = Exp(WORLD) R_file Exp(BODY), p(t) = p_file(t + LATE)."""
    lines = [line.split() for line in file.read_text().splitlines() if not line.startswith("#")]
    rows = np.array([[float(x) for x in line] for line in lines])
    seconds = rows[:, 0] - rows[0, 0]
    p = np.column_stack([np.interp(seconds - LATE, seconds, rows[:, k]) for k in (1, 2, 3)])
    q = product(product(quaternion(-WORLD), rows[:, 4:8]), quaternion(-BODY))
    poses = np.column_stack([p, q])
    changed.write_text("".join(f"{line[0]} {' '.join(f'{x:.9f}' for x in pose)}\n" for line, pose in zip(lines, poses)))


def evaluated(run: pathlib.Path, *truth: Argument) -> Json:
    found: Json = json.loads(chasles("evaluate", run, *truth, "--truth-errors", "auto", "--json", silent=True).stdout)
    return found


class Simulated:
    """One run, with its exact truth and with errors."""

    def __init__(self, run: int, arguments: Arguments) -> None:
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            chasles("simulate", "hallway", "--run", run, "--seed", run + 1, "--quiet", "-o", folder / "recording")
            chasles("run", folder / "recording", *arguments, "--threads", 1, "--quiet", "-o", folder / "run",
                    accepted=(0, LOST), silent=True)
            with_errors(folder / "run/truth.tum", folder / "wrong.tum")
            self.exact, self.wrong = evaluated(folder / "run"), evaluated(folder / "run", folder / "wrong.tum")


def squares(found: Json, late: float, heading: float) -> list[float]:
    """Of the errors of the time and of the first heading, in their sigmas."""
    pairs = ((found["truth_errors"]["position_time_s"], late), (found["truth_errors"]["first_heading_deg"], heading))
    return [((constant["value"] - right) / constant["sigma"]) ** 2 for constant, right in pairs]


def of_scene(name: str, runs: list[Simulated]) -> list[list[str]]:
    rows = []
    for truth, kind in (("exact", "exact"), ("with errors", "wrong")):
        all_found: list[Json] = [getattr(run, kind) for run in runs]
        errors = [found["truth_errors"] for found in all_found]
        late = LATE if kind == "wrong" else 0
        times = [squares(found, late, 0)[0] for found in all_found]
        rows.append([name, truth, *[f"{statistics.mean(found[f'nees_{what}'] for found in all_found) / dof:.2f}, "
                                    f"{statistics.mean(e[f'nees_{what}']['mean'] for e in errors) / dof:.2f}"
                                    for what, dof in (("position", 3), ("attitude", 3), ("pose", 6))],
                     f"{1e3 * statistics.mean(e['position_time_s']['value'] for e in errors):.1f}",
                     f"{statistics.mean(times):.2f}",
                     f"{statistics.mean(e['first_heading_deg']['value'] for e in errors):.2f}",
                     f"{sum(e['position_time_s']['significant'] for e in errors)}, "
                     f"{sum(e['first_heading_deg']['significant'] for e in errors)} of {len(errors)}"])
    return rows


def plus_minus(constant: Json, scale: float, decimals: int) -> str:
    return f"{scale * constant['value']:.{decimals}f} ± {scale * constant['sigma']:.{decimals}f}"


def of_recording(name: str, recording: pathlib.Path, arguments: Arguments) -> list[list[str]]:
    rows = []
    for estimator in ESTIMATORS:
        with tempfile.TemporaryDirectory() as folder:
            run = pathlib.Path(folder) / "run"
            chasles("run", recording, *arguments, "--estimator", estimator, "--quiet", "-o", run, silent=True)
            found = evaluated(run)
        errors = found["truth_errors"]
        rows.append([name, f"`{estimator}`", plus_minus(errors["position_time_s"], 1e3, 1),
                     plus_minus(errors["first_heading_deg"], 1, 2),
                     *[f"{found[f'nees_{what}'] / dof:.2f}, {errors[f'nees_{what}']['mean'] / dof:.2f}"
                       for what, dof in (("position", 3), ("attitude", 3), ("pose", 6))],
                     f"{found['ate_m']:.4f}, {errors['ate_m']:.4f}",
                     f"{found['attitude_deg']:.2f}, {errors['attitude_deg']:.2f}"])
    return rows


def by_imu(name: str, recording: pathlib.Path) -> list[str]:
    facts = json.loads(chasles("check", recording, "--json", accepted=(0, 2), silent=True).stdout)["facts"]["truth"]

    def of(fact: str, decimals: int) -> str:
        sigma = facts.get(f"sigma of {fact}")
        return f"{facts[fact]['value']:.{decimals}f} ± {sigma['value']:.{decimals}f}" if sigma else "-"

    return [name, of("attitudes late", 2), of("positions late", 1), of("turn of the axes", 2), of("tilt", 2),
            of("heading against its positions", 2), of("lever arm of its positions", 1)]


def main() -> None:
    arguments = parser(__doc__)
    arguments.add_argument("runs", nargs="?", type=count, default=20, metavar="RUNS")
    chosen = arguments.parse_args()
    fill(PAGE, "truth-errors-imu", table(
        ["truth", "attitudes late ms", "positions late ms", "axes °", "tilt °", "heading °", "lever arm cm"],
        [by_imu(name, recording) for name, recording in TRUTHS]))
    fill(PAGE, "truth-errors-real", table(
        ["recording", "estimator", "positions late ms", "first heading °", "NEES/dof position", "attitude", "pose",
         "ATE m", "attitude °"],
        [row for name, recording, more in REAL for row in of_recording(name, recording, more)]))
    fill(PAGE, "truth-errors-simulated", table(
        ["scene", "truth", "NEES/dof position", "attitude", "pose", "late ms", "its squares", "first heading °",
         "significant"],
        [row for name, more in SCENES
         for row in of_scene(name, [Simulated(run, more) for run in range(chosen.runs)])]))


if __name__ == "__main__":
    main()
