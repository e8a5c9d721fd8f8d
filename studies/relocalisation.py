#!/usr/bin/env python3
"""python3 -m studies.relocalisation [starts] [conditions] [flights] [others] [merging]: runs that begin at random places of a map which
another run saved, in rendered corridors and on real flights, and runs in maps of other places, and merges maps; without
an argument all of them. Fills studies/recognition.md. The recordings are rendered to out/loops, once: half an hour. Needs NumPy."""

import concurrent.futures
import itertools
import json
import os
import pathlib
import random
import subprocess
import sys
import textwrap

import numpy

from studies.block import Block
from studies.maps import SavedMap
from studies.pages import fill

ROOT = pathlib.Path(__file__).resolve().parent.parent
CHASLES = pathlib.Path(os.environ.get("CHASLES_BINARY", ROOT / "build/release/bin/chasles"))
DATA = ROOT.parent / "shared/data/euroc"
OUT = ROOT / "out/loops"
DOCS = ROOT / "studies/recognition.md"
MAPPED = {"block": ("hallway", {}), "walk": ("walk", {}), "alike": ("hallway", {"texture_period": 2.5})}
# The same buildings, walked with other steps.
AGAIN = {f"{name}-again": (scene, {**settings, "step_rate": 1.5}) for name, (scene, settings) in MAPPED.items()}
# The block after a part of it was redecorated, and with another camera than the map's.
OTHER_CAMERA = {"focal_length": 330, "image_width": 600, "image_height": 400, "center_u": 305, "center_v": 195,
                "frame_rate": 20, "distortion": "radtan", "distortion_1": -0.28, "distortion_2": 0.07}
CONDITIONS = {"block-changed-50": ("hallway", {"step_rate": 1.5, "texture_changed": 0.5}, 1),
              "block-other-camera": ("hallway", {"step_rate": 1.5, **OTHER_CAMERA}, 1)}
# Walks through one building, each with its own steps and noise; starts are in the last one.
WALKS = {f"block-walk-{n}": ("hallway", {"step_rate": rate}, n) for n, rate in ((1, 2), (2, 1.5), (3, 1.75), (4, 1.25))}
STARTS, SECONDS = 100, 5
STARTS_HEAD = ["| recording | starts | found within 2 / 3 / 5 s | 0 / 0.5 / 1 s after the initialisation | first error, median "
               "| largest | its NEES, position/attitude | error after 5 s |", "|---|---|---|---|---|---|---|---|"]


def chasles(*arguments):
    done = subprocess.run([CHASLES, *map(str, arguments)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    if done.returncode not in (0, 3):
        raise SystemExit(f"studies/relocalisation.py: chasles {' '.join(map(str, arguments))}: {done.stderr}")
    return done.returncode == 0


def render(name, scene, settings, noise=0):
    if not (OUT / name).exists():
        chosen = [part for key, value in settings.items() for part in ("--set", f"{key}={value}")]
        chasles("simulate", scene, "--run", noise, *chosen, "--images", "--threads", "1", "--quiet", "-o", OUT / name)


def rotation(q):
    x, y, z, w = q
    return numpy.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def log(R):
    v = numpy.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
    sine = numpy.linalg.norm(v)
    return v if sine < 1e-9 else v * numpy.arctan2(sine, (numpy.trace(R) - 1) / 2) / sine


class Truth:
    """The true poses of a run, in the frame of a map: that of the run that saved it, aligned by its path, or by its
    first pose, which defines it."""

    def __init__(self, of_map, by_first_pose=False):
        poses, truth = numpy.loadtxt(of_map / "trajectory_smoothed.tum"), numpy.loadtxt(of_map / "truth.tum")
        known = self.positions(truth, poses[:, 0])
        if by_first_pose:
            R = rotation(poses[0, 4:8]) @ rotation(truth[numpy.argmin(abs(truth[:, 0] - poses[0, 0])), 4:8]).T
            angle = numpy.arctan2(R[1, 0] - R[0, 1], R[0, 0] + R[1, 1])
            self.R = numpy.array([[numpy.cos(angle), -numpy.sin(angle), 0], [numpy.sin(angle), numpy.cos(angle), 0],
                                  [0, 0, 1]])
            self.p = poses[0, 1:4] - self.R @ known[0]
            return
        a, b = known - known.mean(0), poses[:, 1:4] - poses[:, 1:4].mean(0)
        U, _, V = numpy.linalg.svd(a.T @ b)
        self.R = V.T @ numpy.diag([1, 1, numpy.sign(numpy.linalg.det(V.T @ U.T))]) @ U.T
        self.p = poses[:, 1:4].mean(0) - self.R @ known.mean(0)

    @staticmethod
    def positions(truth, times):
        return numpy.array([numpy.interp(times, truth[:, 0], truth[:, k]) for k in (1, 2, 3)]).T

    def errors(self, run):
        """Of every pose in the map: [rotation, position], and the NEES of both by their degrees of freedom."""
        rows = numpy.loadtxt(run / "in_map.csv", delimiter=",", skiprows=1, ndmin=2)
        truth = numpy.loadtxt(run / "truth.tum")
        known = self.positions(truth, 1e-9 * rows[:, 0])
        errors, nees = [], []
        for row, p in zip(rows, known):
            near = truth[numpy.argmin(abs(truth[:, 0] - 1e-9 * row[0]))]
            e = numpy.concatenate([log(rotation(row[4:8]) @ (self.R @ rotation(near[4:8])).T),
                                   row[1:4] - self.R @ p - self.p])
            P = numpy.zeros((6, 6))
            P[numpy.triu_indices(6)] = row[14:35]
            P = P + P.T - numpy.diag(numpy.diag(P))
            errors.append(e)
            nees.append([e[k:k + 3] @ numpy.linalg.solve(P[k:k + 3, k:k + 3], e[k:k + 3]) / 3 for k in (3, 0)])
        return rows, numpy.array(errors), numpy.array(nees)


def save_map(name, recording, *options):
    run, file = OUT / f"runs/map-{name}", OUT / f"runs/{name}.map"
    if not file.exists():
        chasles("run", recording, *options, "--save-map", file, "--threads", "1", "--quiet", "-o", run)
    return run, file


def place(name, recording, file, *options):
    """Of a run in a map: its folder, the seconds from its first image to the place, and its summary. The run learns of a
    place in the frames of the initialisation when that ends."""
    run = OUT / "runs/in-map" / name
    if not chasles("run", recording, *options, "--map", file, "--threads", "1", "--quiet", "-o", run):
        return run, None, None
    summary = json.loads((run / "summary.json").read_text())
    placed = summary["place_in_map"]["placed_ns"]
    if placed is None:
        return run, None, summary
    first = numpy.loadtxt(run / "trajectory.tum", ndmin=2)[0, 0] - summary["start_seconds"]
    return run, max(1e-9 * placed - first, summary["initialised_seconds"]), summary


def length_of(name):
    return numpy.loadtxt(OUT / f"runs/map-{name}/truth.tum")[-1, 0]


def anywhere(name):
    generator = random.Random(1)
    return [generator.uniform(2, length_of(name) - SECONDS - 1) for _ in range(STARTS)]


def starts(name, recording, options, of_map, file, times, pool, by_first_pose=False):
    """Runs of a few seconds that begin at these times."""
    truth, folder = Truth(of_map, by_first_pose), name.replace(" ", "-").replace(",", "")

    def one(i):
        run, seconds, summary = place(f"{folder}-{i}", recording, file, *options, "--start", times[i],
                                      "--stop", times[i] + SECONDS)
        if seconds is None:
            return summary, None
        _, errors, nees = truth.errors(run)
        return summary, (seconds, seconds - summary["initialised_seconds"], numpy.linalg.norm(errors[0, 3:]), numpy.degrees(numpy.linalg.norm(errors[0, :3])),
                         *nees[0], numpy.linalg.norm(errors[-1, 3:]))

    results = list(pool.map(one, range(len(times))))
    started = [summary for summary, _ in results if summary]
    placed = numpy.array([found for _, found in results if found])
    if not len(placed):
        placed = numpy.full((1, 7), numpy.nan)

    def share(k, limits):
        within = (100 * numpy.mean([found is not None and found[k] <= s for _, found in results]) for s in limits)
        return " / ".join(f"{percent:.0f}" for percent in within)

    return (f"| {name} | {len(times)} ({len(times) - len(started)} without a start) | {share(0, (2, 3, 5))} % | "
            f"{share(1, (0, 0.5, 1))} % | {numpy.median(placed[:, 2]):.3f} m, {numpy.median(placed[:, 3]):.2f}° | "
            f"{placed[:, 2].max():.2f} m | {placed[:, 4].mean():.1f}/{placed[:, 5].mean():.1f} | "
            f"{numpy.median(placed[:, 6]):.3f} m |")


def flight(name, recording, options, of_map, file):
    run, seconds, summary = place(name.replace(" ", "-").replace(",", ""), recording, file, *options)
    if seconds is None:
        return f"| {name} | not found | | | |"
    _, errors, nees = Truth(of_map).errors(run)
    positions = numpy.linalg.norm(errors[:, 3:], axis=1)
    return (f"| {name} | {seconds:.1f} s | {positions[0]:.3f} m | {numpy.median(positions):.3f} m | "
            f"{nees[:, 0].mean():.1f}/{nees[:, 1].mean():.1f} |")


def starts_part(pool):
    rows = [starts(name, OUT / f"{name}-again", [], *save_map(name, OUT / name), anywhere(name), pool)
            for name in MAPPED]
    fill(DOCS, "starts", "\n".join(STARTS_HEAD + rows))


def conditions_part(pool):
    rows = [starts(name, OUT / name, [], *save_map("block", OUT / "block"), anywhere("block"), pool)
            for name in CONDITIONS]
    of_hall = save_map("MH_01", DATA / "MH_01_easy_17s")
    for name, recording, options, seconds in (("MH_01 backwards, one camera", "MH_01_easy_17s",
                                               ["--backwards", "--cameras", "mono"], 17),
                                              ("MH_03", "MH_03_medium_27s_mono", [], 27)):
        times = [0.5 * i for i in range(2 * (seconds - SECONDS) + 1)]
        rows.append(starts(name, DATA / recording, options, *of_hall, times, pool))
    fill(DOCS, "conditions", "\n".join(STARTS_HEAD + rows))


def flights_part(pool):
    of_map, file = save_map("MH_01", DATA / "MH_01_easy_17s")
    flights = [flight(name, DATA / recording, options, of_map, file) for name, recording, options in (
        ("MH_01 backwards", "MH_01_easy_17s", ["--backwards"]),
        ("MH_01 backwards, one camera", "MH_01_easy_17s", ["--backwards", "--cameras", "mono"]),
        ("MH_03", "MH_03_medium_27s_mono", []),
        ("MH_03 backwards", "MH_03_medium_27s_mono", ["--backwards"]))]
    head = ["| recording | found after | first error | median error | NEES, position/attitude |", "|---|---|---|---|---|"]
    fill(DOCS, "flights", "\n".join(head + flights))


def others_part(pool):
    others = [("MH_01_easy_17s", "block"), ("MH_03_medium_27s_mono", "walk"), ("MH_01_easy_17s", "alike")]
    pairs = [(DATA / recording, OUT / f"runs/{name}.map") for recording, name in others]
    pairs += [(OUT / f"{a}-again", OUT / f"runs/{b}.map") for a in MAPPED for b in MAPPED if a != b]
    _, file = save_map("MH_01", DATA / "MH_01_easy_17s")
    pairs += [(OUT / f"{a}-again", file) for a in MAPPED]
    wrong = list(pool.map(lambda i: place(f"other-{i}", *pairs[i])[1:], range(len(pairs))))
    proposed = sum(summary["place_in_map"]["proposed"] for _, summary in wrong)
    searches = sum(summary["place_in_map"]["searches"] for _, summary in wrong)
    accepted = sum(seconds is not None for seconds, _ in wrong)
    fill(DOCS, "others", f"{len(pairs)} runs in maps of other places made {searches} searches. These proposed "
                         f"{proposed} places, and {accepted} were accepted.")


def true_landmarks(name):
    """Of each landmark of the walk's map, by its appearances: the true point."""
    run, file = save_map(name, OUT / name, "--keep-images", 1)
    block, saved = Block(run, {}), SavedMap(file)
    rows = numpy.loadtxt(run / "landmarks.csv", delimiter=",", skiprows=1)
    ids = [int(rows[numpy.argmin(numpy.linalg.norm(rows[:, 1:4] - p, axis=1)), 0]) for p in saved.p]
    return {appearances: block.point(number) for appearances, number in zip(saved.appearances, ids)}


def merged(name, *files):
    """The merged map, and what the merge says of it."""
    result = OUT / f"runs/{name.replace(' ', '')}.map"
    done = subprocess.run([CHASLES, "map", "merge", *files, "-o", result, "--json"], capture_output=True, text=True,
                          check=True)
    return result, json.loads(done.stdout)


def same_bytes(files):
    """Of every order in which three maps can be merged, at once and in turn, all results and how many they are."""
    results = set()
    for n, order in enumerate(itertools.permutations(files)):
        at_once, _ = merged(f"order-{n}", *order)
        two, _ = merged(f"two-{n}", *order[:2])
        left, _ = merged(f"left-{n}", two, order[2])
        right, _ = merged(f"right-{n}", order[2], two)
        results |= {file.read_bytes() for file in (at_once, left, right)}
    return len(results), 3 * (n + 1)


def merging_part(pool):
    list(pool.map(lambda item: render(item[0], *item[1]), WALKS.items()))
    *mapped, last = WALKS
    true = {}
    for found in pool.map(true_landmarks, mapped):
        true |= found
    runs, files = zip(*(save_map(name, OUT / name) for name in mapped))
    maps = {f"walk {i + 1}": (runs[i], files[i], None) for i in range(3)}
    for name, chosen in {"1 + 2": (0, 1), "1 + 2 + 3": (0, 1, 2)}.items():
        file, said = merged(name, *(files[i] for i in chosen))
        maps[name] = (runs[mapped.index(said["frame"])], file, said)
    rows = []
    for name, (run, file, both) in maps.items():
        saved, size = SavedMap(file), file.stat().st_size
        matches = " and ".join(str(joined["matches"]) for joined in both["joined"]) if both else ""
        nis = " and ".join(f"{joined['nis_per_dof']:.2f}" for joined in both["joined"]) if both else ""
        frame, P = Truth(run, by_first_pose=True), saved.covariances()
        e = saved.p - numpy.array([true[appearances] for appearances in saved.appearances]) @ frame.R.T - frame.p
        nees = numpy.einsum("ni,ni->n", e, numpy.linalg.solve(P, e[..., None])[..., 0])
        sigma = numpy.sqrt(numpy.trace(P, axis1=1, axis2=2))
        rows.append(f"| {name} | {len(saved.p)} | {size / len(saved.p):.0f} | {matches} | {nis} | "
                    f"{numpy.median(numpy.linalg.norm(e, axis=1)):.3f} m | {numpy.median(sigma):.3f} m | "
                    f"{numpy.median(nees) / 3:.2f} | {100 * numpy.mean(nees < 7.815):.0f} % |")
    head = ["| map | landmarks | bytes a landmark | of both | NIS of the merge | error of a landmark, median | its sigma | "
            "its NEES, median | within 95 % |", "|---|---|---|---|---|---|---|---|---|"]
    different, ways = same_bytes(files)
    note = (f"The {ways} ways to merge the three, at once or in turn, give {different} different file"
            f"{'' if different == 1 else 's'}. The frame is that of walk "
            f"{mapped.index(maps['1 + 2 + 3'][2]['frame']) + 1}.")
    fill(DOCS, "merging", "\n".join(head + rows) + "\n\n" + textwrap.fill(note, 100))
    times = anywhere("block")[:30]
    rows = [starts(f"in the map {name}", OUT / last, [], run, file, times, pool, by_first_pose=True)
            for name, (run, file, _) in maps.items() if name in ("walk 1", "1 + 2 + 3")]
    fill(DOCS, "merged-starts", "\n".join(STARTS_HEAD + rows))


PARTS = {"starts": starts_part, "conditions": conditions_part, "flights": flights_part, "others": others_part,
         "merging": merging_part}


def main():
    (OUT / "runs/in-map").mkdir(parents=True, exist_ok=True)
    with concurrent.futures.ThreadPoolExecutor(int(os.environ.get("JOBS", 2))) as pool:
        list(pool.map(lambda item: render(item[0], *item[1]), {**MAPPED, **AGAIN, **CONDITIONS}.items()))
        for part in sys.argv[1:] or PARTS:
            PARTS[part](pool)


if __name__ == "__main__":
    main()
