#!/usr/bin/env python3
"""python3 -m studies.cameras [TABLE...]: cameras with a rolling shutter, and a calibration in the state. Fills
studies/cameras.md between its markers.

rolling      rendered walks and flights, 10 seeds of each: a readout that is known, measured from the images, or
             taken for a global shutter. It renders to out/cameras, which takes 40 minutes on two cores.
wide         rendered walks and flights, 10 seeds of each: fisheyes and rigs. An hour on two cores.
calibration  simulated walks, 100 runs, with a wrong calibration that is known, estimated or considered.
imu          simulated walks, 20 runs, with a wrong IMU that is known, estimated or considered; and recordings of EuRoC.
real         the recordings of EuRoC and KITTI with the published calibration known, estimated or considered.
smoothed     calibration, imu and real with batch and window: 10 of the walks, and the recordings of EuRoC.

Without a name it makes all. Needs NumPy."""

import concurrent.futures
import gzip
import os
import pathlib
import shutil
import statistics
import typing

from studies import pages
from studies.pages import fill, number
from studies.program import (DATA, EUROC, LOST, ROOT, Argument, Json, assignments, chasles, one_of, parser, read_json,
                             sets)
from studies.wrong_sensors import CENTRE, CLOCK, DISTORTION, FOCAL, READOUT, SHIFT, TURN, Wrong, WrongImu

OUT = ROOT / "out/cameras"
PAGE = ROOT / "studies/cameras.md"
MARKERS = {PAGE: ("rolling", "wide", "calibration", "imu", "real", "smoothed")}
SEEDS = range(1, 11)
WORKERS = int(os.environ.get("WORKERS", "2"))
LENS: Json = {"image_width": 752, "image_height": 480, "focal_length": 458, "center_u": 375.5, "center_v": 239.5}
MOTIONS: dict[str, tuple[str, list[Argument], Json]] = {
    "walk": ("walk", [], {"walk_duration": 20}),
    "flight": ("trajectory", ["--path", OUT / "V1_02_medium_imu.csv"], {
        **LENS, "frame_rate": 20, "imu_rate": 200, "accelerometer_noise_density": 2e-3,
        "gyroscope_noise_density": 1.7e-4}),
}
FLIGHT_SECONDS = 26  # of the path
# Readouts [s] and estimators, from simulated tracks and from rendered images.
TRACKS = (0, 0.005, 0.02, 0.033), ("filter", "window:20", "batch")
IMAGES = (0, 0.02), ("filter", "window:20")


def run(place: pathlib.Path, name: str, *arguments: Argument, recording: Argument | None = None) -> Json | None:
    """summary.json of a run, of the recording at `place` or another; none where it was lost."""
    folder = place.with_name(f"{place.name}-{name}")
    shutil.rmtree(folder, ignore_errors=True)
    done = chasles("run", recording or place, "--quiet", "--threads", 1, "-o", folder, *arguments, accepted=(0, LOST),
                   silent=True)
    summary: Json | None = read_json(folder / "summary.json") if done.returncode == 0 else None
    shutil.rmtree(folder, ignore_errors=True)
    return summary


def scores(summaries: typing.Sequence[Json | None]) -> list[str]:
    """Mean ATE, mean NEES of the pose per degree of freedom, and runs that were lost."""
    kept = [s for s in summaries if s]
    ate, nees = ([s[key] for s in kept] for key in ("ate_posyaw_m", "nees_pose"))
    return [number(statistics.mean(ate), 4), number(statistics.mean(nees), 2, per=6), str(len(summaries) - len(kept))]


def beginning(name: str, seconds: float) -> None:
    """The first seconds of a recording of EuRoC's samples with its truth beside it."""
    OUT.mkdir(parents=True, exist_ok=True)
    for kind in ("imu", "gt"):
        with gzip.open(EUROC / f"imu_gt/{name}_{kind}.csv.gz", "rt") as table:
            lines = table.readlines()
        times = [int(line.split(",")[0]) if line[0].isdigit() else 0 for line in lines]
        last = next(time for time in times if time > 0) + 1e9 * seconds
        (OUT / f"{name}_{kind}.csv").write_text("".join(line for line, time in zip(lines, times) if time < last))


def unstated(recording: pathlib.Path) -> pathlib.Path:
    """A recording that says nothing of its shutter."""
    other = recording.with_name(recording.name + "-unstated")
    shutil.rmtree(other, ignore_errors=True)
    shutil.copytree(recording, other)
    sensor = other / "mav0/cam0/sensor.yaml"
    sensor.write_text("".join(line for line in sensor.open() if not line.startswith("readout_")))
    return other


def of_seed(motion: str, readout: float, images: bool, seed: int) -> dict[str, Json | None]:
    scene, more, settings = MOTIONS[motion]
    recording = OUT / f"{motion}-{seed}-{1e3 * readout:.0f}-{'images' if images else 'tracks'}"
    shutil.rmtree(recording, ignore_errors=True)
    settings = settings | {"seed": seed, "readout_time": readout}
    chasles("simulate", scene, *more, *sets(*assignments(settings)), *["--images"] * images, "--run", seed,
            "--threads", 1, "--quiet", "-o", recording)
    names = (IMAGES if images else TRACKS)[1]
    runs = {name: run(recording, name.replace(":", ""), "--estimator", name) for name in names}
    if readout > 0:
        runs["ignored"] = run(recording, "ignored", "--set", "readout_time=0")
    if readout > 0 and images:
        other = unstated(recording)
        runs["measured"] = run(other, "measured")
        shutil.rmtree(other)
    shutil.rmtree(recording)
    return runs


def rolling() -> str:
    rows = []
    beginning("V1_02_medium", FLIGHT_SECONDS)
    with concurrent.futures.ThreadPoolExecutor(WORKERS) as pool:
        for images in (True, False):
            for motion in MOTIONS:
                for readout in (IMAGES if images else TRACKS)[0]:
                    runs = list(pool.map(lambda seed: of_seed(motion, readout, images, seed), SEEDS))
                    for name in runs[0]:
                        rows.append(["images" if images else "tracks", motion, f"{1e3 * readout:.0f}", name,
                                     *scores([one[name] for one in runs])])
                        print(*rows[-1], flush=True)
    return pages.table(["from", "motion", "readout ms", "run", "ATE m", "NEES pose / 6", "lost"], rows)


SQUARE: Json = {"image_width": 640, "image_height": 640, "center_u": 319.5, "center_v": 319.5}
FOUR_THIRDS: Json = {"image_width": 640, "image_height": 480, "center_u": 319.5, "center_v": 239.5}
RIGS: dict[str, Json] = {
    "pinhole of 90 deg": FOUR_THIRDS | {"focal_length": 320},
    "pair of them": FOUR_THIRDS | {"focal_length": 320, "cameras": 2, "baseline": 0.11},
    "ring of four": FOUR_THIRDS | {"focal_length": 320, "cameras": 4, "rig": "ring"},
    "fisheye of 190 deg": SQUARE | {"focal_length": 193, "distortion": "equidistant"},
    "two of 200 deg, back to back": SQUARE | {"focal_length": 183, "distortion": "equidistant", "cameras": 2,
                                              "rig": "back-to-back", "baseline": 0.03},
}


def of_rig(motion: str, rig: str, seed: int) -> Json | None:
    scene, more, settings = MOTIONS[motion]
    recording = OUT / f"{motion}-{seed}-{rig.replace(' ', '-')}"
    shutil.rmtree(recording, ignore_errors=True)
    chasles("simulate", scene, *more, *sets(*assignments(settings | RIGS[rig] | {"seed": seed})), "--images", "--run",
            seed, "--threads", 1, "--quiet", "-o", recording)
    summary = run(recording, "rig")
    shutil.rmtree(recording)
    return summary


def wide() -> str:
    rows = []
    beginning("V1_02_medium", FLIGHT_SECONDS)
    with concurrent.futures.ThreadPoolExecutor(WORKERS) as pool:
        for motion in MOTIONS:
            for rig in RIGS:
                rows.append([motion, rig, *scores(list(pool.map(lambda seed: of_rig(motion, rig, seed), SEEDS)))])
                print(*rows[-1], flush=True)
    return pages.table(["motion", "cameras", "ATE m", "NEES pose / 6", "lost"], rows)


EXPECTED = sets(f"initial_extrinsic_rotation_sigma={TURN}", f"initial_extrinsic_translation_sigma={SHIFT}",
                f"initial_focal_sigma={FOCAL}", f"initial_principal_point_sigma={CENTRE}",
                f"initial_distortion_sigma={DISTORTION}", f"initial_readout_sigma={READOUT}",
                f"initial_time_offset_sigma={CLOCK}")
SCENE: Json = {"walk_duration": 30, "distortion": "radtan", "distortion_1": -0.28, "distortion_2": 0.07,
               "distortion_3": 2e-4, "distortion_4": 2e-5, "readout_time": 0.02, "min_range": 1}
RUNS = 100
GROUPS = {"turned": "rotation", "imu_T": "position", "fx": "focal lengths", "fy": "focal lengths",
          "cx": "principal point", "cy": "principal point", "k1": "k1, k2", "k2": "k1, k2", "p1": "p1, p2",
          "p2": "p1, p2", "readout": "readout", "time": "clock"}


def calibrate(value: str) -> list[str]:
    return sets(*(f"calibrate_{part}={value}" for part in ("extrinsics", "intrinsics", "readout", "time_offset")))


def walk_of(seed: int) -> pathlib.Path:
    recording = OUT / f"calibration-{seed}"
    shutil.rmtree(recording, ignore_errors=True)
    chasles("simulate", "walk", *sets(*assignments(SCENE | {"seed": seed})), "--run", seed, "--quiet", "-o", recording)
    return recording


def errors_of(estimated: Json | None, wrong: Wrong) -> dict[str, float]:
    """Of the estimated parameters, over their sigmas."""
    table = estimated["calibration"]["parameters"] if estimated else []
    return {p["name"]: (p["estimate"] - wrong.true[p["name"]]) / p["sigma"] for p in table}


def of_run(seed: int) -> tuple[dict[str, Json | None], dict[str, float]]:
    """The summaries of a run with the exact calibration and with a wrong one, and the estimated parameters' errors over
    their sigmas."""
    recording = walk_of(seed)
    runs = {"exact": run(recording, "exact")}
    wrong = Wrong(recording, seed)
    clock = sets(f"time_offset={wrong.clock}")
    runs["known"] = run(recording, "known", *clock)
    runs["considered"] = run(recording, "considered", *clock, *EXPECTED, *calibrate("considered"))
    runs["estimated"] = run(recording, "estimated", *clock, *EXPECTED, *calibrate("true"))
    shutil.rmtree(recording)
    return runs, errors_of(runs["estimated"], wrong)


def group_of(name: str) -> str:
    return next(group for part, group in GROUPS.items() if part in name)


SMOOTHERS = "batch", "window:20"
WAYS = {"known": "false", "considered": "considered", "estimated": "true"}


def smoothed_run(seed: int) -> tuple[dict[str, Json | None], dict[str, dict[str, float]]]:
    """As of_run(), with batch and window."""
    recording = walk_of(seed)
    runs = {f"{name}, exact": run(recording, f"exact-{name[0]}", "--estimator", name) for name in SMOOTHERS}
    wrong = Wrong(recording, seed)
    clock = sets(f"time_offset={wrong.clock}")
    errors = {}
    for name in SMOOTHERS:
        for way, value in WAYS.items():
            runs[f"{name}, {way}"] = run(recording, f"{way}-{name[0]}", "--estimator", name, *clock, *EXPECTED,
                                         *(calibrate(value) if way != "known" else []))
        errors[name] = errors_of(runs[f"{name}, estimated"], wrong)
    shutil.rmtree(recording)
    return runs, errors


def grouped(all_errors: typing.Iterable[dict[str, float]]) -> dict[str, list[float]]:
    groups: dict[str, list[float]] = {}
    for errors in all_errors:
        for name, error in errors.items():
            groups.setdefault(group_of(name), []).append(error)
    return groups


def smoothed() -> str:
    with concurrent.futures.ThreadPoolExecutor(WORKERS) as pool:
        done = list(pool.map(smoothed_run, SEEDS))
    rows = [[f"{name}, {way}", *scores([runs[f"{name}, {way}"] for runs, _ in done])]
            for name in SMOOTHERS for way in ("exact", *WAYS)]
    groups = {name: grouped(errors[name] for _, errors in done) for name in SMOOTHERS}
    squares = [[group, *(number(statistics.mean(e * e for e in of_name[group]), 2) for of_name in groups.values())]
               for group in groups["batch"]]
    recordings = []
    for place, (path, *options) in RECORDINGS.items():
        if not place.startswith("MH"):
            continue
        for name in SMOOTHERS:
            cells = [place, name]
            for setting in ("calibrate_intrinsics=false", "calibrate_intrinsics=true", "calibrate_imu=considered",
                            "calibrate_imu=true"):
                summary = run(OUT / "real", f"{name[0]}-{setting}", *options, "--estimator", name, *sets(setting),
                              recording=path)
                cells += [number(summary["ate_posyaw_m"], 4), number(summary["nees_pose"], 2, per=6)
                         ] if summary else ["-", "-"]
            recordings.append(cells)
    return "\n\n".join([
        pages.table(["calibration", "ATE m", "NEES pose / 6", "lost"], rows),
        pages.table(["estimated", *(f"{name}, NEES / 1" for name in SMOOTHERS)], squares),
        pages.table(["recording", "estimator", "ATE m, known", "NEES / 6", "intrinsics estimated", "NEES / 6",
                     "IMU considered", "NEES / 6", "IMU estimated", "NEES / 6"], recordings),
        pages.table(["IMU", "ATE m", "NEES pose / 6", "lost", *IMU_GROUPS.values()], smoothed_imu())])


def smoothed_imu() -> list[list[str]]:
    """A row for each estimator and way: the scores, and the mean squares of the estimated parameters' errors over their
    sigmas."""
    rows = []
    for name in SMOOTHERS:
        with concurrent.futures.ThreadPoolExecutor(WORKERS) as pool:
            done = list(pool.map(lambda seed: of_imu(seed, False, 1, name), SEEDS))
        for way in ("exact", *WAYS):
            squares = [number(statistics.mean(e * e for _, of_names in done for key, (e, _) in of_names.items()
                                              if part in key), 2) if way == "estimated" else "-" for part in IMU_GROUPS]
            rows.append([f"{name}, {way}", *scores([runs[way] for runs, _ in done]), *squares])
    return rows


def calibration() -> str:
    with concurrent.futures.ThreadPoolExecutor(WORKERS) as pool:
        done = list(pool.map(of_run, range(1, RUNS + 1)))
    rows = [[name, *scores([runs[name] for runs, _ in done])] for name in done[0][0]]
    errors = grouped(of_names for _, of_names in done)
    squares = [[
        group,
        number(statistics.mean(e * e for e in of_group), 2),
        number(100 * sum(abs(e) < 3 for e in of_group) / len(of_group), 1)
    ] for group, of_group in errors.items()]
    return "\n\n".join([pages.table(["calibration", "ATE m", "NEES pose / 6", "lost"], rows),
                        pages.table(["estimated", "NEES / 1", "within 3 sigma, %"], squares)])


IMU_RUNS = 20
IMU_GROUPS = {"scale": "scale", "misalignment": "misalignment", "g_sensitivity": "g-sensitivity"}
SCALE_ALONE = sets("initial_imu_misalignment_sigma=0", "initial_g_sensitivity_sigma=0")
# What is wrong: whether the scales alone, and the number of cameras.
IMU_CASES = {"all": (False, 1), "scales": (True, 1), "scales, two cameras": (True, 2)}


def of_imu(seed: int, scale_alone: bool, cameras: int, estimator: str = "filter"
           ) -> tuple[dict[str, Json | None], dict[str, tuple[float, bool]]]:
    """The summaries of runs with an exact IMU and a wrong one; the estimated parameters' errors over their sigmas,
    and whether the motion observed them."""
    recording = OUT / f"imu-{seed}-{'scales' if scale_alone else 'all'}-{cameras}-{estimator[0]}"
    by = "--estimator", estimator
    shutil.rmtree(recording, ignore_errors=True)
    settings: Json = {"walk_duration": 30, "seed": seed, "cameras": cameras}
    chasles("simulate", "walk", *sets(*assignments(settings)), "--run", seed, "--quiet", "-o", recording)
    runs = {"exact": run(recording, "exact", *by)}
    wrong = WrongImu(recording, seed, scale_alone)
    for name, value in WAYS.items():
        runs[name] = run(recording, name, *by, *sets(f"calibrate_imu={value}"), *SCALE_ALONE * scale_alone)
    shutil.rmtree(recording)
    estimated = runs["estimated"]
    table = estimated["calibration"]["parameters"] if estimated else []
    return runs, {p["name"]: ((p["estimate"] - wrong.true[p["name"]]) / p["sigma"], p["observed"]) for p in table}


def of_recordings(setting: str) -> tuple[list[list[str]], list[tuple[str, dict[str, Json]]]]:
    """A row of ATE and NEES for each recording, with the setting false, considered and true, and the parameters of the
    last."""
    rows, found = [], []
    for name, (path, *options) in RECORDINGS.items():
        cells = [name]
        for value in ("false", "considered", "true"):
            summary = run(OUT / "real", value, *options, *sets(f"{setting}={value}"), recording=path)
            if not summary:
                cells += ["-", "-"]
                continue
            cells += [number(summary["ate_posyaw_m"], 4), number(summary["nees_pose"], 2, per=6)]
            if value == "true":
                found.append((name, {p["name"]: p for p in summary["calibration"]["parameters"]}))
        rows.append(cells)
    return rows, found


OF_RECORDINGS = ["recording", "ATE m, known", "NEES / 6", "considered", "NEES / 6", "estimated", "NEES / 6"]


def imu() -> str:
    rows, groups = [], []
    for wrong, case in IMU_CASES.items():
        with concurrent.futures.ThreadPoolExecutor(WORKERS) as pool:
            done = list(pool.map(lambda seed: of_imu(seed, *case), range(1, IMU_RUNS + 1)))
        rows += [[wrong, name, *scores([runs[name] for runs, _ in done])] for name in done[0][0]]
        for part, group in IMU_GROUPS.items():
            errors = [value for _, of_names in done for name, value in of_names.items() if part in name]
            if errors:
                groups.append([wrong, group, number(statistics.mean(e * e for e, _ in errors), 2),
                               number(100 * sum(abs(e) < 3 for e, _ in errors) / len(errors), 1),
                               number(100 * sum(observed for _, observed in errors) / len(errors), 0)])
    recordings, found = of_recordings("calibrate_imu")
    largest = []
    for name, table in found:
        moved = sorted((p for key, p in table.items() if key != "time_offset"),
                       key=lambda p: -abs(p["estimate"] / p["stated_sigma"]))
        largest += [[name, p["name"], number(p["estimate"], 5), number(p["sigma"], 5), number(p["stated_sigma"], 5)]
                    for p in moved[:3]]
    return "\n\n".join([
        pages.table(["wrong", "IMU", "ATE m", "NEES pose / 6", "lost"], rows),
        pages.table(["wrong", "estimated", "NEES / 1", "within 3 sigma, %", "observed, %"], groups),
        pages.table(OF_RECORDINGS, recordings),
        pages.table(["recording", "moved most", "estimate", "sigma", "stated sigma"], largest)])


RECORDINGS: dict[str, list[Argument]] = {
    "MH_01, mono": [EUROC / "MH_01_easy_17s", "--cameras", "mono"],
    "MH_01, stereo": [EUROC / "MH_01_easy_17s"],
    "MH_03, mono": [EUROC / "MH_03_medium_27s_mono"],
    "KITTI 00, stereo": [DATA / "kitti_images/00_first_13s"],
}


def real() -> str:
    rows, tables = of_recordings("calibrate_intrinsics")
    found = [[name, key, number(p["estimate"] - p["stated"], 4), number(p["sigma"], 4)] for name, table in tables
             for key, p in table.items() if key in ("cam0_fx", "cam0_cx", "cam0_k1", "cam0_k2")]
    return "\n\n".join([pages.table(OF_RECORDINGS, rows),
                        pages.table(["recording", "parameter", "estimate minus stated", "sigma"], found)])


TABLES = {"rolling": rolling, "wide": wide, "calibration": calibration, "imu": imu, "real": real, "smoothed": smoothed}


def main() -> None:
    p = parser(__doc__)
    p.add_argument("tables", metavar="TABLE", nargs="*", type=one_of(TABLES))
    for name in p.parse_args().tables or TABLES:
        fill(PAGE, name, TABLES[name]())


if __name__ == "__main__":
    main()
