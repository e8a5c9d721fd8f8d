"""Many recordings through the command `chasles batch`, on this machine or on those of an executor."""

from __future__ import annotations

import collections
import contextlib
import functools
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import zipfile
from typing import Any, Callable, Iterable, Iterator, Mapping, Optional, Union

from . import _core
from ._executors import stream
from ._one_line import found
from ._places import Cache, NotThere, Place, is_url, parts_of
from ._progress import bar
from ._run import Run

_DONE = (0, 2, 3, 5)  # exit codes of a batch by its worst verdict, and with --collect

Item = Union[str, "os.PathLike[str]", Mapping[str, Any]]


class Batch:
    """The verdicts of a batch of recordings."""

    def __init__(self, place: Place, records: list[dict[str, Any]], summary: dict[str, Any], attempts: int) -> None:
        self._place = place
        self.folder = place.name
        """Where the batch is: a path or a URL."""
        self.records = records
        """The record of each recording, in their order: name, verdict, reasons, coverage, worst_sigma_m, ..."""
        self.summary = summary
        """The content of summary.json."""
        self.retried = attempts
        """How often a task was given to another worker, because its worker died."""

    def names(self, verdict: str) -> list[str]:
        """The names of the recordings with this verdict: "use", "check" or "no"."""
        if verdict not in ("use", "check", "no"):
            raise _core.UsageError(f"names: found {found(verdict)}, expected 'use', 'check' or 'no'")
        return [record["name"] for record in self.records if record["verdict"] == verdict]

    def run(self, name: str) -> Run:
        """The run of a recording, of a batch on this machine. Raises InputError where it has none."""
        return Run(_core.read_run(os.path.join(self.folder, "runs", name)))

    def page(self) -> str:
        """The HTML page of the batch, as text."""
        return self._place.read("page.html").decode()

    def to_dataframe(self) -> Any:
        """The records as a pandas DataFrame, a row for each recording."""
        from ._optional import optional

        return optional("pandas", "pandas").DataFrame(self.records).set_index("name")

    def __repr__(self) -> str:
        counts = collections.Counter(record["verdict"] for record in self.records)
        return f"<chasles.Batch of {len(self.records)}: " + ", ".join(
            f"{counts[verdict]} {verdict}" for verdict in ("use", "check", "no")) + ">"


def batch(recordings: Iterable[Item], folder: "Union[str, os.PathLike[str]]", *, executor: Any = None,
          jobs: Optional[int] = None, resume: bool = False, estimator: Optional[str] = None, cameras: str = "",
          map: "Union[str, os.PathLike[str], None]" = None, config: "Union[str, os.PathLike[str], None]" = None,
          settings: Optional[Mapping[str, Any]] = None, options: Iterable[str] = (), attempts: int = 3,
          cache: "Union[str, os.PathLike[str], None]" = None, cache_bytes: float = 20e9,
          on_record: Optional[Callable[[dict[str, Any]], None]] = None, progress: Optional[bool] = None) -> Batch:
    """Runs recordings, each in a process of its own, and returns a Batch with a verdict on each: `chasles batch`
    (docs/many.md), to the byte.

    recordings: paths, URLs of fsspec ("s3://bucket/walk.mcap", "zip://walk::data.zip"), or dictionaries with `recording`
    and, where they differ, `name`, `truth`, `cameras`, `start`, `stop` and `set`. folder: of the batch, a path or a URL;
    resume: goes on with what is there. executor: any concurrent.futures.Executor whose workers have this package and, for
    a path, see the same folder: Dask's Client.get_executor(), mpi4py's MPIPoolExecutor, chasles.RayExecutor; None: `jobs`
    processes of this machine (one per core). A task whose worker dies is given to another, `attempts` times in all.
    Without another try left, what stopped it is raised, and resume=True goes on.
    estimator: by default "batch", and with a map "filter". settings: {name: value}; options: further ones of the
    command, as ["--most-sigma", "0.05"].
    cache: a folder on each worker for copies of remote recordings, held to about cache_bytes.
    on_record: called with each record as it comes. progress: a bar, as in `run`.
    Raises UsageError as the command. Ctrl-C ends it, and what is done stays."""
    if isinstance(recordings, (str, bytes)) or isinstance(options, (str, bytes)):
        raise _core.UsageError("batch: recordings and options: found a text, expected a list of texts")
    place = Place(_absolute(folder))
    items = _named([_item(one) for one in recordings])
    arguments = [*_arguments(estimator, cameras, map, config, settings), *_checked([str(one) for one in options])]
    cached = Cache(os.path.abspath(cache or os.path.join(tempfile.gettempdir(), "chasles-recordings")), cache_bytes)
    if place.has("plan.json") and not resume:
        raise _core.UsageError(f"folder: {place.name} has a batch already; expected resume=True to continue it")
    with tempfile.TemporaryDirectory(prefix="chasles-") as scratch:
        collected = _Collected(place, items, arguments, pathlib.Path(scratch))
        missing = collected.begin()
        retried = 0
        with bar(progress, "batch", "recordings") as advance:
            done = len(items) - len(missing)
            for record, attempt in _records(missing, collected, executor, jobs, cached, attempts):
                retried += attempt - 1
                done += 1
                if on_record:
                    on_record(record)
                if advance:
                    advance(done, len(items))
        return Batch(place, *collected.finish(), retried)


def _absolute(path: "Union[str, os.PathLike[str]]") -> str:
    name = os.fspath(path)
    return name if is_url(name) else os.path.abspath(name)


# What the function does itself, or has a parameter for; the rest of the command's options may be given.
_OWN_OPTIONS = ("--manifest", "--map-from", "--map", "--jobs", "--shard", "--resume", "--collect", "--retry", "-o",
                "--output", "--against", "--quiet", "--estimator", "--cameras", "--config")


def _checked(options: list[str]) -> list[str]:
    for number, one in enumerate(options):
        if one.split("=")[0] in _OWN_OPTIONS or (number == 0 and not one.startswith("-")):
            raise _core.UsageError(f"batch: options: found '{one}', expected options of the verdicts and the bounds of "
                                   "`chasles batch`; the others are parameters")
    return options


def _plain(value: Any) -> Any:
    """A value for JSON: of numpy's numbers, Python's."""
    return value.item() if hasattr(value, "item") else value


def _item(one: Item) -> dict[str, Any]:
    if isinstance(one, Mapping):
        item = {name: _plain(value) for name, value in one.items() if value is not None}
        if "recording" not in item:
            raise _core.UsageError(f"batch: found {found(one)}, expected a dictionary with 'recording'")
    else:
        item = {"recording": one}
    for name in ("recording", "truth"):
        if name in item:
            item[name] = _absolute(item[name])
    if is_url(item.get("truth", "")):
        raise _core.UsageError(f"batch: truth: found {item['truth']}, expected a path")
    if is_url(item["recording"]):
        item.setdefault("source", item["recording"])
    if "set" in item:
        item["set"] = dict(_flat(item["set"]))
    return item


def _named(items: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Remote recordings get names as the command gives them to local ones: more parts where they are alike."""
    remote = [item for item in items if is_url(item["recording"]) and "name" not in item]
    counts = {id(item): 1 for item in remote}

    def name(item: dict[str, Any]) -> str:
        return "_".join(parts_of(item["recording"])[:counts[id(item)]][::-1])

    for _ in range(10):
        users = collections.Counter(name(item) for item in remote)
        for item in remote:
            counts[id(item)] += users[name(item)] > 1
    for item in remote:
        item["name"] = name(item)
    return items


def _flat(settings: Mapping[str, Any], prefix: str = "") -> "Iterator[tuple[str, str]]":
    """Settings by their names on the command line: {"start": {"heading": 0}} is start.heading."""
    for name, value in settings.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            value = _plain(value)
            yield prefix + name, str(value).lower() if isinstance(value, bool) else str(value)


def _arguments(estimator: Optional[str], cameras: str, map: Any, config: Any, settings: Optional[Mapping[str, Any]]) -> list[str]:
    arguments = ["--estimator", estimator] if estimator else []
    if cameras:
        arguments += ["--cameras", cameras]
    if map is not None:
        arguments += ["--map", os.path.abspath(os.fspath(map))]
    if config is not None:
        arguments += ["--config", os.path.abspath(os.fspath(config))]
    for name, text in _flat(settings or {}):
        arguments += ["--set", f"{name}={text}"]
    return arguments


class _Died(Exception):
    """The command was killed, as the system does where memory runs out: it may be tried again."""


# The same package, wherever this interpreter has found it. The command ends with whoever started it: Linux alone can do
# that, and only the thread that started it counts.
_START = ("import ctypes, signal, sys; sys.path.insert(0, sys.argv.pop(1)); "
          "ctypes.CDLL(None).prctl(1, signal.SIGKILL); import chasles; chasles.main()")


@contextlib.contextmanager
def _command(*arguments: str) -> "Iterator[tuple[subprocess.Popen[str], Any]]":
    """The command `chasles batch`, which is killed at the end of the block if it still runs, and the file of its stderr:
    a pipe that nobody reads would stop it."""
    package = str(pathlib.Path(__file__).resolve().parent.parent)
    with tempfile.TemporaryFile("w+") as errors:
        process = subprocess.Popen([sys.executable, "-c", _START, package, "batch", *arguments], stdin=subprocess.DEVNULL,
                                   stdout=subprocess.PIPE, stderr=errors, text=True)
        try:
            yield process, errors
        finally:
            if process.poll() is None:
                process.kill()  # and its processes with it
            process.wait()


def _finish(process: "subprocess.Popen[str]", errors: Any) -> None:
    """Raises what the command said, if it ended with an error."""
    code = process.wait()
    errors.seek(0)
    text = errors.read()
    if code in _DONE and "chasles: error:" not in text:
        return
    if code < 0:
        raise _Died(f"the command died by signal {-code}")
    message = text.strip().rsplit("chasles: error: ", 1)[-1] or f"the command ended with {code}"
    raise (_core.UsageError if code == 1 else _core.InputError)(message)


def _run_command(*arguments: str) -> str:
    with _command(*arguments) as (process, errors):
        assert process.stdout is not None
        out = process.stdout.read()
        _finish(process, errors)
    return out


def _manifest(items: Iterable[Mapping[str, Any]], file: pathlib.Path) -> str:
    file.write_text("".join(json.dumps(item) + "\n" for item in items))
    return str(file)


class _Collected:
    """A batch whose recordings run elsewhere: the command makes its plan and, at the end, its page."""

    def __init__(self, place: Place, items: list[dict[str, Any]], arguments: list[str], scratch: pathlib.Path) -> None:
        self.place = place
        self.arguments = arguments
        # The command works in a folder of this machine.
        self.local = scratch / "batch" if place.is_remote else pathlib.Path(place.name)
        self.items = items
        self._list = scratch / "list"

    def manifest(self) -> str:
        return _manifest(self.items, self._list)

    def _collect(self) -> list[dict[str, Any]]:
        """The record of each recording; the verdict None where it has none."""
        out = _run_command("--manifest", self.manifest(), *self.arguments, "--collect", "--resume", "--quiet", "-o",
                           str(self.local))
        return [json.loads(line) for line in out.splitlines()]

    def begin(self) -> list[dict[str, Any]]:
        """Makes the plan, or checks that it is the same. The recordings that have no record yet, with their names."""
        if self.place.is_remote:
            self.local.mkdir()
            if self.place.has("plan.json"):
                (self.local / "plan.json").write_bytes(self.place.read("plan.json"))
            self._fetch_records()
        records = self._collect()
        if self.place.is_remote:
            self.place.write("plan.json", (self.local / "plan.json").read_bytes())
        for item, record in zip(self.items, records):
            item["name"] = record["name"]
        return [item for item, record in zip(self.items, records) if record["verdict"] is None]

    def _fetch_records(self) -> None:
        (self.local / "verdicts").mkdir(exist_ok=True)
        for name in self.place.names("verdicts"):
            (self.local / "verdicts" / name).write_bytes(self.place.read(f"verdicts/{name}"))

    def finish(self) -> tuple[list[dict[str, Any]], dict[str, Any]]:
        if self.place.is_remote:
            self._fetch_records()
            self._fetch_pictures()
        records = self._collect()
        self.place.remove_parts()
        if self.place.is_remote:
            for name in ("verdicts.jsonl", "page.html", "summary.json"):
                self.place.write(name, (self.local / name).read_bytes())
        return records, json.loads((self.local / "summary.json").read_text())

    def _fetch_pictures(self) -> None:
        for item in self.items:
            run = f"runs/{item['name']}"
            for name in self.place.names(f"{run}/images"):
                file = self.local / run / "images" / name
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_bytes(self.place.read(f"{run}/images/{name}"))


def _records(missing: list[dict[str, Any]], collected: _Collected, executor: Any, jobs: Optional[int], cache: Cache,
             attempts: int) -> "Iterable[tuple[dict[str, Any], int]]":
    if not missing:
        return
    is_local = not collected.place.is_remote and not any(is_url(item["recording"]) for item in missing)
    if executor is None and is_local:
        yield from _by_the_command(collected, jobs)
        return
    assess = functools.partial(_assess, arguments=collected.arguments, folder=collected.place.name,
                              cache=(str(cache.folder), cache.most_bytes))
    if executor is not None:
        for one in stream(executor, assess, missing, attempts=attempts):
            yield one.value, one.attempts
        return
    import concurrent.futures

    # Threads: each waits for the process of its recording.
    with concurrent.futures.ThreadPoolExecutor(jobs or os.cpu_count()) as threads:
        for one in stream(threads, assess, missing, attempts=attempts):
            yield one.value, one.attempts


def _by_the_command(collected: _Collected, jobs: Optional[int]) -> "Iterable[tuple[dict[str, Any], int]]":
    at_a_time = ["--jobs", str(jobs)] if jobs is not None else []
    with _command("--manifest", collected.manifest(), *collected.arguments, "--resume", "--quiet", *at_a_time, "-o",
                  collected.place.name) as (process, errors):
        assert process.stdout is not None
        for line in process.stdout:
            record = json.loads(line)
            yield record, record["attempts"]
        _finish(process, errors)


def _assess(item: dict[str, Any], arguments: list[str], folder: str, cache: tuple[str, float]) -> dict[str, Any]:
    """The task of a worker: runs one recording, and delivers its run and then its record."""
    place, name = Place(folder), item["name"]
    if place.has(f"verdicts/{name}.json"):  # of a worker that died when all was done
        record: dict[str, Any] = json.loads(place.read(f"verdicts/{name}.json"))
        record.pop("sketch", None)
        return record
    with tempfile.TemporaryDirectory(prefix="chasles-") as scratch:
        work = pathlib.Path(scratch)
        with _local(item["recording"], cache) as path:
            record = _assess_local({**item, "recording": path}, arguments, work)
        if (work / "batch/runs" / name).exists():
            place.write_folder(work / "batch/runs" / name, f"runs/{name}")
        place.write(f"timing/{name}.json", (work / f"batch/timing/{name}.json").read_bytes())
        place.write(f"verdicts/{name}.json", (work / f"batch/verdicts/{name}.json").read_bytes())
        return record


@contextlib.contextmanager
def _local(recording: str, cache: tuple[str, float]) -> "Iterator[str]":
    """The path of a recording on this machine. One that is not there has a path where nothing is: that is its verdict."""
    with contextlib.ExitStack() as stack:
        path = recording
        if is_url(recording):
            # ValueError: also of a file system that is not known.
            with contextlib.suppress(NotThere, ValueError, zipfile.BadZipFile):
                path = stack.enter_context(Cache(*cache).local(recording))
        yield path


def _assess_local(item: Mapping[str, Any], arguments: list[str], work: pathlib.Path) -> dict[str, Any]:
    out = _run_command("--manifest", _manifest([item], work / "list"), *arguments, "--jobs", "1", "--quiet", "-o",
                       str(work / "batch"))
    record: dict[str, Any] = json.loads(out)
    return record
