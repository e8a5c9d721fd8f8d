#!/usr/bin/env python3
"""python3 -m studies.inertial [TABLE...]: makes the tables of docs/inertial-results.md (april, flights, walks;
default: all) and fills them in between their markers. It takes half an hour of processor time on two
cores, most of it for the ten runs of each walk."""

import pathlib
import shutil
import typing

from studies.pages import fill, parts, row
from studies.program import DATA, EUROC, ROOT, Argument, Json, chasles, one_of, parser, read_json, read_json_lines

OUT = ROOT / "out/inertial"
PAGE = ROOT / "docs/inertial-results.md"
CAMERAS = {"mono": 1, "stereo": 2}


def fresh(name: str) -> pathlib.Path:
    folder = OUT / name
    shutil.rmtree(folder, ignore_errors=True)
    folder.parent.mkdir(parents=True, exist_ok=True)
    return folder


def run(name: str, recording: pathlib.Path, *arguments: Argument) -> list[Json]:
    """summary.json and timing.json of a run."""
    folder = fresh(name)
    chasles("run", recording, "-o", folder, *arguments, "--quiet")
    return [read_json(folder / f) for f in ("summary.json", "timing.json")]


def trials(name: str, *arguments: Argument) -> list[Json]:
    """The result of each run of a Monte Carlo study."""
    folder = fresh(name)
    chasles("montecarlo", "trajectory", "-o", folder, *arguments, "--quiet")
    return read_json_lines(folder / "trials.jsonl")


def april() -> typing.Iterator[list[str]]:
    for chart in ("standard", "left-se3", "right-se3", "right-sen3"):
        cells = [f"`{chart}`"]
        for cameras in ("stereo", "mono"):
            summary, timing = run(f"april-{chart}-{cameras}", EUROC / "imu_april", "--config",
                                  "studies/configs/euroc.yaml", "--begin", "truth", "--cameras", cameras, "--chart",
                                  chart)
            cells += [
                f"{summary['ate_m']:.4f}", f"{summary['nis_per_dof']:.2f}", f"{timing['filter_ms_per_frame']:.1f}"
            ]
        yield cells


def flights() -> typing.Iterator[list[str]]:
    names = ("MH_01_easy", "MH_03_medium", "V1_01_easy", "V1_02_medium", "V2_01_easy")
    kinds = [(cameras, agreed) for agreed in (False, True) for cameras in CAMERAS]
    sums = dict.fromkeys(kinds, 0.0)
    for name in names:
        cells = [name]
        for cameras, agreed in kinds:
            ate = trials(f"flight-{name}-{cameras}{'-agreed' * agreed}", "--runs", 1, "--path",
                         EUROC / f"imu_gt/{name}_imu.csv.gz", "--real-imu", *["--agreed-truth"] * agreed, "--config",
                         "studies/configs/real-imu.yaml", "--scene-config", "studies/configs/scene-real-imu.yaml",
                         "--scene-set", f"cameras={CAMERAS[cameras]}")[0]["ate_posyaw_m"]
            sums[cameras, agreed] += ate
            cells.append(f"{ate:.3f}")
        yield cells
    yield ["mean", *(f"{s / len(names):.3f}" for s in sums.values())]


# OpenVINS's figures as the project was given them: metres, degrees, milliseconds.
WALKS = {
    "tum_corridor1_512_16_okvis": ("tum_corridor1, 299 s", {"mono": (0.053, 0.19, 7.4), "stereo": (0.032, 0.15, 12)}),
    "udel_gore": ("udel_gore, 172 s", {"mono": (0.075, 0.24, 8.6), "stereo": (0.043, 0.21, 15)})
}


def walks() -> typing.Iterator[list[str]]:
    for name, (title, openvins) in WALKS.items():
        path = DATA / f"trajectories/{name}.txt"
        for cameras, count in CAMERAS.items():
            each = trials(f"walk-{name}-{cameras}", "--runs", 10, "--path", path, "--config",
                          "studies/configs/long-walk.yaml", "--scene-config", "studies/configs/scene-long-walk.yaml",
                          "--scene-set", f"cameras={count}")
            recording = fresh(f"recording-{name}-{cameras}")
            chasles("simulate", "trajectory", "--path", path, "-o", recording, "--config",
                    "studies/configs/scene-long-walk.yaml", "--set", f"cameras={count}", "--quiet")
            # The least of three, because other programs also use the machine.
            ms = min(run("timed", recording, "--config", "studies/configs/long-walk.yaml", "--begin",
                         "truth")[1]["filter_ms_per_frame"] for _ in range(3))
            names = ("ate_posyaw_m", "attitude_posyaw_deg", "nees_pose")
            mean = {key: sum(t[key] for t in each) / len(each) for key in names}
            yield [title if count == 1 else "", cameras, f"{mean['ate_posyaw_m']:.3f}",
                   f"{max(t['ate_posyaw_m'] for t in each):.3f}", f"{mean['attitude_posyaw_deg']:.2f}",
                   f"{mean['nees_pose'] / 6:.2f}", f"{ms:.1f}", *map(str, openvins[cameras])]


TABLES = {"april": april, "flights": flights, "walks": walks}
MARKERS = {PAGE: tuple(TABLES)}


def main() -> None:
    arguments = parser(__doc__)
    arguments.add_argument("tables", nargs="*", type=one_of(TABLES), metavar="TABLE")
    for name in arguments.parse_args().tables or TABLES:
        caption = "".join(parts(PAGE, name)[1].splitlines(keepends=True)[:2])
        text = "\n".join(map(row, TABLES[name]()))
        print(text, flush=True)
        fill(PAGE, name, caption + text)

if __name__ == "__main__":
    main()
