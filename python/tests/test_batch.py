"""Many recordings: the verdicts of the command, through any executor, whatever dies."""

import concurrent.futures
import json
import os
import pathlib
import re
import signal
import threading
import time

import chasles
import pytest
from chasles._executors import stream
from chasles._places import Cache, NotThere, Place

OPTIONS = ["--no-check", "--most-sigma", "1"]


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recordings")
    for name in "abcd":
        code = chasles.command("simulate", "turntable", "--set", "revolutions=0.15", "--quiet", "--run", ord(name), "-o",
                               folder / name)
        assert code == 0
    return [folder / name for name in "abcd"]


def files(folder):
    """The bytes of all that must be alike in equal batches."""
    root = pathlib.Path(folder)
    return {str(file.relative_to(root)): file.read_bytes() for file in sorted(root.rglob("*"))
            if file.is_file() and "timing" not in str(file.relative_to(root))}


def test_verdicts_of_this_machine(recordings, tmp_path):
    seen = []
    batch = chasles.batch([*recordings, tmp_path / "none"], tmp_path / "batch", options=OPTIONS, on_record=seen.append)
    assert batch.names("use") == ["a", "b", "c", "d"] and batch.names("no") == ["none"]
    assert sorted(record["name"] for record in seen) == ["a", "b", "c", "d", "none"]
    assert [record["name"] for record in batch.records] == ["a", "b", "c", "d", "none"]
    assert batch.records[4]["reasons"][0]["reason"] == "unreadable"
    assert batch.summary["verdicts"] == {"use": 4, "check": 0, "no": 1}
    assert batch.run("a").summary["health"] == "ok"
    assert '"name":"none"' in batch.page() and "4 use" in repr(batch)


def test_an_executor_gives_the_same_bytes(recordings, tmp_path):
    here = chasles.batch(recordings, tmp_path / "here", options=OPTIONS, settings={"chart": "standard"})
    with concurrent.futures.ProcessPoolExecutor(2) as executor:
        there = chasles.batch(recordings, tmp_path / "there", options=OPTIONS, settings={"chart": "standard"},
                              executor=executor)
    assert files(here.folder) == files(there.folder) and len(files(here.folder)) > 20
    assert there.run("b").summary["chart"] == "standard"


def test_a_batch_goes_on_where_it_stopped(recordings, tmp_path):
    whole = chasles.batch(recordings, tmp_path / "whole", options=OPTIONS)

    def stop(record):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        chasles.batch(recordings, tmp_path / "part", options=OPTIONS, jobs=1, on_record=stop)
    done = len(list((tmp_path / "part/verdicts").iterdir()))
    assert 1 <= done < 4
    with pytest.raises(chasles.UsageError, match="resume=True"):
        chasles.batch(recordings, tmp_path / "part", options=OPTIONS)
    with pytest.raises(chasles.UsageError, match="another plan"):
        chasles.batch(recordings, tmp_path / "part", options=OPTIONS, resume=True, estimator="window:20")
    rest = []
    with concurrent.futures.ThreadPoolExecutor(2) as executor:
        chasles.batch(recordings, tmp_path / "part", options=OPTIONS, resume=True, executor=executor,
                      on_record=rest.append)
    assert len(rest) <= 4 - done
    assert files(tmp_path / "part") == files(whole.folder)


def test_errors_of_the_command_are_raised(recordings, tmp_path):
    with pytest.raises(chasles.UsageError, match="unknown key 'gaet'"):
        chasles.batch(recordings, tmp_path / "x", settings={"gaet": 1})
    with pytest.raises(chasles.UsageError, match="found twice"):
        chasles.batch([recordings[0], recordings[0]], tmp_path / "y", options=OPTIONS)
    with pytest.raises(chasles.UsageError, match="with 'recording'"):
        chasles.batch([{"name": "a"}], tmp_path / "z")


class Dies(Exception):
    """As of an executor whose worker dies."""


def test_what_a_dead_worker_had_is_done_by_another():
    failures = {3: 2, 5: 1}
    lock = threading.Lock()

    def work(item):
        with lock:
            failures[item] = failures.get(item, 0) - 1
            if failures[item] >= 0:
                raise Dies
        return item * item

    with concurrent.futures.ThreadPoolExecutor(3) as executor:
        results = list(stream(executor, work, range(8), window=3))
        assert sorted((one.item, one.value) for one in results) == [(i, i * i) for i in range(8)]
        assert {one.item: one.attempts for one in results if one.attempts > 1} == {3: 3, 5: 2}
        failures.clear()
        failures[3] = 9
        with pytest.raises(Dies):
            list(stream(executor, work, range(8)))


def test_only_a_window_of_tasks_waits():
    taken = []

    def items():
        for i in range(100):
            taken.append(i)
            yield i

    with concurrent.futures.ThreadPoolExecutor(2) as executor:
        for count, _ in enumerate(stream(executor, lambda i: i, items(), window=5), 1):
            assert len(taken) <= count + 5
    assert len(taken) == 100


def die(item):
    if item == 2:
        os.kill(os.getpid(), signal.SIGKILL)
    return item


def test_a_broken_executor_is_said():
    with concurrent.futures.ProcessPoolExecutor(1) as executor:
        with pytest.raises(chasles.InputError, match="broken.*resume=True"):
            list(stream(executor, die, range(4)))


def test_a_place_has_whole_files(tmp_path):
    place = Place(str(tmp_path))
    source = tmp_path / "source"
    source.mkdir()
    (source / "one").write_bytes(b"1")
    place.write_folder(source, "runs/a")
    (source / "two").write_bytes(b"2")
    (source / "one").unlink()
    place.write_folder(source, "runs/a")
    assert place.names("runs") == ["a"] and place.names("runs/a") == ["two"] and place.names("none") == []
    place.write("x/y", b"3")
    assert place.read("x/y") == b"3" and place.names("x") == ["y"] and place.has("x/y")


def test_a_cache_holds_its_bound(tmp_path):
    pytest.importorskip("fsspec")
    for name in "abc":
        (tmp_path / name).write_bytes(b"x" * 1000)
    cache = Cache(str(tmp_path / "cache"), 1500)
    urls = [f"file://{tmp_path / name}" for name in "abc"]

    def kept():
        return sum(f.stat().st_size for f in (tmp_path / "cache").rglob("*") if f.is_file())

    for url in urls:
        with cache.local(url) as copy:
            assert pathlib.Path(copy).read_bytes() == b"x" * 1000
        time.sleep(0.02)
    with cache.local(urls[2]):  # in use: it stays
        with cache.local(urls[0]):
            pass
        with cache.local(urls[1]):
            pass
        assert kept() <= 3000
    (tmp_path / "c").write_bytes(b"another")
    with cache.local(urls[2]) as copy:
        assert pathlib.Path(copy).read_bytes() == b"another", "the original has changed"
    with pytest.raises(NotThere):
        with cache.local(f"file://{tmp_path}/none"):
            pass


def test_many_workers_share_a_cache_that_holds_nothing(tmp_path):
    pytest.importorskip("fsspec")
    for i in range(12):
        (tmp_path / f"r{i}").write_bytes(b"%d" % i)
    cache = Cache(str(tmp_path / "cache"), 0)

    def read(i):
        with cache.local(f"file://{tmp_path}/r{i % 12}") as copy:
            time.sleep(0.005)
            return pathlib.Path(copy).read_bytes()

    with concurrent.futures.ThreadPoolExecutor(6) as threads:
        assert list(threads.map(read, range(60))) == [b"%d" % (i % 12) for i in range(60)]


def test_one_that_cannot_be_fetched_stops_no_other(recordings, tmp_path):
    pytest.importorskip("fsspec")
    (tmp_path / "bad.zip").write_bytes(b"no archive")
    urls = [f"file://{recordings[0]}", f"zip://walk::file://{tmp_path}/bad.zip", "nonsense://x/y", f"file://{tmp_path}/none"]
    batch = chasles.batch(urls, tmp_path / "out", options=OPTIONS, cache=tmp_path / "cache")
    assert batch.names("use") == ["a"] and len(batch.names("no")) == 3
    assert all(record["reasons"][0]["reason"] == "unreadable" for record in batch.records[1:])
    again = chasles.batch(urls, tmp_path / "again", options=OPTIONS, cache=tmp_path / "other")
    assert files(batch.folder) == files(again.folder), "no path of this machine is in a record"


def test_names_of_urls(recordings, tmp_path):
    pytest.importorskip("fsspec")
    for episode in ("ep1", "ep2"):
        (tmp_path / episode).mkdir()
        (tmp_path / episode / "walk").symlink_to(recordings[0])
    batch = chasles.batch([f"file://{tmp_path}/{episode}/walk/" for episode in ("ep1", "ep2")], tmp_path / "out",
                          options=OPTIONS, cache=tmp_path / "cache")
    assert [record["name"] for record in batch.records] == ["ep1_walk", "ep2_walk"]


def test_relative_folders_and_other_spellings(recordings, tmp_path, monkeypatch):
    monkeypatch.chdir(recordings[0].parent)
    code = chasles.command("batch", "a", "b", "-o", tmp_path / "out", *OPTIONS)
    assert code == 0
    monkeypatch.chdir(tmp_path)
    rest = []
    batch = chasles.batch(recordings[:3], "out", options=OPTIONS, resume=True, on_record=rest.append)
    assert [record["name"] for record in rest] == ["c"] and batch.folder == str(tmp_path / "out")
    with pytest.raises(chasles.UsageError, match="was made with the options"):
        chasles.batch([{"recording": recordings[0], "stop": 2.0}], "out", options=OPTIONS, resume=True)


def test_a_command_that_is_killed_runs_again(recordings, tmp_path):
    import chasles._batch as module

    original, tries = module._run_command, []

    def dies_once(*arguments):
        tries.append(arguments)
        if len(tries) == 3:
            raise module._Died("the command died by signal 9")
        return original(*arguments)

    module._run_command = dies_once
    try:
        with concurrent.futures.ThreadPoolExecutor(1) as executor:
            batch = chasles.batch(recordings[:2], tmp_path / "out", options=OPTIONS, executor=executor)
    finally:
        module._run_command = original
    assert batch.retried == 1 and batch.names("use") == ["a", "b"]


def test_options_that_are_parameters_are_said(recordings, tmp_path):
    for options in (["--shard", "1/2"], ["--collect"], ["--against", "x"], ["1"]):
        with pytest.raises(chasles.UsageError, match="options: found"):
            chasles.batch(recordings[:1], tmp_path / "x", options=options)
    with pytest.raises(chasles.UsageError, match="list of texts"):
        chasles.batch("abc", tmp_path / "x")


def test_recordings_and_results_behind_urls(recordings, tmp_path):
    fsspec = pytest.importorskip("fsspec")
    files_of = fsspec.filesystem("memory")
    files_of.put(str(recordings[0]), "/in/a", recursive=True)
    urls = ["memory://in/a", "memory://in/none"]
    batch = chasles.batch(urls, "memory://out", options=OPTIONS, cache=tmp_path / "cache")
    assert batch.names("use") == ["a"] and batch.names("no") == ["none"]
    assert batch.records[0]["recording"] == "memory://in/a"
    assert files_of.exists("/out/page.html") and files_of.exists("/out/runs/a/states.csv")
    alone = chasles.batch(recordings[:1], tmp_path / "alone", options=OPTIONS)
    assert files_of.cat("/out/runs/a/states.csv") == pathlib.Path(alone.folder, "runs/a/states.csv").read_bytes()
    again = chasles.batch(urls, "memory://out", options=OPTIONS, resume=True, on_record=pytest.fail)
    assert again.summary == batch.summary
    assert json.loads(files_of.cat("/out/summary.json"))["recordings"] == 2


def test_the_example_of_the_page(recordings, tmp_path, monkeypatch, capsys):
    page = pathlib.Path(__file__).resolve().parents[2] / "docs/many.md"
    (block,) = re.findall(r"```python\n(.*?)```", page.read_text(), re.DOTALL)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "demos").mkdir()
    for recording in recordings[:2]:
        (tmp_path / "demos" / recording.name).symlink_to(recording)
    block = block.replace('estimator="filter"', 'estimator="filter", options=["--no-check", "--most-sigma", "1"]')
    names = {}
    exec(compile(block, str(page), "exec"), names)
    counts = {name: len(names["batch"].run(name).smoothed["position"]) for name in "ab"}
    assert capsys.readouterr().out == f"a {counts['a']}\nb {counts['b']}\n" and counts["a"] > 10


def test_a_study_on_an_executor_has_the_same_bytes(tmp_path):
    filters = {"ours": {}, "standard": {"chart": "standard"}}
    scene = {"revolutions": 0.12}
    here = chasles.monte_carlo("turntable", filters, runs=5, folder=tmp_path / "here", **scene)
    with concurrent.futures.ProcessPoolExecutor(2) as executor:
        there = chasles.monte_carlo("turntable", filters, runs=5, folder=tmp_path / "there", executor=executor, **scene)
        with pytest.raises(chasles.UsageError, match="gaet"):
            chasles.monte_carlo("turntable", {"x": {"gaet": 1}}, runs=2, executor=executor)
    assert files(here.folder) == files(there.folder) and here.table == there.table
