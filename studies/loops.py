#!/usr/bin/env python3
"""python3 -m studies.loops [loops] [held-out]: runs with and without recognition, on rendered walks that see places
again, on a block of corridors that all look alike, and on real recordings. Without an argument both. Fills
studies/recognition.md. The recordings are rendered to out/loops, once: half an hour, 5 GB. Needs NumPy."""

import concurrent.futures
import math
import os
import pathlib
import shutil
import statistics
import typing

from studies.block import Revisits
from studies.pages import fill, table
from studies.program import EUROC, ROOT, Argument, Json, chasles, one_of, parser, read_json, render

OUT = ROOT / "out/loops"
PAGE = ROOT / "studies/recognition.md"
MARKERS = {PAGE: ("loops", "held-out", "revisits")}
SMALL: Json = {"rest_duration": 1, "frame_rate": 10, "focal_length": 250, "image_width": 376, "image_height": 240,
         "center_u": 187.5, "center_v": 119.5, "hall_length": 10, "sections": 8}
# The recording's name: scene, seed, settings.
SCENES: dict[str, tuple[str, int, Json]] = {
    "block-twice": ("hallway", 1, {"sections": 8}),
    "walk": ("walk", 1, {}),
    "block-12-times": ("hallway", 1, {"sections": 48, "frame_rate": 14}),
    **{f"small-{n}": ("hallway", n, SMALL) for n in range(1, 5)},
    **{f"alike-{n}": ("hallway", n, {**SMALL, "texture_period": 2.5}) for n in range(1, 5)},
}
# On these nothing was chosen.
HELD_OUT = {"small": SMALL, "alike": {**SMALL, "texture_period": 2.5}}
SEEDS = range(11, 31)
FALSE = 0.5  # [m], between the true points of what was taken for one landmark
HELD_OUT_SCENES = {f"{kind}-{n}": ("hallway", n, settings) for kind, settings in HELD_OUT.items() for n in SEEDS}
REAL: dict[str, tuple[str, list[str]]] = {"MH_01, one camera": ("MH_01_easy_17s", ["--cameras", "mono"]),
        "MH_01, stereo": ("MH_01_easy_17s", []),
        "MH_01 backwards, one camera": ("MH_01_easy_17s", ["--cameras", "mono", "--backwards"]),
        "MH_01 backwards, stereo": ("MH_01_easy_17s", ["--backwards"]),
        "MH_03": ("MH_03_medium_27s_mono", []),
        "MH_03 backwards": ("MH_03_medium_27s_mono", ["--backwards"])}


def make(name: str) -> None:
    scene, seed, settings = (SCENES | HELD_OUT_SCENES)[name]
    render(OUT / name, scene, settings, "--seed", seed)


def estimate(name: str, *more: Argument) -> tuple[str, list[Json]]:
    recording: pathlib.Path = OUT / name
    options: list[str] = []
    if name in REAL:
        recording, options = EUROC / REAL[name][0], REAL[name][1]
    folder = OUT / ("runs/" + name.replace(", ", "-").replace(" ", "-"))
    summaries = []
    for recognise in ("none", "appearance"):
        run = folder.with_name(f"{folder.name}-{recognise}")
        chasles("run", recording, *options, *more, "--set", f"recognise={recognise}", "--threads", 1, "--quiet", "-o",
                run)
        summary = read_json(run / "summary.json")
        summary["cpu"] = read_json(run / "timing.json")["seconds_cpu"]
        summaries.append(summary)
    return name, summaries


def estimate_held_out(name: str) -> tuple[str, list[Json]]:
    """The same, and how its recognition compares with the truth. The kept points take 20 MB a run."""
    name, summaries = estimate(name, "--keep-images", 1)
    for folder in (OUT / f"runs/{name}-{recognise}" for recognise in ("none", "appearance")):
        if folder.name.endswith("appearance"):
            revisits = Revisits(folder, (SCENES | HELD_OUT_SCENES)[name][2])
            summaries[1]["distances"], summaries[1]["returned"] = revisits.distances(), revisits.returned
            summaries[1]["recall"] = revisits.recall()
        shutil.rmtree(folder / "images")
        (folder / "features.csv").unlink()
    return name, summaries


def row(name: str, summaries: list[Json]) -> list[str]:
    def pair(value: typing.Callable[[Json], str]) -> str:
        return " → ".join(map(value, summaries))

    def ate(figures: Json) -> str:
        return f"{figures['ate_m']:.4f}"

    def nees(figures: Json) -> str:
        return f"{figures['nees_position'] / 3:.1f}/{figures['nees_attitude'] / 3:.1f}"

    return [name, pair(ate), pair(lambda s: ate(s["smoothed"])), pair(lambda s: nees(s["smoothed"])),
            str(len(summaries[1]["closures"])), f"{summaries[1]['cpu'] / summaries[0]['cpu']:.2f}"]


def held_out_row(kind: str, results: dict[str, list[Json]]) -> list[str]:
    """Means over the seeds; geometric ones of errors."""
    pairs = [results[f"{kind}-{n}"] for n in SEEDS]
    smoothed = [[run["smoothed"]["ate_m"] for run in pair] for pair in pairs]

    def errors(value: typing.Callable[[Json], float]) -> str:
        return " → ".join(f"{math.exp(statistics.mean(math.log(value(p[k])) for p in pairs)):.3f}" for k in (0, 1))

    def nees(k: int) -> str:
        return "/".join(f"{statistics.mean(p[k]['smoothed'][f'nees_{part}'] / 3 for p in pairs):.1f}"
                        for part in ("position", "attitude"))

    return [kind, errors(lambda s: s["ate_m"]), errors(lambda s: s["smoothed"]["ate_m"]), f"{nees(0)} → {nees(1)}",
            str(sum(len(p[1]["closures"]) for p in pairs)), str(sum(b > a for a, b in smoothed)),
            f"{max(c['moved_m'] for p in pairs for c in p[1]['closures']):.2f} m"]


def recall_cells(found: list[tuple[float, list[bool]]]) -> list[str]:
    """Of (seconds to the first one, whether there is one in each piece)."""
    pieces = [piece for _, run in found for piece in run]
    return [f"{sum(first <= 2 for first, _ in found)} / {sum(first <= 5 for first, _ in found)} of {len(found)}",
            f"{100 * statistics.mean(pieces):.0f} % of {len(pieces)}"]


def truth_row(kind: str, results: dict[str, list[Json]]) -> list[str]:
    runs = [results[f"{kind}-{n}"][1] for n in SEEDS]
    distances = [d for run in runs for d in run["distances"]]
    returned = sum(run["returned"] for run in runs)
    return [
        kind, f"{returned} ({returned - len(distances)})", f"{statistics.median(distances):.3f} m",
        f"{max(distances):.2f} m", str(sum(d > FALSE for d in distances)),
        *recall_cells([run["recall"]["found"] for run in runs]),
        *recall_cells([run["recall"]["back"] for run in runs])
    ]


def loops_part(pool: concurrent.futures.Executor) -> None:
    list(pool.map(make, SCENES))
    results = dict(pool.map(estimate, [*SCENES, *REAL]))
    head = ["recording", "ATE m", "of the smoothed path", "its NEES, position/attitude", "closures", "time"]
    fill(PAGE, "loops", table(head, [row(name, both) for name, both in results.items()]))


def held_out_part(pool: concurrent.futures.Executor) -> None:
    list(pool.map(make, HELD_OUT_SCENES))
    results = dict(pool.map(estimate_held_out, HELD_OUT_SCENES))
    head = [
        "recordings", "ATE m", "of the smoothed path", "its NEES, position/attitude", "closures", "worse paths",
        "largest jump"
    ]
    fill(PAGE, "held-out", table(head, [held_out_row(kind, results) for kind in HELD_OUT]))
    head = ["recordings", "landmarks returned (rejected later)", "distance of the true points, median", "largest",
            f"above {FALSE} m", "recognised within 2 / 5 s", "pieces recognised", "first closure within 2 / 5 s",
            "pieces with a returned landmark"]
    fill(PAGE, "revisits", table(head, [truth_row(kind, results) for kind in HELD_OUT]))


PARTS = {"loops": loops_part, "held-out": held_out_part}


def main() -> None:
    arguments = parser(__doc__)
    arguments.add_argument("parts", nargs="*", type=one_of(PARTS), metavar="PART")
    parts = arguments.parse_args().parts or PARTS
    (OUT / "runs").mkdir(parents=True, exist_ok=True)
    with concurrent.futures.ThreadPoolExecutor(int(os.environ.get("JOBS", 2))) as pool:
        for part in parts:
            PARTS[part](pool)


if __name__ == "__main__":
    main()
