"""Recordings of studies/recordings_consistency.py, their draws, and the runs with all figures of a path. Results and
rendered recordings are kept on the disk."""

import functools
import hashlib
import json
import pathlib
import shutil
import subprocess
import tempfile
import threading
import typing

from studies.program import CHASLES, DATA, EUROC, ROOT, Arguments, Json, read_json, sets

# Of tools/studies-venv. Without it there are no scores.
SCORER = ROOT / "build/studies-venv/bin/python"
SECONDS_EACH = 600  # of a run
SECONDS_TO_END = 3  # of a run, after an interrupt
RENDERED_BYTES = 4e9  # kept in out/recordings-consistency/recordings at most
RENDERING_BYTES = 0.7e9  # of the largest recording
PART = "0.8"  # of the tracks, in a draw
FLIGHTS = ("MH_01_easy", "MH_03_medium", "V1_01_easy", "V1_02_medium", "V2_01_easy")

children: set["subprocess.Popen[str]"] = set()
lock = threading.RLock()
stopping = threading.Event()


class Recording:
    """A recording and the variants in which it runs: {name: options}. `render`: the arguments of `chasles simulate`,
    without the folder. A draw is a seed of the scene (`seeded`), or else a random part of the tracks."""

    def __init__(self, name: str, path: pathlib.Path = ROOT, render: list[str] | None = None, seeded: bool = False,
                 variants: dict[str, list[str]] | None = None) -> None:
        self.name, self.path, self.render, self.seeded = name, path, render, seeded
        self.variants = variants or {"": []}

    def rendering(self, draw: int) -> list[str] | None:
        """The arguments of `chasles simulate`; None for a recording of its own."""
        return [*self.render, "--seed", str(draw)] if self.render and self.seeded else self.render

    def options(self, draw: int) -> list[str]:
        return [] if self.seeded else ["--tracks", PART, "--tracks-seed", str(draw)]

    def identity(self, draw: int) -> list[typing.Any]:
        """What a result depends on besides program and options."""
        render = self.rendering(draw)
        if render:
            return [renderer(), *render]
        files = sorted(self.path.rglob("*")) if self.path.is_dir() else [self.path]
        return [[str(f.relative_to(self.path)), f.stat().st_size] for f in files if f.is_file()]


def digest(*values: typing.Any) -> str:
    return hashlib.sha256(json.dumps(values).encode()).hexdigest()[:16]


@functools.cache
def renderer() -> str:
    """The sources that decide the bytes of a rendered recording. A new filter does not change them."""
    folders = [ROOT / "src/chasles" / name for name in ("sim", "numeric", "lie", "imu", "camera")]
    files = sorted(f for folder in folders for f in folder.rglob("*.[ch]pp")
                   if not f.stem.endswith(("test", "testing")))
    return digest(*(hashlib.sha256(f.read_bytes()).hexdigest() for f in files))


def cameras(*names: str) -> dict[str, list[str]]:
    return {name: ["--cameras", name] for name in names}


def real_recordings() -> list[Recording]:
    ways: tuple[list[str], ...] = ([], ["--backwards"])
    forwards_and_backwards = {f"{name}{', backwards' * bool(back)}": [*options, *back]
                              for back in ways for name, options in cameras("mono", "stereo").items()}
    found = [Recording("MH_01, 17 s", EUROC / "MH_01_easy_17s", variants=forwards_and_backwards),
             Recording("MH_03, 27 s", EUROC / "MH_03_medium_27s_mono", variants=cameras("mono")),
             Recording("AprilGrid", EUROC / "imu_april", variants=cameras("mono", "stereo")),
             Recording("MH_01, tracks", EUROC / "imu_gt/MH_01_easy_klt_tracks_cam0.csv.gz"),
             Recording("KITTI 00, 13 s", DATA / "kitti_images/00_first_13s", variants=cameras("stereo"))]
    return [r for r in found if r.path.exists()]


def rendered_recordings() -> list[Recording]:
    walk = ["walk", "--images", "--set"]
    found = [Recording("demo walk, 40 s", render=[*walk, "walk_duration=40"])]
    for name in FLIGHTS:
        path = EUROC / f"imu_gt/{name}_imu.csv.gz"
        if path.exists():
            settings = sets("cameras=1", "frame_rate=20", "exposure_drift=0.5", "knot_interval=0.02")
            found.append(Recording(f"flight {name}", seeded=True, render=[
                "trajectory", "--path", str(path), "--real-imu", "--agreed-truth", "--images", "--cameras",
                str(EUROC / "MH_01_easy_17s"), *settings]))
    return [*found, Recording("walk, 60 s", seeded=True, render=[*walk, "walk_duration=60"])]


def execute(command: Arguments, seconds: float = SECONDS_EACH) -> tuple[int | None, str, str]:
    """Exit code (None: out of time), output and last line of errors. Ends with this program."""
    with lock:
        if stopping.is_set():
            raise KeyboardInterrupt
        child = subprocess.Popen([str(a) for a in command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                 cwd=ROOT, start_new_session=True)
        children.add(child)
    try:
        out, err = child.communicate(timeout=seconds)
        code: int | None = child.returncode
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


def stop(*_: typing.Any) -> None:
    with lock:
        stopping.set()
        for child in children:
            child.terminate()
            # The program ends a run in order, which may take a batch minutes.
            timer = threading.Timer(SECONDS_TO_END, child.kill)
            timer.daemon = True
            timer.start()


@functools.cache
def knows_truth_errors() -> bool:
    return "--truth-errors" in execute([CHASLES, "evaluate", "--help"])[1]


def path_figures(folder: pathlib.Path, figures: Json, smoothed: bool) -> Json:
    """The figures of one path of a run folder, with its scores and its NEES with the truth's errors known. What does
    not work is reported as `note`."""
    path = ["--smoothed"] if smoothed else []
    square, truth = folder / "scored.square", folder / "scored.tum"
    found = dict(figures)
    steps: list[tuple[str, Arguments]] = []
    if SCORER.exists():
        steps += [("", [CHASLES, "export", folder, *path, "-o", square, "--truth", truth, "--quiet"]),
                  ("scores", [SCORER, "-m", "studies.scores", square, truth])]
    if knows_truth_errors():
        steps.append(("known", [CHASLES, "evaluate", folder, *path, "--truth-errors", "auto", "--json"]))
    for name, command in steps:
        code, out, error = execute(command)
        if code != 0:
            found["note"] = f"{name or 'export'}: {error}"
        elif name:
            found[name] = json.loads(out)
    return found


def estimate(path: pathlib.Path, options: list[str]) -> Json:
    """One run: figures of each path that it has, or the reason why there are none."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name) / "run"
        # The bytes do not depend on the threads, and the other worker has the other core.
        code, out, error = execute(
            [CHASLES, "run", path, *options, "--threads", 1, "--json", "--quiet", "-o", folder])
        if code is None:
            return {"problem": f"out of time: {SECONDS_EACH} s"}
        if not out.startswith("{"):
            return {"problem": f"exit code {code}: {error}"}
        summary = json.loads(out)
        found: Json = {"path": path_figures(folder, summary, smoothed=False)}
        if "smoothed" in summary:
            found["smoothed"] = path_figures(folder, summary["smoothed"], smoothed=True)
        return found


class Store:
    """Rendered recordings on the disk, and the results of runs."""

    def __init__(self, out: pathlib.Path, workers: int) -> None:
        self.recordings, self.runs, self.workers = out / "recordings", out / "runs", workers
        self.recordings.mkdir(parents=True, exist_ok=True)
        self.runs.mkdir(parents=True, exist_ok=True)
        self.in_use: set[str] = set()
        self.program = hashlib.sha256(CHASLES.read_bytes()).hexdigest()

    def key(self, recording: Recording, draw: int, options: list[str]) -> str:
        return digest(self.program, SCORER.exists(), recording.identity(draw), options)

    def result(self, key: str) -> Json | None:
        file = self.runs / f"{key}.json"
        return read_json(file) if file.exists() else None

    def keep(self, key: str, result: Json) -> None:
        part = self.runs / f"{key}.part"
        part.write_text(json.dumps(result, indent=1) + "\n")
        part.rename(self.runs / f"{key}.json")

    def folder(self, recording: Recording, draw: int) -> pathlib.Path:
        return self.recordings / digest(recording.identity(draw))

    def make_room(self) -> None:
        """Removes recordings that no run uses, the oldest first, until those in use and those that are
        being rendered have room."""
        with lock:
            folders = sorted((f for f in self.recordings.iterdir() if f.is_dir()), key=lambda f: f.stat().st_mtime)
            sizes = {f: sum(x.stat().st_size for x in f.rglob("*") if x.is_file()) for f in folders}
            total = sum(sizes.values())
            for folder in folders:
                if total + self.workers * RENDERING_BYTES <= RENDERED_BYTES:
                    return
                if folder.name.removesuffix(".part") not in self.in_use:
                    shutil.rmtree(folder)
                    total -= sizes[folder]

    def rendered(self, recording: Recording, draw: int, render: list[str]) -> tuple[pathlib.Path, str | None]:
        """The folder of a recording, rendered if it is not there, and an error or none."""
        folder = self.folder(recording, draw)
        with lock:
            self.in_use.add(folder.name)
        if folder.exists():
            return folder, None
        self.make_room()
        part = folder.with_suffix(".part")
        shutil.rmtree(part, ignore_errors=True)
        code, _, error = execute([CHASLES, "simulate", *render, "--threads", 1, "--quiet", "-o", part],
                                 3 * SECONDS_EACH)
        if code != 0:
            return part, f"not rendered: {error}" if code is not None else "not rendered: out of time"
        part.rename(folder)
        return folder, None

    def release(self, recording: Recording, draw: int) -> None:
        with lock:
            self.in_use.discard(self.folder(recording, draw).name)
        self.make_room()
