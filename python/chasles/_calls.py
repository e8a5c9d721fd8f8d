"""The functions of the package that take settings as arguments. Their types, with all settings by name, are in
_calls.pyi, which tools/python-types writes."""

import functools
import json
import os
import pathlib
import tempfile
from collections.abc import Mapping

from . import _core
from ._executors import stream
from ._laboratory import laboratory
from ._one_line import found
from ._progress import bar
from ._run import Run
from .lab import Comparison, Study


def simulate(scene="hallway", *, run=0, images=False, progress=None, **settings):
    """A simulated recording: tracks, or rendered images with images=True. Equal scenes with another run have other
    noise. Settings by name, as settings("scene") and, for streets, settings("street") list them. progress: a bar (tqdm),
    True or False; None draws one on a terminal and in a notebook where tqdm is installed. Ctrl-C ends it."""
    with bar(progress, f"simulate {scene}", "parts") as advance:
        return laboratory().simulate(scene, run=run, images=images, progress=advance, **settings)


def run(recording, *, estimator="filter", threads=3, begin="auto", as_recorded=False, map=None, save_map=None,
        keep_images=None, mode=None, config=None, progress=None, **settings):
    """Runs an estimator over a recording (Recording, or a path) as `chasles run` does, to the bit, and returns a Run.

    estimator: "filter", "window:N" or "batch". map, save_map: files of maps (docs/recognition.md). begin: "auto", or
    "truth". as_recorded: clock, axes and shutter as stated (docs/cameras.md). progress: a bar (tqdm), True or False; None
    draws one on a terminal and in a notebook where tqdm is installed. Settings by name, as settings() lists them; those
    with a prefix as a dictionary: start={"heading": 0}.
    Raises UsageError for a setting that does not exist, with the nearest one, or that cannot be used;
    NotInitialisedError where the run never started, with the conditions that are not met. Where the map cannot be
    saved, the Run is the attribute `run` of the error. Ctrl-C ends it with KeyboardInterrupt. Other threads run
    meanwhile."""
    path = ""
    if not isinstance(recording, _core.Recording):
        path = os.fspath(recording)
        recording = _core.read(path)
    given = {"map": map, "save_map": save_map, "keep_images": keep_images, "mode": mode, "config": config}
    given = {name: value for name, value in given.items() if value is not None}
    for name in ("map", "save_map", "config"):
        if name in given:
            given[name] = os.fspath(given[name])
    with bar(progress, "run", "frames", "batch" if estimator == "batch" else "last steps") as advance:
        core = _core.run(recording, path, advance, estimator=estimator, threads=threads, begin=begin, as_recorded=as_recorded,
                         **given, **settings)
    finished = Run(core)
    try:
        finished._core._check_map()
    except _core.Error as error:
        error.run = finished
        raise
    return finished


def _check_named(function, argument, named):
    """Raises UsageError where these are no settings by name."""
    expected = f'expected {{name: {{setting: value}}}}, such as {{"ours": {{}}, "window": {{"estimator": "window:20"}}}}'
    if not isinstance(named, Mapping) or not named:
        raise _core.UsageError(f"{function}: {argument}: found {'none' if named == {} else found(named)}; {expected}")
    for name, settings in named.items():
        if not isinstance(settings, Mapping):
            raise _core.UsageError(f"{function}: {argument}: {found(name)}: found {found(settings)}; {expected}")


def compare(recording, estimators, **common):
    """Runs several estimators over a recording (Recording, or a path) and returns a Comparison.

    estimators: {name: {argument of chasles.run: value}}; common: arguments of all of them."""
    _check_named("compare", "estimators", estimators)
    if not isinstance(recording, _core.Recording):
        recording = _core.read(os.fspath(recording))
    return Comparison({name: run(recording, **{**common, **arguments}) for name, arguments in estimators.items()})


def _part(numbers, *, scene, filters, settings):
    """The task of a worker: some runs of a study. Its files, by name."""
    first, runs = numbers
    with tempfile.TemporaryDirectory(prefix="chasles-") as scratch:
        folder = pathlib.Path(scratch, "part")
        laboratory().monte_carlo(scene, filters, runs, first, 1, str(folder), settings, None)
        return {file.name: file.read_bytes() for file in folder.iterdir() if file.is_file()}


_MOST_PARTS = 512  # of a study on an executor


def _study_in_parts(scene, filters, runs, first, folder, settings, executor, attempts, advance):
    """The study of parts that run on an executor; they are on disk, and not in memory."""
    if os.path.exists(os.path.join(folder, "plan.json")):
        raise _core.UsageError(f"{folder} holds a study; expected another folder")
    size = -(-runs // _MOST_PARTS)
    numbers = [(first + at, min(size, runs - at)) for at in range(0, runs, size)]
    task = functools.partial(_part, scene=scene, filters=filters, settings=settings)
    done = 0
    with tempfile.TemporaryDirectory(prefix="chasles-") as scratch:
        folders = {part: pathlib.Path(scratch, str(part[0])) for part in numbers}
        for one in stream(executor, task, numbers, attempts=attempts):
            folders[one.item].mkdir()
            for name, data in one.value.items():
                (folders[one.item] / name).write_bytes(data)
            done += one.item[1]
            if advance:
                advance(done, runs)
        return laboratory().merge_studies([str(folders[part]) for part in numbers], folder)


def monte_carlo(scene, filters, *, runs, first=0, workers=1, folder=None, executor=None, attempts=3, progress=None,
                **settings):
    """Executes `runs` runs of a scene through all filters, and returns a Study. In each run all filters have the same
    landmarks, noise and initial errors.

    filters: {name: {setting: value}}, with "estimator" among the settings. settings: those of the scene. folder: where
    the study is kept, as `chasles montecarlo -o` does; a temporary one if none is given. workers: processes; 1 where a
    chart or depth rule is written in Python. executor: any concurrent.futures.Executor instead of them, as for `batch`;
    the bytes are the same. progress: a bar, as in `run`. Ctrl-C ends it with KeyboardInterrupt."""
    _check_named("monte_carlo", "filters", filters)
    temporary = None
    if folder is None:
        temporary = tempfile.TemporaryDirectory(prefix="chasles-")
        folder = os.path.join(temporary.name, "study")
    settings_of = {name: dict(one) for name, one in filters.items()}
    with bar(progress, "monte_carlo", "runs") as advance:
        if executor is not None and runs > 0:
            summary = _study_in_parts(scene, settings_of, runs, first, os.fspath(folder), settings, executor, attempts,
                                      advance)
        else:
            summary = laboratory().monte_carlo(scene, settings_of, runs, first, workers, os.fspath(folder), settings,
                                               advance)
    study = Study(os.fspath(folder), json.loads(summary))
    study._temporary = temporary
    return study
