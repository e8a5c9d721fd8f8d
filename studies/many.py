#!/usr/bin/env python3
"""python3 -m studies.many [TABLE...]: batches of recordings (docs/many.md). Fills
studies/many.md between its markers.

verdicts   200 rendered recordings of an action camera, a tenth of them faulty: verdicts against the truth.
real       the recordings of shared/data with images or a board.
circles    20 simulated runs half around a cube at constant speed, where a start in motion hardly has the scale.
place      one walk makes the map, 50 pieces of another one find their places in it.
cost       the same 20 recordings in a batch and in a loop of `chasles run`.
executors  10,000 tasks of 10 ms on Dask and on processes. Needs the packages of tools/interop.

Without a name it makes all but the last. It renders to out/many, once: half an hour. Needs NumPy."""

import concurrent.futures
import json
import math
import os
import pathlib
import random
import resource
import shutil
import time
import typing

import numpy

from studies import pages
from studies.arrays import Array, rotations, tum
from studies.many_recordings import CAMERA, make_all, fault_of
from studies.pages import fill, number
from studies.program import DATA, ROOT, Argument, Json, chasles, one_of, parser, read_json, read_json_lines, render

OUT = ROOT / "out/many"
PAGE = ROOT / "studies/many.md"
MARKERS = {PAGE: ("verdicts", "faults", "real", "circles", "place", "cost", "executors")}
RECORDINGS = int(os.environ.get("RECORDINGS", "200"))
WORKERS = int(os.environ.get("WORKERS", "2"))
WORST_CODES = (0, 2, 5)  # exit codes of a batch


def run_batch(folder: pathlib.Path, items: typing.Iterable[Json], *arguments: Argument,
              jobs: int = WORKERS) -> list[Json]:
    """The records of a batch, which is continued where there is a part of it."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    manifest = folder.with_suffix(".list")
    manifest.write_text("".join(json.dumps(item) + "\n" for item in items))
    chasles("batch", "--manifest", manifest, "--resume", "--quiet", "--jobs", jobs, "-o", folder, *arguments,
            accepted=WORST_CODES)
    return read_json_lines(folder / "verdicts.jsonl")


MOST_TRUTH_GAP = 0.2  # [s], as chasles evaluate


def turn(angle: float) -> Array:
    """The rotation about z by an angle."""
    c, s = math.cos(angle), math.sin(angle)
    return numpy.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def heading(R: Array) -> Array:
    """The rotation about z that is nearest to R."""
    return turn(math.atan2(R[1, 0] - R[0, 1], R[0, 0] + R[1, 1]))


def worst_error(run: pathlib.Path, path: str = "trajectory_smoothed.tum") -> float:
    """The largest error of a position, relative to the first pose: aligned by its position and heading [m]. Poses in
    gaps of the truth are left out."""
    file = run / path
    poses, truth = tum(file if file.exists() else run / "trajectory.tum"), tum(run / "truth.tum")
    after = numpy.clip(numpy.searchsorted(truth[:, 0], poses[:, 0]), 1, len(truth) - 1)
    poses = poses[truth[after, 0] - truth[after - 1, 0] <= MOST_TRUTH_GAP]
    true = numpy.stack([numpy.interp(poses[:, 0], truth[:, 0], truth[:, k]) for k in (1, 2, 3)], axis=1)
    nearest = int(numpy.argmin(abs(truth[:, 0] - poses[0, 0])))
    R = heading(rotations(poses[:1, 4:8])[0] @ rotations(truth[[nearest], 4:8])[0].T)
    error = poses[:, 1:4] - poses[0, 1:4] - (true - true[0]) @ R.T
    return float(numpy.linalg.norm(error, axis=1).max())


def verdicts() -> None:
    recordings = make_all(OUT / "recordings", RECORDINGS, WORKERS)
    rows, of_faults = [], []
    for estimator in ("filter", "batch"):
        folder = OUT / f"verdicts-{estimator}"
        records = run_batch(folder, [{"recording": str(one)} for one in recordings], "--estimator", estimator)
        errors = {r["name"]: worst_error(folder / "runs" / r["name"]) for r in records if "bound_m" in r}
        good = [r for i, r in enumerate(records) if not fault_of(i)]
        faulty = [(fault, r) for i, r in enumerate(records) if (fault := fault_of(i))]
        used = [r for r in records if r["verdict"] == "use"]
        ratios = sorted(errors[r["name"]] / r["bound_m"] for r in used)
        rows.append([estimator, f"{sum(r['verdict'] == 'use' for r in good)} of {len(good)}",
                     f"{sum(r['verdict'] == 'use' for _, r in faulty)} of {len(faulty)}",
                     f"{sum(fault.is_named(r) for fault, r in faulty)} of {len(faulty)}",
                     f"{sum(ratio > 1 for ratio in ratios)} of {len(used)}", number(ratios[len(ratios) // 2], 2),
                     number(ratios[-1], 2)])
        if estimator == "filter":
            for fault, record in faulty:
                reasons = [one["reason"] for one in record["reasons"]]
                of_faults.append([fault.make.__name__.replace("_", " "), record["verdict"], ", ".join(reasons) or "-",
                                  number(errors.get(record["name"]), 3), number(record.get("bound_m"), 3)])
        for record in good:
            if record["verdict"] != "use":
                print(estimator, record["name"], record["verdict"], record["reasons"])
    head = ["estimator", "good ones with `use`", "faulty ones with `use`", "right reason",
            "errors above the bound, of `use`", "error over bound, median", "largest"]
    fill(PAGE, "verdicts", pages.table(head, rows))
    fill(PAGE, "faults", pages.table(["fault", "verdict", "reasons", "largest error m", "bound m"], of_faults))


CIRCLES = 20


def circles() -> None:
    recordings = []
    for run in range(CIRCLES):
        recording = OUT / "circles" / f"circle-{run:02d}"
        if not recording.exists():
            chasles("simulate", "turntable", "--set", "revolutions=0.5", "--run", run, "--quiet", "-o", recording)
        recordings.append({"recording": str(recording)})
    rows = []
    for estimator in ("filter", "window:20", "batch"):
        folder = OUT / f"circles-{estimator.replace(':', '')}"
        shutil.rmtree(folder, ignore_errors=True)
        records = run_batch(folder, recordings, "--estimator", estimator)
        ratios = sorted(worst_error(folder / "runs" / r["name"]) / r["bound_m"] for r in records if r.get("bound_m"))
        rows.append([estimator, str(sum(r["verdict"] == "use" for r in records)), str(sum(x > 1 for x in ratios)),
                     number(ratios[len(ratios) // 2], 2), number(ratios[-1], 2)])
    head = ["estimator", "`use`", "errors above the bound", "error over bound, median", "largest"]
    fill(PAGE, "circles", pages.table(head, rows))


REAL = ("euroc/MH_01_easy_17s", "euroc/MH_03_medium_27s_mono", "euroc/imu_april", "kitti_images/00_first_13s")


def real() -> None:
    rows = []
    for estimator in ("filter", "batch"):
        folder = OUT / f"real-{estimator}"
        shutil.rmtree(folder, ignore_errors=True)
        for r in run_batch(folder, [{"recording": str(DATA / name)} for name in REAL], "--estimator", estimator):
            reasons = ", ".join(one["reason"] for one in r["reasons"]) or "-"
            error = worst_error(folder / "runs" / r["name"])
            rows.append([r["name"], estimator, r["verdict"], reasons, number(error, 3), number(r["bound_m"], 3),
                         number(r["nees_pose"], 1, per=6)])
    head = ["recording", "estimator", "verdict", "reasons", "largest error m", "bound m", "NEES pose / 6"]
    fill(PAGE, "real", pages.table(head, rows))


MAPPED: Json = {**CAMERA, "texture_period": 0}
PIECES, PIECE_SECONDS = 50, 6.0


class InMap:
    """True positions in the frame of a map: the truth of the recording that made it, aligned by its smoothed path."""

    def __init__(self, of_map: pathlib.Path) -> None:
        poses, truth = tum(of_map / "trajectory_smoothed.tum"), tum(of_map / "truth.tum")
        true = self._at(truth, poses[:, 0])
        a, b = poses[:, 1:4] - poses[:, 1:4].mean(axis=0), true - true.mean(axis=0)
        angle = numpy.arctan2((b[:, 0] * a[:, 1] - b[:, 1] * a[:, 0]).sum(), (b[:, :2] * a[:, :2]).sum())
        self.R: Array = turn(angle)
        self.p: Array = poses[:, 1:4].mean(axis=0) - self.R @ true.mean(axis=0)

    @staticmethod
    def _at(truth: Array, times: Array) -> Array:
        return numpy.stack([numpy.interp(times, truth[:, 0], truth[:, k]) for k in (1, 2, 3)], axis=1)

    def errors(self, run: pathlib.Path) -> Array:
        poses = tum(run / "trajectory_in_map.tum")
        true = self._at(tum(run / "truth.tum"), poses[:, 0]) @ self.R.T + self.p
        return numpy.linalg.norm(poses[:, 1:4] - true, axis=1)


def place() -> None:
    of_map, again = OUT / "map-walk", OUT / "demonstrations"
    render(of_map, "hallway", MAPPED, "--run", 1)
    render(again, "hallway", {**MAPPED, "step_rate": 1.5}, "--run", 2)
    chance = random.Random(1)
    items: list[Json] = [{"recording": str(of_map)}]
    for i in range(PIECES):
        start = round(chance.uniform(2, 60), 2)
        items.append({"recording": str(again), "name": f"piece-{i:02d}", "start": start, "stop": start + PIECE_SECONDS})
    folder = OUT / "place"
    records = run_batch(folder, items, "--map-from", of_map)[1:]
    truth = InMap(folder / "runs" / of_map.name)
    found = [r for r in records if r.get("path") == "in_map"]
    errors = [truth.errors(folder / "runs" / r["name"]) for r in found]
    delays = []
    for record in found:
        run = folder / "runs" / record["name"]
        first = tum(run / "trajectory.tum")[0, 0] - record["start_seconds"]
        delays.append(round(tum(run / "trajectory_in_map.tum")[0, 0] - first, 3))
    medians = [float(numpy.median(e)) for e in errors]
    within = [f"{sum(d <= s for d in delays)} / {len(records)}" for s in (1, 2, 3)]
    verdict = {v: sum(r["verdict"] == v for r in records) for v in ("use", "check", "no")}
    fill(PAGE, "place", pages.table(
        ["pieces", "found", "first pose in the map within 1 s", "2 s", "3 s", "error, median",
         "largest of a piece's medians", "errors above the bound, of `use`", "use / check / no"],
        [[str(len(records)), str(len(found)), *within, number(float(numpy.median(medians)), 3) + " m",
          number(max(medians), 3) + " m",
          str(sum(float(e.max()) > r["bound_m"] for e, r in zip(errors, found) if r["verdict"] == "use")),
          " / ".join(str(n) for n in verdict.values())]]))


def cpu() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def cost() -> None:
    recordings = make_all(OUT / "recordings", 20, WORKERS)
    recordings = [one for i, one in enumerate(recordings) if not fault_of(i)]
    rows: list[list[str]] = []

    def timed(name: str, action: typing.Callable[[], object]) -> None:
        wall, before = time.monotonic(), cpu()
        action()
        wall, used = time.monotonic() - wall, cpu() - before
        hours = 3600 / wall * len(recordings)
        rows.append([name, number(wall, 1), number(used, 1), number(hours, 0)])
        print(*rows[-1], flush=True)

    def loop(*arguments: Argument) -> None:
        for recording in recordings:
            chasles("run", recording, "--quiet", "-o", OUT / "cost" / recording.name, *arguments, silent=True)

    items = [{"recording": str(one)} for one in recordings]

    def in_a_batch(jobs: int, *arguments: Argument) -> None:
        folder = OUT / "cost-batch"
        shutil.rmtree(folder, ignore_errors=True)
        run_batch(folder, items, *arguments, jobs=jobs)

    timed("loop of `chasles run`", loop)
    timed("loop of `chasles run --threads 1`", lambda: loop("--threads", 1))
    of_filter = ("--estimator", "filter")
    timed("`chasles batch --estimator filter --jobs 1 --no-check`", lambda: in_a_batch(1, *of_filter, "--no-check"))
    timed("`chasles batch --estimator filter --jobs 2 --no-check`", lambda: in_a_batch(2, *of_filter, "--no-check"))
    timed("`chasles batch --estimator filter --jobs 2`", lambda: in_a_batch(2, *of_filter))
    timed("`chasles batch --jobs 2`, batch estimation", lambda: in_a_batch(2))
    fill(PAGE, "cost", pages.table(["way", "wall s", "CPU s", "recordings an hour"], rows))


TASKS = 10_000
SHORT, RUN = 0.010, 4.0  # seconds of a task: so short that its cost shows, and as a run of a recording


def short(item: int) -> int:
    time.sleep(SHORT)
    return item


def as_long_as_a_run(item: int) -> int:
    time.sleep(RUN)
    return item


def executors() -> None:
    from chasles._executors import stream

    rows = []

    def timed(name: str, executor: typing.Any, workers: int, task: typing.Callable[[int], int], seconds: float) -> None:
        list(stream(executor, task, range(workers)))  # its workers have started
        peak, begin = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, time.monotonic()
        count = sum(1 for _ in stream(executor, task, range(TASKS)))
        wall = time.monotonic() - begin
        grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - peak
        assert count == TASKS
        least = TASKS * seconds / workers
        rows.append([name, str(workers), number(seconds, 2), number(wall, 1), number(100 * (wall / least - 1), 0),
                     number(grown / 1024, 1)])
        print(*rows[-1], flush=True)

    with concurrent.futures.ProcessPoolExecutor(2) as pool:
        timed("ProcessPoolExecutor", pool, 2, short, SHORT)
    import distributed

    cluster: typing.Any = distributed.LocalCluster
    client: typing.Any = distributed.Client
    with cluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as two, client(two) as connected:
        timed("Dask", connected.get_executor(), 2, short, SHORT)
    # Threads that sleep stand for the workers; scheduler and client are as with a cluster.
    with cluster(n_workers=10, threads_per_worker=100, dashboard_address=None) as many, client(many) as connected:
        timed("Dask, simulated", connected.get_executor(), 1000, as_long_as_a_run, RUN)
    head = ["executor", "workers", "task s", "wall s", "above the least %", "growth of the client MB"]
    fill(PAGE, "executors", pages.table(head, rows))


TABLES = {"verdicts": verdicts, "real": real, "circles": circles, "place": place, "cost": cost, "executors": executors}


def main() -> None:
    arguments = parser(__doc__)
    arguments.add_argument("tables", nargs="*", type=one_of(TABLES), metavar="TABLE",
                           help="all but executors by default")
    for name in arguments.parse_args().tables or [name for name in TABLES if name != "executors"]:
        TABLES[name]()


if __name__ == "__main__":
    main()
