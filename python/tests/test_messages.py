"""What the package says: names of Python, and the nearest one for a misspelt argument."""

import copy
import pickle
import sys
import types

import numpy
import pytest

import chasles
from chasles import _core, _progress
from chasles._optional import optional

NO_OPTION = r"(?s)^(?!.*--[a-z])"


@pytest.fixture(scope="module")
def walk():
    return chasles.simulate("hallway", sections=1, hall_length=12)


@pytest.fixture(scope="module")
def drive():
    return chasles.simulate("street", length=40) if "length" in chasles.settings("street") else chasles.simulate("street")


@pytest.mark.parametrize("call, says", [
    (lambda w, d: chasles.run(w, estimater="batch"), "did you mean 'estimator'"),
    (lambda w, d: chasles.run(w, thread=1), "did you mean 'threads'"),
    (lambda w, d: chasles.run(w, max_landmark=3), "did you mean 'max_landmarks'"),
    (lambda w, d: chasles.run(w, start={"headin": 0}), "did you mean 'start.heading'"),
    (lambda w, d: chasles.run(w, batch={"loss_widht": 0}), "did you mean 'batch.loss_width'"),
    (lambda w, d: chasles.compare(w, {"a": {"estimater": "batch"}}), "did you mean 'estimator'"),
    (lambda w, d: chasles.compare(w, {"a": {}}, estimater="batch"), "did you mean 'estimator'"),
    (lambda w, d: chasles.Slam(w.cameras, w.imu_noise, estimater="batch"), "did you mean 'estimator'"),
    (lambda w, d: chasles.RealtimeSlam(w.cameras, w.imu_noise, most_image=3), "did you mean 'most_images'"),
    (lambda w, d: chasles.read("MH_01", strat=1), "did you mean 'start'"),
    (lambda w, d: chasles.evaluate(w.truth, w.truth, leval=True), "did you mean 'level'"),
    (lambda w, d: chasles.simulate("hallway", hall_lenght=3), "did you mean 'hall_length'"),
    (lambda w, d: chasles.simulate("street", block_lenght=3), "did you mean 'block_length'"),
    (lambda w, d: chasles.monte_carlo("hallway", {"a": {"estimater": "batch"}}, runs=1), "did you mean 'estimator'"),
    (lambda w, d: chasles.monte_carlo("hallway", {"a": {}}, runs=1, hall_lenght=3), "did you mean 'hall_length'"),
    (lambda w, d: chasles.run(w, save_map="a.map", estimator="batch"), "map and save_map are for the filter"),
    (lambda w, d: chasles.run(w, begin="now"), "begin: found 'now'"),
    (lambda w, d: chasles.run(w, mode="map"), "mode: a visual-inertial run"),
    (lambda w, d: chasles.run(d, save_map="a.map"), "map and save_map are for a recording with an IMU"),
    (lambda w, d: chasles.run(d, keep_images=3), "keep_images is for a recording with an IMU"),
    (lambda w, d: chasles.simulate("trajectory"), "path=FILE"),
])
def test_messages_are_those_of_python(walk, drive, call, says):
    with pytest.raises(chasles.UsageError) as caught:
        call(walk, drive)
    assert says in str(caught.value)
    assert "--" not in str(caught.value) and "KEY=VALUE" not in str(caught.value)


@pytest.mark.parametrize("bad", [{"stop": float("nan")}, {"start": float("nan")}, {"start": float("inf")},
                                 {"stop": float("-inf")}, {"start": 1e9}, {"stop": -1.0}, {"cameras": "tri"},
                                 {"cameras": "stereo"}, {"truth_level": "maybe"}, {"pairing": "none"},
                                 {"max_truth_gap": float("nan")}])
def test_bad_parts_of_a_recording_are_errors(bad, tmp_path_factory):
    folder = tmp_path_factory.mktemp("read") / "walk"
    assert chasles.command("simulate", "hallway", "--set", "sections=1", "--set", "hall_length=4", "-o", folder, "--quiet") == 0
    with pytest.raises(chasles.UsageError) as caught:
        chasles.read(folder, **bad)
    assert "--" not in str(caught.value) and next(iter(bad)) in str(caught.value)


def test_optional_packages_are_named_as_the_index_has_them():
    with pytest.raises(ImportError, match="pip install nothing-of-that-name$"):
        optional("nothing_of_that_name", "nothing-of-that-name")


BOUND = [one for one in vars(_core).values() if isinstance(one, type) and not issubclass(one, Exception)]


@pytest.mark.parametrize("bound", BOUND, ids=lambda one: one.__name__)
def test_an_object_without_content_is_a_type_error(bound):
    assert len(BOUND) >= 10
    bare = bound.__new__(bound)
    members = [name for name in vars(bound) if isinstance(vars(bound)[name], property)]
    for name in members:
        with pytest.raises(TypeError):
            getattr(bare, name)
    if "__repr__" in vars(bound):
        with pytest.raises(TypeError):
            repr(bare)


def test_copies_of_compiled_objects_are_errors_not_crashes(walk):
    for one in (walk, walk.cameras[0], walk.imu_noise):
        for attempt in (lambda: repr(copy.copy(one)), lambda: repr(pickle.loads(pickle.dumps(one)))):
            with pytest.raises(TypeError):
                attempt()


def test_objects_describe_themselves(walk):
    run = chasles.run(walk)
    slam = chasles.Slam(walk.cameras, walk.imu_noise)
    realtime = chasles.RealtimeSlam(walk.cameras, walk.imu_noise)
    state = chasles.ChartState(numpy.eye(3), [0, 0, 0], [0, 0, 0], numpy.zeros((2, 3)))
    for one, says in ((walk, "frames"), (walk.cameras[0], "px"), (walk.imu_noise, "rad/s"), (run, "ATE"),
                      (slam, "not started"), (realtime, "0 images came"), (state, "2 points")):
        assert repr(one).startswith("<chasles.") and says in repr(one), repr(one)


class FakeBar:
    made = []

    def __init__(self, **options):
        self.options, self.n, self.total = options, 0, None
        FakeBar.made.append(self)

    def __enter__(self):
        return self

    def __exit__(self, *error):
        pass

    def update(self, n):
        self.n += n


@pytest.mark.parametrize("call, total", [
    (lambda: chasles.run(chasles.simulate("hallway", sections=1, hall_length=40), progress=True), 200),
    (lambda: chasles.simulate("street", progress=True), 100),
    (lambda: chasles.monte_carlo("hallway", {"a": {}, "b": {}}, runs=3, sections=1, hall_length=10, progress=True), 3),
])
def test_a_bar_advances(monkeypatch, call, total):
    package = types.SimpleNamespace(tqdm=FakeBar)
    monkeypatch.setattr(_progress, "_bar_class", lambda: package.tqdm)
    FakeBar.made.clear()
    call()
    (bar,) = FakeBar.made
    if bar.total is not None:  # a quick call is over before the first look
        assert bar.total >= total and 0 <= bar.n <= bar.total


def test_an_error_of_the_bar_ends_the_call(monkeypatch):
    def advance(done, total):
        raise ZeroDivisionError("mine")

    with pytest.raises(ZeroDivisionError, match="mine"):
        _core.simulate("hallway", images=True, progress=advance)


def test_a_bar_that_is_wanted_needs_tqdm(monkeypatch, walk):
    monkeypatch.setitem(sys.modules, "tqdm", None)
    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    with pytest.raises(ImportError, match="pip install tqdm"):
        chasles.run(walk, progress=True)
    chasles.run(walk)  # no bar is no error
