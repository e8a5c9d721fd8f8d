"""What the package says: names of Python, and the nearest one for a misspelt argument."""

import copy
import os
import pickle
import subprocess
import sys
import types

import numpy
import pytest

import chasles
from chasles import _core, _progress
from chasles._laboratory import laboratory
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
                                 {"cameras": "stereo"}, {"cameras": [0, 0]}, {"cameras": [1]}, {"truth_level": "maybe"}, {"pairing": "none"},
                                 {"max_truth_gap": float("nan")}])
def test_bad_parts_of_a_recording_are_errors(bad, tmp_path_factory):
    folder = tmp_path_factory.mktemp("read") / "walk"
    assert chasles.command("simulate", "hallway", "--set", "sections=1", "--set", "hall_length=4", "-o", folder, "--quiet") == 0
    with pytest.raises(chasles.UsageError) as caught:
        chasles.read(folder, **bad)
    assert "--" not in str(caught.value) and next(iter(bad)) in str(caught.value)


def test_cameras_are_chosen_by_their_numbers(tmp_path):
    folder = tmp_path / "ring"
    assert chasles.command("simulate", "hallway", "--set", "sections=1", "--set", "hall_length=4", "--set", "cameras=4",
                           "--set", "rig=ring", "-o", folder, "--quiet") == 0
    whole, part = chasles.read(folder), chasles.read(folder, cameras=[2, 0])
    assert len(part.cameras) == 2
    assert numpy.array_equal(part.cameras[0].cam_T_imu, whole.cameras[2].cam_T_imu)
    with pytest.raises(TypeError, match=r"cameras: found \[0.5\], expected .* a list of numbers"):
        chasles.read(folder, cameras=[0.5])


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


@pytest.mark.parametrize("of", [copy.copy, copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))])
def test_cameras_and_noises_can_be_copied_and_what_is_large_says_what_to_pass(walk, of):
    T = numpy.array([[0, -1, 0, .1], [1, 0, 0, .2], [0, 0, 1, .3], [0, 0, 0, 1]])
    camera = chasles.Camera(640, 480, 401, 402, 319, 239, "radtan", [.1, .2, .3, .4, .5], T, .02, "up")
    other = of(camera)
    names = ("width", "height", "fx", "fy", "cx", "cy", "distortion", "coefficients", "readout_time", "readout_direction")
    assert all(getattr(other, name) == getattr(camera, name) for name in names) and (other.cam_T_imu == camera.cam_T_imu).all()
    assert repr(of(walk.imu_noise)) == repr(walk.imu_noise)
    slam = chasles.Slam(walk.cameras, walk.imu_noise)  # the simulated noise is exact: so is that of its copy
    again = chasles.Slam(of(walk.cameras[0]), of(walk.imu_noise))
    assert repr(slam) == repr(again)
    for one, says in ((walk, "its path"), (chasles.run(walk), "read_run"), (slam, "in each process")):
        with pytest.raises(TypeError, match=says):
            of(one)


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

    def reset(self, total):
        self.n, self.total = 0, total

    def set_postfix_str(self, text):
        self.last = text


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
    if bar.total is not None:  # a quick call is over before the first poll
        assert bar.total >= total and 0 <= bar.n <= bar.total


def test_an_error_of_the_bar_ends_the_call(monkeypatch):
    def advance(done, total):
        raise ZeroDivisionError("mine")

    with pytest.raises(ZeroDivisionError, match="mine"):
        laboratory().simulate("hallway", images=True, progress=advance)


def test_a_bar_that_is_wanted_needs_tqdm(monkeypatch, walk):
    monkeypatch.setitem(sys.modules, "tqdm", None)
    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    with pytest.raises(ImportError, match="pip install tqdm"):
        chasles.run(walk, progress=True)
    chasles.run(walk)  # no bar is no error


def test_a_bar_says_what_goes_on_after_the_last_frame(monkeypatch):
    monkeypatch.setattr(_progress, "_bar_class", lambda: FakeBar)
    FakeBar.made.clear()
    with _progress.bar(True, "run", "frames", "batch") as advance:
        for _ in range(3):
            advance(10, 10)
        (bar,) = FakeBar.made
        assert not hasattr(bar, "last")  # what ends at once needs no word
        for _ in range(10):
            advance(10, 10)
        assert bar.last == "batch"
        advance(1, 5)
        assert (bar.n, bar.total) == (1, 5)


def test_a_notebook_without_widgets_gets_text_and_no_warning(monkeypatch):
    tqdm = pytest.importorskip("tqdm")
    monkeypatch.setattr(_progress, "_in_notebook", lambda: True)
    monkeypatch.setitem(sys.modules, "ipywidgets", None)
    monkeypatch.delitem(sys.modules, "tqdm.auto", raising=False)
    assert _progress._bar_class() is tqdm.std.tqdm and "tqdm.auto" not in sys.modules


def test_a_check_without_progress_draws_nothing(tmp_path):
    """The command's own bar is drawn on a terminal alone: here a pseudo-terminal."""
    program = (f"import chasles; w = chasles.simulate('hallway', images=True, sections=1, hall_length=8, image_width=320, "
               "image_height=240, focal_length=180, center_u=160, center_v=120, frame_rate=10); "
               "chasles.check(w, progress=False)")
    terminal, end = os.openpty()
    done = subprocess.run([sys.executable, "-c", program], stderr=end, timeout=100)
    os.close(end)
    os.set_blocking(terminal, False)
    try:
        drawn = os.read(terminal, 10_000)
    except (BlockingIOError, OSError):
        drawn = b""
    os.close(terminal)
    assert done.returncode == 0 and drawn == b""


CAMERA = {"width": 640, "height": 480, "fx": 400.0, "fy": 400.0, "cx": 320.0, "cy": 240.0}
NOISE = {"accelerometer_noise_density": 1e-3, "gyroscope_noise_density": 1e-4, "accelerometer_random_walk": 1e-3,
         "gyroscope_random_walk": 1e-5}


@pytest.mark.parametrize("call, says", [
    (lambda w: chasles.read("a", stop="5"), "read: stop: found '5', expected a number, or None"),
    (lambda w: chasles.read("a", cameras=1.5), "read: cameras: found 1.5, expected 'mono', 'stereo', '' (all) or a list"),
    (lambda w: chasles.read("a", truth_time_offset="now"), "truth_time_offset: found 'now', expected a finite number"),
    (lambda w: chasles.read("a", truth_scale=-1), "truth_scale: found -1, expected a number from"),
    (lambda w: chasles.simulate("hallway", run="1"), "simulate: run: found '1', expected an int"),
    (lambda w: chasles.simulate("hallway", run=-1), "simulate: run: found -1, expected a whole number"),
    (lambda w: chasles.check(w, seconds="a"), "check: seconds: found 'a', expected a number"),
    (lambda w: chasles.settings(5), "settings: kind: found 5, expected a str"),
    (lambda w: chasles.join_imu([1], "a", [1], "b"), "join_imu: angular_rate: found 'a', expected an array"),
    (lambda w: chasles.Slam(5, w.imu_noise), "Slam: cameras: found 5, expected a Camera, or a list of them"),
    (lambda w: chasles.Slam(w.cameras, 5), "Slam: noise: found 5, expected an ImuNoise"),
    (lambda w: chasles.Slam(w.cameras), "Slam: noise is missing"),
    (lambda w: chasles.Slam(w.cameras, w.imu_noise, most_images=3), "most_images is an argument of RealtimeSlam"),
    (lambda w: chasles.Slam(w.cameras, w.imu_noise, max_landmarks=None), "max_landmarks: found None, expected a value"),
    (lambda w: chasles.run(w, batch={"max_iterations": None}), "batch.max_iterations: found None, expected a value"),
    (lambda w: chasles.RealtimeSlam(w.cameras, w.imu_noise, most_images=-1), "RealtimeSlam: most_images: found -1"),
    (lambda w: chasles.Slam(w.cameras, w.imu_noise).add_imu(1, "a", "b"), "Slam.add_imu: angular_rate: found 'a'"),
    (lambda w: w.tracks("a"), "Recording.tracks: index: found 'a', expected an int"),
    (lambda w: chasles.Camera(**{**CAMERA, "width": 752.0}), "Camera: width: found 752.0, expected an int"),
    (lambda w: chasles.Camera(**{**CAMERA, "width": -5}), "Camera: width: found -5"),
    (lambda w: chasles.Camera(**{**CAMERA, "fx": float("nan")}), "Camera: fx: found nan"),
    (lambda w: chasles.Camera(**{**CAMERA, "fy": -1}), "Camera: fy: found -1"),
    (lambda w: chasles.Camera(**{**CAMERA, "cx": float("inf")}), "Camera: cx: found inf"),
    (lambda w: chasles.Camera(640, 480, 400, 400), "Camera: cx is missing"),
    (lambda w: chasles.Camera(**CAMERA, fz=3), "Camera: unknown argument 'fz'; did you mean"),
    (lambda w: chasles.Camera(**CAMERA, cam_T_imu=numpy.eye(3)), "cam_T_imu: found an array (3, 3) of float64, expected an array (4, 4)"),
    (lambda w: chasles.Camera(**CAMERA, cam_T_imu=2 * numpy.eye(4)), "Camera: cam_T_imu: found R with det(R) = 8"),
    (lambda w: chasles.Camera(**CAMERA, distortion="radtan", coefficients=[numpy.nan, 0, 0, 0]), "coefficients: found nan"),
    (lambda w: chasles.Camera(**CAMERA, readout_time=20), "Camera: readout_time: found 20, expected seconds from 0 to 0.2"),
    (lambda w: chasles.Camera(**CAMERA, readout_time=.02, readout_direction="x"), "readout_direction: found 'x', expected one of down"),
    (lambda w: chasles.ImuNoise(**{**NOISE, "gyroscope_random_walk": -1}), "ImuNoise: gyroscope_random_walk: found -1"),
    (lambda w: chasles.ImuNoise(1, 2, 3, 4), "ImuNoise: found 4 arguments without a name"),
    (lambda w: chasles.run(w, start=5), "chasles.read(path, start=5)"),
    (lambda w: chasles.run(w, stop=5), "run(chasles.read(path, stop=5))"),
    (lambda w: chasles.run(w, batch=5), "batch: found 5, expected a dictionary of settings of this prefix"),
    (lambda w: chasles.compare(w, ["filter"]), "compare: estimators: found ['filter']; expected {name: {setting: value}}"),
    (lambda w: chasles.monte_carlo("hallway", {"a": 5}, runs=1), "monte_carlo: filters: 'a': found 5"),
    (lambda w: chasles.evaluate(w.truth, w.truth, chart="x"), "chart: found 'x', expected one of standard, left-se3"),
    (lambda w: chasles.evaluate(w.truth, w.truth, truth_errors=True), "truth_errors: found True, expected 'auto' or 'none'"),
    (lambda w: chasles.evaluate("a", w.truth), "estimate: found 'a'; expected a Run, or a dictionary of columns"),
    (lambda w: chasles.evaluate({**w.truth, "position": "a"}, w.truth), "estimate: position: found 'a', expected numbers"),
    (lambda w: chasles.run(w).errors([1, 2]), "truth: found [1, 2]; expected a Run, or a dictionary of columns"),
])
def test_arguments_of_the_wrong_kind_are_errors_of_one_line(walk, call, says):
    with pytest.raises((TypeError, ValueError)) as caught:
        call(walk)
    assert says in str(caught.value) and "\n" not in str(caught.value) and len(str(caught.value)) < 300


def test_errors_of_tables_of_pandas_say_so(walk):
    pandas = pytest.importorskip("pandas")
    run = chasles.run(walk)
    with pytest.raises(chasles.UsageError, match="truth: found a DataFrame; expected a Run, or a dictionary of columns"):
        run.errors(run.to_dataframe())
    assert pandas


@pytest.mark.parametrize("message, says", [
    ("--truth-time-offset -0.1000 (or auto) corrects it", "truth_time_offset=-0.1000 (or auto) corrects it"),
    ("--truth-scale .001 takes", "truth_scale .001 takes"),
    ("a run corrects the stamps with --set time_offset=0.1, or auto", "a run corrects the stamps with time_offset=0.1, or auto"),
    ("a file of `chasles run --save-map`", "a file of chasles.run(recording, save_map=FILE)"),
    ("go on with it by `chasles montecarlo --resume`", "go on with it by `chasles montecarlo --resume`"),
    ("a longer gap (--max-truth-gap) or", "a longer gap (max_truth_gap) or"),
])
def test_what_the_command_says_is_said_in_python(message, says):
    assert _core.in_python(message) == says


def test_remarks_of_a_summary_are_in_python(walk):
    for run in (chasles.run(walk), chasles.run(walk, estimator="window:10")):
        assert not any("--" in remark for remark in run.summary["remarks"])


def test_errors_say_what_they_are():
    for error in (chasles.Error, chasles.UsageError, chasles.InputError, chasles.NotInitialisedError, chasles.DivergedError):
        assert error.__doc__ and "\n" not in error.__doc__
    assert issubclass(chasles.InputError, ValueError) and chasles.Error.run is None


def test_the_package_is_a_program():
    done = subprocess.run([sys.executable, "-m", "chasles", "--version"], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0 and done.stdout.strip() == f"chasles {chasles.__version__}"


def test_a_type_error_of_a_callback_comes_as_it_is():
    small = chasles.simulate("hallway", images=True, sections=1, hall_length=4, image_width=160, image_height=120,
                             focal_length=90, center_u=80, center_v=60, frame_rate=5)
    said = "detect(): incompatible function arguments. The following argument types are supported:\n    1. (x: int) -> int"

    def images(index):
        raise TypeError(said)

    imu = small.imu
    recording = chasles.Recording.from_arrays(
        imu_time=imu["time"], angular_rate=imu["angular_rate"], specific_force=imu["specific_force"],
        image_time=small.frame_times, images=images, cameras=small.cameras, imu_noise=small.imu_noise)
    with pytest.raises(TypeError) as error:
        recording.images(3)
    assert str(error.value) == said


def test_buffers_are_images_and_warnings_are_the_callers():
    camera = chasles.Camera(width=64, height=48, fx=40, fy=40, cx=32, cy=24)
    noise = chasles.ImuNoise(accelerometer_noise_density=1e-2, gyroscope_noise_density=1e-3,
                             accelerometer_random_walk=1e-3, gyroscope_random_walk=1e-4)
    slam = chasles.Slam(camera, noise)
    image = numpy.zeros((48, 64), numpy.uint8)
    slam.add_images(2_000_000_000, [memoryview(image)])
    with pytest.warns(RuntimeWarning) as warned:
        slam.add_imu(10, [0, 0, numpy.nan], [0, 0, 9.81])
        slam.add_imu(1_000_000_000, [0, 0, 0], [0, 0, 9.81])
    assert {one.filename for one in warned} == {__file__}
