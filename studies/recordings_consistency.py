#!/usr/bin/env python3
"""python3 -m studies.recordings_consistency [--quick] [--only PATTERN] [--set KEY=VALUE]... [--recording NAME=PATH]...: are the
covariances consistent with the errors? It runs the filter, window:20 and batch with default settings on all
development recordings, real and rendered, and compares errors and sigmas (docs/recordings-consistency.md).
It writes out/recordings-consistency/table.md, and the figures of each run to out/recordings-consistency/runs.

An interrupted call resumes: a run counts as done if program, recording and options are the same.
A rendered recording is kept until the sources of the renderer change, or for want of room.

--quick has only the filter, the real recordings and the demo's walk. --only takes the recordings
whose names match the regular expression. --recording adds one of your own. --set is passed on to
all runs. --page also fills studies/recordings-consistency.md with the table."""

import argparse
import concurrent.futures
import functools
import hashlib
import json
import math
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import threading

from studies.pages import fill

ROOT = pathlib.Path(__file__).resolve().parent.parent
CHASLES = pathlib.Path(os.environ.get("CHASLES_BINARY", ROOT / "build/release/bin/chasles"))
DATA = pathlib.Path(os.environ.get("CHASLES_DATA", ROOT / "../shared/data"))
ESTIMATORS = ("filter", "window:20", "batch")
WORKERS = 2
SECONDS_EACH = 600  # of a run
SECONDS_TO_END = 3  # of a run, after an interrupt
RENDERED_BYTES = 4e9  # kept in out/recordings-consistency/recordings at most
RENDERING_BYTES = 0.7e9  # of the largest recording
AXES = ("rx", "ry", "rz", "x", "y", "z")
FLIGHTS = ("MH_01_easy", "MH_03_medium", "V1_01_easy", "V1_02_medium", "V2_01_easy")
# The goal's name, its condition, the figures that it applies to.
GOALS = (("NEES/dof of position and attitude in 0.5 to 2", lambda x: 0.5 <= x <= 2, ("position", "attitude")),
         ("within 3 sigma at least 98 % on every axis", lambda x: x >= 0.98, ("least",)),
         ("NIS/dof in 0.8 to 1.25", lambda x: 0.8 <= x <= 1.25, ("nis",)),
         ("|correlation| at most 0.15", lambda x: abs(x) <= 0.15, ("correlation",)))

children = set()
lock = threading.RLock()
stopping = threading.Event()


class Recording:
    """A recording and the variants in which it runs: {name: options}. `render`: the arguments of
    `chasles simulate`, without the folder."""

    def __init__(self, name, path=None, render=None, variants=None):
        self.name, self.path, self.render = name, path, render
        self.variants = variants or {"": []}

    def identity(self):
        """What a result depends on besides program and options."""
        if self.render:
            return [renderer(), *self.render]
        files = sorted(self.path.rglob("*")) if self.path.is_dir() else [self.path]
        return [[str(f.relative_to(self.path)), f.stat().st_size] for f in files if f.is_file()]


def digest(*values):
    return hashlib.sha256(json.dumps(values).encode()).hexdigest()[:16]


@functools.cache
def renderer():
    """The sources that decide the bytes of a rendered recording. A new filter does not change them."""
    folders = [ROOT / "src/chasles" / name for name in ("sim", "numeric", "lie", "imu", "camera")]
    files = sorted(f for folder in folders for f in folder.rglob("*.[ch]pp") if not f.stem.endswith(("test", "testing")))
    return digest(*(hashlib.sha256(f.read_bytes()).hexdigest() for f in files))


def cameras(*names, more=()):
    return {name: ["--cameras", name, *more] for name in names}


def real_recordings():
    euroc = DATA / "euroc"
    forwards_and_backwards = {f"{name}{', backwards' * bool(back)}": [*options, *back]
                              for back in ([], ["--backwards"]) for name, options in cameras("mono", "stereo").items()}
    found = [Recording("MH_01, 17 s", euroc / "MH_01_easy_17s", variants=forwards_and_backwards),
             Recording("MH_03, 27 s", euroc / "MH_03_medium_27s_mono", variants=cameras("mono")),
             Recording("AprilGrid", euroc / "imu_april", variants=cameras("mono", "stereo")),
             Recording("MH_01, tracks", euroc / "imu_gt/MH_01_easy_klt_tracks_cam0.csv.gz"),
             Recording("KITTI 00, 13 s", DATA / "kitti_images/00_first_13s", variants=cameras("stereo"))]
    return [r for r in found if r.path.exists()]


def rendered_recordings():
    walk = ["walk", "--images", "--set"]
    found = [Recording("demo walk, 40 s", render=[*walk, "walk_duration=40"])]
    for name in FLIGHTS:
        path = DATA / f"euroc/imu_gt/{name}_imu.csv.gz"
        for seed in (1, 2, 3) if path.exists() else ():
            found.append(Recording(f"flight {name}, seed {seed}", render=[
                "trajectory", "--path", str(path), "--real-imu", "--agreed-truth", "--images", "--cameras",
                str(DATA / "euroc/MH_01_easy_17s"), "--set", "cameras=1", "--set", "frame_rate=20", "--set", "exposure_drift=0.5",
                "--set", "knot_interval=0.02", "--seed", str(seed)]))
    for seed in range(1, 11):
        found.append(Recording(f"walk, 60 s, seed {seed}", render=[*walk, "walk_duration=60", "--seed", str(seed)]))
    return found


def execute(command, seconds):
    """Exit code (None: out of time), output and last line of errors. Ends with this program."""
    with lock:
        if stopping.is_set():
            raise KeyboardInterrupt
        child = subprocess.Popen([str(a) for a in command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)
        children.add(child)
    try:
        out, err = child.communicate(timeout=seconds)
        code = child.returncode
    except subprocess.TimeoutExpired:
        child.kill()
        child.communicate()
        code, out, err = None, "", ""
    finally:
        with lock:
            children.discard(child)
    if stopping.is_set():
        raise KeyboardInterrupt
    return code, out, ([""] + err.strip().splitlines())[-1]


class Store:
    """Rendered recordings on the disk, and the results of runs."""

    def __init__(self, out):
        self.recordings, self.runs = out / "recordings", out / "runs"
        self.recordings.mkdir(parents=True, exist_ok=True)
        self.runs.mkdir(parents=True, exist_ok=True)
        self.in_use = set()
        self.program = hashlib.sha256(CHASLES.read_bytes()).hexdigest()

    def key(self, recording, options):
        return digest(self.program, recording.identity(), options)

    def result(self, key):
        file = self.runs / f"{key}.json"
        return json.loads(file.read_text()) if file.exists() else None

    def keep(self, key, result):
        part = self.runs / f"{key}.part"
        part.write_text(json.dumps(result, indent=1) + "\n")
        part.rename(self.runs / f"{key}.json")

    def folder(self, recording):
        return self.recordings / digest(recording.identity())

    def make_room(self):
        """Removes recordings that no run uses, the oldest first, until those in use and those that are
        being rendered have room."""
        with lock:
            folders = sorted((f for f in self.recordings.iterdir() if f.is_dir()), key=lambda f: f.stat().st_mtime)
            sizes = {f: sum(x.stat().st_size for x in f.rglob("*") if x.is_file()) for f in folders}
            total = sum(sizes.values())
            for folder in folders:
                if total + WORKERS * RENDERING_BYTES <= RENDERED_BYTES:
                    return
                if folder.name.removesuffix(".part") not in self.in_use:
                    shutil.rmtree(folder)
                    total -= sizes[folder]

    def rendered(self, recording):
        """The folder of a recording, rendered if it is not there, and an error or none."""
        folder = self.folder(recording)
        with lock:
            self.in_use.add(folder.name)
        if folder.exists():
            return folder, None
        self.make_room()
        part = folder.with_suffix(".part")
        shutil.rmtree(part, ignore_errors=True)
        code, _, error = execute([CHASLES, "simulate", *recording.render, "--threads", 1, "--quiet", "-o", part], 3 * SECONDS_EACH)
        if code != 0:
            return None, f"not rendered: {error}" if code is not None else "not rendered: out of time"
        part.rename(folder)
        return folder, None

    def release(self, recording):
        with lock:
            self.in_use.discard(self.folder(recording).name)
        self.make_room()


def estimate(path, options):
    """One run: figures, or the reason why there are none."""
    # The bytes do not depend on the threads, and the other worker has the other core.
    code, out, error = execute([CHASLES, "run", path, *options, "--threads", 1, "--json", "--quiet"], SECONDS_EACH)
    if code is None:
        return {"problem": f"out of time: {SECONDS_EACH} s"}
    if not out.startswith("{"):
        return {"problem": f"exit code {code}: {error}"}
    return {"figures": json.loads(out)}


class Plan:
    """The runs of a call: rows (recording, variant, estimator, options)."""

    def __init__(self, store, recordings, estimators, settings):
        self.store, self.recordings = store, recordings
        more = [text for setting in settings for text in ("--set", setting)]
        self.rows = [(r, variant, estimator, ["--estimator", estimator, *options, *more])
                     for r in recordings for variant, options in r.variants.items() for estimator in estimators]
        self.done = 0

    def result(self, row):
        return self.store.result(self.store.key(row[0], row[3]))

    def missing(self, recording):
        def is_missing(row):
            result = self.result(row)
            return not result or result.get("problem", "").startswith("not rendered")

        return [row for row in self.rows if row[0] is recording and is_missing(row)]

    def work(self, recording):
        missing = self.missing(recording)
        if not missing:
            return
        path, problem = self.store.rendered(recording) if recording.render else (recording.path, None)
        for row in missing:
            result = {"problem": problem} if problem else estimate(path, row[3])
            result |= {"recording": recording.name, "variant": row[1], "estimator": row[2], "options": row[3]}
            self.store.keep(self.store.key(recording, row[3]), result)
            with lock:
                self.done += 1
                print(f"{title(row)}, {row[2]}: {result.get('problem') or 'done'}", flush=True)
        if recording.render:
            self.store.release(recording)

    def run(self):
        with concurrent.futures.ThreadPoolExecutor(WORKERS) as pool:
            for work in [pool.submit(self.work, r) for r in self.recordings]:
                work.result()


def title(row):
    return row[0].name + (f", {row[1]}" if row[1] else "")


def mean_band(dof, count):
    """95 % band of the mean of `count` independent chi-square variables, per degree of freedom, by
    Wilson and Hilferty's approximation: exact to 0.001 for 30 degrees of freedom or more in all."""
    n = dof * count
    return [(1 - 2 / (9 * n) + z * math.sqrt(2 / (9 * n))) ** 3 for z in (-1.959964, 1.959964)]


def figures_of(result):
    """The figures of the table by name; None where a run has none."""
    f = result.get("figures", {})
    shares = {axis: f.get(f"within_3_sigma_{axis}") for axis in AXES}
    known = [s for s in shares.values() if s is not None]

    def per_dof(name, dof):
        return None if f.get(name) is None else f[name] / dof

    return {"ate": f.get("ate_posyaw_m"), "degrees": f.get("attitude_posyaw_deg"), "position": per_dof("nees_position", 3),
            "attitude": per_dof("nees_attitude", 3), "pose": per_dof("nees_pose", 6), "matched": f.get("matched"),
            "nis": f.get("nis_per_dof"), "correlation": f.get("innovation_correlation"), "least": min(known) if known else None,
            **shares, "ms": cost(f), "state": result.get("problem") or f.get("health", "")}


def cost(figures):
    """Processor time of the whole run per frame [ms], which other programs change less than its wall time."""
    return 1e3 * figures["seconds_cpu"] / figures["frames"] if figures.get("frames") else None


HEADER = ("recording", "estimator", "ATE m", "attitude °", "NEES/dof position", "attitude", "pose", "band, 3 dof", "band, 6 dof", "NIS/dof",
          "correlation", "least within 3σ %", *AXES, "CPU ms a frame", "state")


def text(value, digits, factor=1):
    return "-" if value is None else f"{value * factor:.{digits}f}"


def cells(row, result):
    f = figures_of(result)
    bands = ["-".join(f"{x:.2f}" for x in mean_band(dof, f["matched"])) if f["matched"] else "-" for dof in (3, 6)]
    return [title(row), f"`{row[2]}`", text(f["ate"], 3), text(f["degrees"], 2), *(text(f[n], 2) for n in ("position", "attitude", "pose")),
            *bands, text(f["nis"], 2), text(f["correlation"], 2), *(text(f[n], 1, 100) for n in ("least", *AXES)), text(f["ms"], 1),
            f["state"].replace("|", "\\|")]


def table(plan):
    lines = [HEADER, ["---", "---", *["---:"] * (len(HEADER) - 3), "---"]]
    lines += [cells(row, plan.result(row) or {"problem": "not run"}) for row in plan.rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def goals(plan):
    """For each goal the number of runs that meet it, and those that do not."""
    lines = ["| goal | met | not met by |", "|---|---:|---|"]
    for name, holds, of in GOALS:
        met, all_of, missed = 0, 0, []
        for row in plan.rows:
            f = figures_of(plan.result(row) or {})
            values = [f[figure] for figure in of]
            if None in values:
                continue
            all_of += 1
            if all(holds(value) for value in values):
                met += 1
            else:
                missed.append(f"{title(row)} `{row[2]}`")
        lines.append(f"| {name.replace('|', chr(92) + '|')} | {met} of {all_of} | {('; '.join(missed) if met else 'all') if missed else '-'} |")
    return "\n".join(lines)


def commit():
    done = subprocess.run(["git", "-C", ROOT, "describe", "--always", "--dirty"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    return done.stdout.strip() or "no commit"


def stop(*_):
    with lock:
        stopping.set()
        for child in children:
            child.terminate()
            # The program ends a run in order, which may take a batch minutes.
            timer = threading.Timer(SECONDS_TO_END, child.kill)
            timer.daemon = True
            timer.start()


def arguments():
    parser = argparse.ArgumentParser(prog="python3 -m studies.recordings_consistency", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only", default="", metavar="PATTERN")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--recording", action="append", default=[], metavar="NAME=PATH")
    parser.add_argument("--page", action="store_true")
    parser.add_argument("-o", "--output", type=pathlib.Path, default=ROOT / "out/recordings-consistency", metavar="DIR")
    return parser.parse_args()


def recordings_of(o):
    found = real_recordings() + [r for r in rendered_recordings() if not o.quick or r.name.startswith("demo")]
    for own in o.recording:
        name, equals, path = own.partition("=")
        if not equals or not pathlib.Path(path).exists():
            sys.exit(f"studies/recordings_consistency.py: --recording: found '{own}', expected NAME=PATH of a recording")
        found.append(Recording(name, pathlib.Path(path).resolve()))
    try:
        chosen = [r for r in found if re.search(o.only, r.name, re.IGNORECASE)]
    except re.error as error:
        sys.exit(f"studies/recordings_consistency.py: --only: '{o.only}' is no regular expression: {error}")
    if not chosen:
        sys.exit(f"studies/recordings_consistency.py: no recording matches '{o.only}'; there are {', '.join(r.name for r in found)}")
    return chosen


def main():
    o = arguments()
    if not CHASLES.exists():
        sys.exit(f"studies/recordings_consistency.py: there is no {CHASLES}: run `make build`, or set CHASLES_BINARY")
    recordings = recordings_of(o)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, stop)
    plan = Plan(Store(o.output), recordings, ESTIMATORS[:1] if o.quick else ESTIMATORS, o.set)
    try:
        plan.run()
    except KeyboardInterrupt:
        sys.exit("studies/recordings_consistency.py: interrupted; the same command resumes")
    settings = "".join(f", `{s}`" for s in o.set) or ", default settings"
    page = f"Commit {commit()}, program {plan.store.program[:12]}{settings}.\n\n{table(plan)}\n\n{goals(plan)}\n"
    (o.output / "table.md").write_text(page)
    if o.page:
        fill(ROOT / "studies/recordings-consistency.md", "recordings-consistency", page.strip())
    print(f"{page}\n{plan.done} of {len(plan.rows)} runs made now, the others before: {o.output / 'table.md'}")


if __name__ == "__main__":
    main()
