#!/usr/bin/env python3
"""python3 -m studies.inertial [TABLE...]: makes the tables of docs/inertial-results.md (april, flights, walks;
default: all) and fills them in between their markers. It takes half an hour of processor time on two
cores, most of it for the ten runs of each walk."""

import json
import os
import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
CHASLES = pathlib.Path(os.environ.get("CHASLES_BINARY", ROOT / "build/release/bin/chasles"))
DATA = pathlib.Path(os.environ.get("CHASLES_DATA", ROOT / "../shared/data"))
OUT = ROOT / "out/inertial"
PAGE = ROOT / "docs/inertial-results.md"
CAMERAS = {"mono": 1, "stereo": 2}


def chasles(*arguments):
    command = [str(a) for a in (CHASLES, *arguments, "--quiet")]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, cwd=ROOT)


def fresh(name):
    folder = OUT / name
    shutil.rmtree(folder, ignore_errors=True)
    folder.parent.mkdir(parents=True, exist_ok=True)
    return folder


def run(name, recording, *arguments):
    """summary.json and timing.json of a run."""
    folder = fresh(name)
    chasles("run", recording, "-o", folder, *arguments)
    return [json.loads((folder / f).read_text()) for f in ("summary.json", "timing.json")]


def trials(name, *arguments):
    """The result of each run of a Monte Carlo study."""
    folder = fresh(name)
    chasles("montecarlo", "trajectory", "-o", folder, *arguments)
    return [json.loads(line) for line in (folder / "trials.jsonl").read_text().splitlines()]


def row(*cells):
    return "| " + " | ".join(str(c) for c in cells) + " |\n"


def april():
    for chart in ("standard", "left-se3", "right-se3", "right-sen3"):
        cells = [f"`{chart}`"]
        for cameras in ("stereo", "mono"):
            summary, timing = run(f"april-{chart}-{cameras}", DATA / "euroc/imu_april", "--config", "studies/configs/euroc.yaml",
                                  "--begin", "truth", "--cameras", cameras, "--chart", chart)
            cells += [f"{summary['ate_m']:.4f}", f"{summary['nis_per_dof']:.2f}", f"{timing['filter_ms_per_frame']:.1f}"]
        yield row(*cells)


def flights():
    names = ("MH_01_easy", "MH_03_medium", "V1_01_easy", "V1_02_medium", "V2_01_easy")
    kinds = [(cameras, agreed) for agreed in (False, True) for cameras in CAMERAS]
    sums = dict.fromkeys(kinds, 0.0)
    for name in names:
        cells = [name]
        for cameras, agreed in kinds:
            ate = trials(f"flight-{name}-{cameras}{'-agreed' * agreed}", "--runs", 1,
                         "--path", DATA / f"euroc/imu_gt/{name}_imu.csv.gz", "--real-imu", *["--agreed-truth"] * agreed,
                         "--config", "studies/configs/real-imu.yaml", "--scene-config", "studies/configs/scene-real-imu.yaml",
                         "--scene-set", f"cameras={CAMERAS[cameras]}")[0]["ate_posyaw_m"]
            sums[cameras, agreed] += ate
            cells.append(f"{ate:.3f}")
        yield row(*cells)
    yield row("mean", *(f"{s / len(names):.3f}" for s in sums.values()))


# OpenVINS's figures as the project was given them: metres, degrees, milliseconds.
WALKS = {"tum_corridor1_512_16_okvis": ("tum_corridor1, 299 s", {"mono": (0.053, 0.19, 7.4), "stereo": (0.032, 0.15, 12)}),
         "udel_gore": ("udel_gore, 172 s", {"mono": (0.075, 0.24, 8.6), "stereo": (0.043, 0.21, 15)})}


def walks():
    for name, (title, openvins) in WALKS.items():
        path = DATA / f"trajectories/{name}.txt"
        for cameras, count in CAMERAS.items():
            each = trials(f"walk-{name}-{cameras}", "--runs", 10, "--path", path, "--config", "studies/configs/long-walk.yaml",
                          "--scene-config", "studies/configs/scene-long-walk.yaml", "--scene-set", f"cameras={count}")
            recording = fresh(f"recording-{name}-{cameras}")
            chasles("simulate", "trajectory", "--path", path, "-o", recording, "--config", "studies/configs/scene-long-walk.yaml",
                    "--set", f"cameras={count}")
            # The least of three, because other programs also use the machine.
            ms = min(run("timed", recording, "--config", "studies/configs/long-walk.yaml", "--begin", "truth")[1]["filter_ms_per_frame"]
                     for _ in range(3))
            mean = {key: sum(t[key] for t in each) / len(each) for key in ("ate_posyaw_m", "attitude_posyaw_deg", "nees_pose")}
            yield row(title if count == 1 else "", cameras, f"{mean['ate_posyaw_m']:.3f}", f"{max(t['ate_posyaw_m'] for t in each):.3f}",
                      f"{mean['attitude_posyaw_deg']:.2f}", f"{mean['nees_pose'] / 6:.2f}", f"{ms:.1f}", *openvins[cameras])


TABLES = {"april": april, "flights": flights, "walks": walks}


def main():
    for name in sys.argv[1:] or TABLES:
        if name not in TABLES:
            sys.exit(f"studies/inertial.py: no table is called '{name}'; there are {', '.join(TABLES)}")
        begin, end = f"<!-- {name}:begin -->\n", f"<!-- {name}:end -->"
        head, rest = PAGE.read_text().split(begin)
        old, tail = rest.split(end)
        lines = "".join(TABLES[name]())
        caption = "".join(old.splitlines(keepends=True)[:2])
        print(lines, end="", flush=True)
        PAGE.write_text(head + begin + caption + lines + end + tail)


main()
