#!/usr/bin/env python3
"""python3 -m studies.table [--keep-times] [NAME...]: runs `chasles run` on all recordings of CHASLES_DATA
(../shared/data) in every variant of the tables. The figures go to studies/results.json, and from there
(studies/front_page.py) to README.md, docs/results.md and studies/results.md. With --keep-times the times
of the stereo-velocity runs stay those of the file: for a machine with other work on it. With names
(substrings of "ece276a_2020/0027") it runs only those recordings, and only prints."""

import json
import math
import pathlib
import sys
import tempfile

from studies import front_page
from studies.front_page import AXES, DEFAULT, FIGURES, STRAIGHT_ROAD
from studies.kitti import KITTI, REPAIRED, recordings, truth_of
from studies.measured import measured, rounded
from studies.program import CHASLES, DATA, Arguments, Json, chasles, parser, read_json

VARIANTS: dict[str, list[str]] = {
    "dead reckoning": ["--mode", "localize"],
    "map": ["--mode", "map"],
    "Du, set 1": ["--config", "studies/configs/du-set1.yaml"],
    "Du, set 2": ["--config", "studies/configs/du-set2.yaml"],
    "Du, set 1, repaired data": ["--config", "studies/configs/du-set1.yaml", *REPAIRED],
    "Du, set 2, repaired data": ["--config", "studies/configs/du-set2.yaml", *REPAIRED],
    "standard": ["--chart", "standard"],
    "left-se3": ["--chart", "left-se3"],
    "right-se3": ["--chart", "right-se3"],
    DEFAULT: [],
}

# The figures that the file keeps of a run, those of FIGURES and:
KEPT = ["path_m", "attitude_first_pose_deg"]
TIMES = ["seconds_wall", "seconds_cpu", "realtime_factor"]

# Name, key, folder, cameras, options, and from which second the errors count in the comparison with
# peers: not before the latest of them has started.
INERTIAL: list[tuple[str, str, str, int, list[str], float]] = [
    ("EuRoC MH_01_easy", "MH_01", "euroc/MH_01_easy_17s", 1, ["--cameras", "mono"], 2.6),
    ("EuRoC MH_01_easy", "MH_01", "euroc/MH_01_easy_17s", 2, [], 2.6),
    ("EuRoC MH_03_medium", "MH_03", "euroc/MH_03_medium_27s_mono", 1, [], 2.6),
    ("KITTI odometry 00", "KITTI 00", "kitti_images/00_first_13s", 2, [], 0.0),
]


def run(name: str, path: pathlib.Path, arguments: list[str]) -> Json:
    """The figures of one run; a run that ended with an error has only its `error`."""
    done = chasles("run", path, "--json", "--quiet", *arguments, *truth_of(name), accepted=None, silent=True)
    try:
        figures: Json = json.loads(done.stdout)
    except json.JSONDecodeError:
        figures = {}
    if done.returncode != 0:
        figures["error"] = (done.stderr.strip().splitlines() or ["?"])[-1]
        figures["exit_code"] = done.returncode
    figures["command"] = " ".join(["chasles", "run", name, *arguments])
    return figures


def kept(figures: Json) -> Json:
    """What the tables need of the figures, to six digits."""
    keys = [key for _, key, _ in FIGURES] + KEPT
    found = {key: figures[key] for key in [*keys, "command", "error", "exit_code"] if key in figures}
    return {key: rounded(value) for key, value in found.items()}


def off_line(tum: pathlib.Path) -> float:
    """RMS distance of positions from the line that fits them best [m]: what the largest of the principal
    axes leaves. By power iteration, so that the table needs no NumPy."""
    rows = [line.split() for line in tum.read_text().splitlines() if not line.startswith("#")]
    points = [[float(value) for value in row[1:4]] for row in rows]
    mean = [sum(axis) / len(points) for axis in zip(*points)]
    offsets = [[v - m for v, m in zip(point, mean)] for point in points]
    second = [[sum(o[i] * o[j] for o in offsets) / len(points) for j in range(3)] for i in range(3)]
    axis = [1.0, 1.0, 1.0]
    for _ in range(200):
        axis = [sum(a * b for a, b in zip(row, axis)) for row in second]
        length = math.sqrt(sum(a * a for a in axis))
        axis = [a / length for a in axis]
    along = sum(axis[i] * second[i][j] * axis[j] for i in range(3) for j in range(3))
    return math.sqrt(max(0.0, sum(second[i][i] for i in range(3)) - along))


def stereo_velocity(chosen: list[str]) -> dict[str, dict[str, Json]]:
    results: dict[str, dict[str, Json]] = {}
    for name, path in recordings().items():
        if chosen and not any(part in name for part in chosen):
            continue
        results[name] = {}
        for way, arguments in VARIANTS.items():
            if "repaired" in way and path.suffix != ".npz":
                continue  # the reader corrects the archives alone
            print(f"{name}: {way}", file=sys.stderr, flush=True)
            results[name][way] = kept(run(name, path, arguments))
        if name == STRAIGHT_ROAD:
            with tempfile.TemporaryDirectory() as folder:
                chasles("run", path, "--quiet", "-o", f"{folder}/run")
                results[name][DEFAULT]["truth_off_line_m"] = rounded(off_line(pathlib.Path(folder) / "run/truth.tum"))
    return results


def compared(run: pathlib.Path, from_s: float) -> Json:
    """Errors of the poses from this second of the run on, by position and yaw as with the peers."""
    figures: Json = {"from_s": from_s}
    for path, prefix in (("trajectory.tum", ""), ("trajectory_smoothed.tum", "smoothed_")):
        rows = [line for line in (run / path).read_text().splitlines() if not line.startswith("#")]
        begin = float(rows[0].split()[0])
        late = run / f"from_{path}"
        late.write_text("".join(f"{row}\n" for row in rows if float(row.split()[0]) - begin >= from_s))
        found = json.loads(chasles("evaluate", late, run / "truth.tum", "--json").stdout)
        figures |= {f"{prefix}{key}": rounded(found[key]) for key in ("ate_posyaw_m", "attitude_posyaw_deg")}
    return figures


def inertial_run(folder: str, options: list[str], from_s: float) -> Json:
    keys = ["frames", "recorded_seconds", "path_m", "ate_m", "ate_posyaw_m", "attitude_posyaw_deg", "nees_pose",
            *(f"within_3_sigma_{axis}" for axis in AXES)]
    with tempfile.TemporaryDirectory() as out:
        chasles("run", DATA / folder, *options, "--threads", "1", "--quiet", "-o", f"{out}/run")
        figures = read_json(pathlib.Path(out) / "run/summary.json")
        return {"command": " ".join(["chasles", "run", folder, *options, "--threads", "1"]),
                **{key: rounded(figures[key]) for key in keys},
                "compared": compared(pathlib.Path(out) / "run", from_s)}


def visual_inertial(earlier: list[Json]) -> list[Json]:
    """The rows of the file with this program's figures; those of the peers stay."""
    peers = {(row["key"], row["cameras"]): row for row in earlier}
    rows = []
    for name, key, folder, cameras, options, from_s in INERTIAL:
        print(f"{key}, cameras: {cameras}", file=sys.stderr, flush=True)
        rows.append({**peers.get((key, cameras), {"ate_m": {}, "nees": {}}), "name": name, "key": key,
                     "cameras": cameras, "chasles": inertial_run(folder, options, from_s)})
    return rows


def keep_times(runs: dict[str, dict[str, Json]], earlier: Json) -> None:
    for name, ways in runs.items():
        for way, figures in ways.items():
            figures |= {key: earlier[name][way][key] for key in TIMES if key in earlier[name][way]}


def main() -> None:
    arguments = parser(__doc__)
    arguments.add_argument("--keep-times", action="store_true")
    arguments.add_argument("names", nargs="*", metavar="NAME")
    options = arguments.parse_args()
    if not KITTI.is_dir():
        sys.exit(f"studies/table.py: no recordings in {KITTI}; set CHASLES_DATA")
    chosen: list[str] = options.names
    now = measured(CHASLES)
    runs = stereo_velocity(chosen)
    if chosen:
        print(front_page.variants_page({"stereo_velocity": {"runs": runs, "measured": now, "timed": now}}))
        return
    results = front_page.load()
    stereo, inertial = results["stereo_velocity"], results["visual_inertial"]
    if options.keep_times:
        keep_times(runs, stereo["runs"])
    else:
        stereo["timed"] = now
    stereo |= {"command": "chasles run RECORDING --json --quiet", "measured": now, "runs": runs}
    inertial |= {"measured": now, "rows": visual_inertial(inertial["rows"])}
    front_page.save(results)
    front_page.fill_pages(results)


if __name__ == "__main__":
    main()
