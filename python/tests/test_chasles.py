"""The Python module against the command, the simulator's truth, and figures computed with numpy."""

import json
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time

import numpy
import pytest

import chasles

BINARY = os.environ.get("CHASLES_BINARY")


SHORT = {"sections": 1, "hall_length": 12}
SMALL = {"image_width": 320, "image_height": 240, "focal_length": 180, "center_u": 160, "center_v": 120, "frame_rate": 10}


@pytest.fixture(scope="module")
def walk():
    return chasles.simulate("hallway", sections=1, hall_length=20)


@pytest.fixture(scope="module")
def images():
    return chasles.simulate("hallway", images=True, **SHORT, **SMALL)


@pytest.fixture(scope="module")
def walk_run(walk):
    return chasles.run(walk)


def test_states_at_given_times_are_between_those_of_the_run(walk_run):
    states = walk_run.states
    same = walk_run.states_at(states["time"])
    assert same["known"].all()
    for name in ("position", "quaternion", "pose_covariance", "velocity_x", "sigma_velocity_x"):
        assert numpy.array_equal(same[name], states[name]), name
    assert "nis" not in same and set(same["health"]) <= {"ok", "degraded"}
    # A third of the way to the next state; times in seconds, and in any order.
    third = states["time"][:-1] + (states["time"][1:] - states["time"][:-1]) // 3
    rows = walk_run.states_at(third[::-1])
    assert rows["known"].all() and numpy.array_equal(rows["time"], third[::-1])
    expected = states["position"][:-1] + (states["position"][1:] - states["position"][:-1]) / 3
    assert numpy.allclose(rows["position"][::-1], expected, atol=1e-6)
    assert numpy.allclose(numpy.linalg.norm(rows["quaternion"], axis=1), 1, atol=1e-12)
    between = states["pose_covariance"][:-1] * 2 / 3 + states["pose_covariance"][1:] / 3
    assert numpy.allclose(rows["pose_covariance"][::-1], between, atol=1e-9)
    seconds = walk_run.states_at([states["time"][3] * 1e-9])
    assert numpy.allclose(seconds["position"][0], states["position"][3], atol=1e-4)
    # Outside of the path and in gaps: the nearest state, and no number that is not finite.
    outside = walk_run.states_at([states["time"][0] - 10**9, states["time"][-1] + 1])
    assert outside["known"].tolist() == [False, False]
    assert numpy.array_equal(outside["position"], states["position"][[0, -1]])
    assert all(numpy.isfinite(column).all() for name, column in outside.items() if name != "health")
    assert not walk_run.states_at(third, longest_gap=1e-3)["known"].any()
    smoothed = walk_run.states_at(walk_run.smoothed["time"], smoothed=True)
    assert numpy.array_equal(smoothed["position"], walk_run.smoothed["position"])
    assert set(smoothed) == {"time", "position", "quaternion", "pose_covariance", "known"}


def test_states_at_says_what_it_expects(walk, walk_run):
    with pytest.raises(chasles.UsageError, match="longest_gap: found 0 s, expected above 0"):
        walk_run.states_at([1], longest_gap=0)
    with pytest.raises(ValueError, match="times"):
        walk_run.states_at([[1, 2]])
    window = chasles.run(walk, estimator="window:5")
    with pytest.raises(chasles.UsageError, match="has no smoothed, expected one of a filter with exact_map"):
        window.states_at([1], smoothed=True)


def test_a_recording_is_arrays(walk):
    imu = walk.imu
    assert imu["time"].dtype == numpy.int64 and (numpy.diff(imu["time"]) > 0).all()
    assert imu["specific_force"].shape == (len(imu["time"]), 3)
    assert numpy.linalg.norm(imu["specific_force"].mean(0)) == pytest.approx(9.8, abs=1)
    assert len(walk) == len(walk.frame_times) > 50
    assert numpy.linalg.norm(walk.truth["quaternion"], axis=1) == pytest.approx(1)
    tracks = walk.tracks(-1)
    assert tracks["pixel"].shape == (len(tracks["landmark"]), 2)
    with pytest.raises(IndexError, match="the recording has"):
        walk.tracks(10**6)
    assert "hallway" in repr(walk)


def test_a_run_agrees_with_the_truth(walk_run):
    states = walk_run.states
    assert states["pose_covariance"].shape == (len(states["time"]), 6, 6)
    assert walk_run.summary["ate_m"] < 0.1
    assert set(states["health"]) <= {"ok", "degraded"}
    assert walk_run.landmarks["covariance"].shape[1:] == (3, 3)
    assert len(walk_run.smoothed["time"]) == len(states["time"])
    speed = numpy.linalg.norm(numpy.gradient(states["position"], 1e-9 * states["time"], axis=0), axis=1)
    estimated = numpy.linalg.norm([states[f"velocity_{axis}"] for axis in "xyz"], axis=0)
    assert numpy.median(abs(speed - estimated)) < 0.1  # positions are corrected from frame to frame


@pytest.mark.skipif(BINARY is None, reason="CHASLES_BINARY names no command")
def test_its_files_are_those_of_the_command(walk, walk_run, tmp_path):
    subprocess.run([BINARY, "simulate", "hallway", "--set", "sections=1", "--set", "hall_length=20", "-o", tmp_path / "walk", "--quiet"], check=True,
                   timeout=60)
    subprocess.run([BINARY, "run", tmp_path / "walk", "-o", tmp_path / "command", "--quiet"], check=True, timeout=60)
    chasles.run(tmp_path / "walk").save(tmp_path / "python")
    for name in ("states.csv", "landmarks.csv", "trajectory.tum", "smoothed.csv"):
        assert (tmp_path / "python" / name).read_bytes() == (tmp_path / "command" / name).read_bytes(), name
    command, python = (json.loads((tmp_path / which / "summary.json").read_text()) for which in ("command", "python"))
    command.pop("files"), python.pop("files")
    assert python == command
    read = chasles.read_run(tmp_path / "command")
    assert (read.states["position"] == chasles.run(tmp_path / "walk").states["position"]).all()


def test_the_evaluation_is_that_of_numpy(walk, walk_run):
    figures = walk_run.evaluate()
    assert figures["ate_m"] == pytest.approx(walk_run.summary["ate_m"], rel=1e-9)
    truth, states = walk_run.truth, walk_run.states
    _, mine, theirs = numpy.intersect1d(states["time"], truth["time"], return_indices=True)
    a, b = states["position"][mine], truth["position"][theirs]
    U, _, V = numpy.linalg.svd((b - b.mean(0)).T @ (a - a.mean(0)))
    R = U @ numpy.diag([1, 1, numpy.linalg.det(U @ V)]) @ V
    ate = numpy.sqrt((((a - a.mean(0)) @ R.T - (b - b.mean(0))) ** 2).sum(1).mean())
    assert figures["ate_m"] == pytest.approx(ate, rel=1e-9)
    assert figures["nees_pose"] == pytest.approx(walk_run.summary["nees_pose"], rel=1e-9)
    bare = chasles.evaluate({"time": truth["time"], "position": truth["position"] + [1, 2, 3]}, truth)
    assert bare["ate_m"] == pytest.approx(0, abs=1e-9)


def test_step_by_step_it_is_the_run(images):
    whole = chasles.run(images, threads=1)
    slam = chasles.Slam(images.cameras, images.imu_noise)
    assert not slam.started and slam.why_not_started
    imu, times = images.imu, images.frame_times
    estimates, sample = [], 0
    for i, when in enumerate(times):
        estimates += slam.add_images(int(when), images.images(i))
        last = numpy.searchsorted(imu["time"], when)
        estimates += slam.add_imu(imu["time"][sample:last + 1], imu["angular_rate"][sample:last + 1],
                                  imu["specific_force"][sample:last + 1])
        sample = last + 1
    estimates += slam.add_imu(imu["time"][sample:], imu["angular_rate"][sample:], imu["specific_force"][sample:])
    estimates += slam.finish()
    assert [e.time for e in estimates] == list(whole.states["time"])
    assert numpy.array_equal([e.position for e in estimates], whole.states["position"])
    last = estimates[-1]
    assert last.covariance.shape == (15, 15) and last.velocity.shape == (3,)
    assert numpy.array_equal(last.world_T_imu[:3, 3], last.position)
    assert slam.started and slam.waiting == 0 and len(slam.landmarks["id"]) > 20
    assert last.map_T_imu is None and last.health == "ok"


def test_one_sample_and_seconds(images):
    slam = chasles.Slam(images.cameras, images.imu_noise)
    assert slam.add_imu(1.5, numpy.zeros(3), [0, 0, 9.81]) == []
    assert slam.add_imu(numpy.int64(1_600_000_000), [0, 0, 0], numpy.array([0, 0, 9.81])) == []


@pytest.mark.parametrize("call, error, says", [
    (lambda slam, walk: chasles.run(walk, max_landmark=30), chasles.UsageError, "max_landmarks"),
    (lambda slam, walk: chasles.run(walk, gate=2), chasles.UsageError, "gate"),
    (lambda slam, walk: chasles.run(walk, start={"headin": 0}), chasles.UsageError, "start.heading"),
    (lambda slam, walk: chasles.run(walk, estimator="window"), chasles.UsageError, "window:N"),
    (lambda slam, walk: chasles.run(walk, threads=0), chasles.UsageError, "threads"),
    (lambda slam, walk: chasles.simulate("hallwa"), chasles.UsageError, "hallway"),
    (lambda slam, walk: chasles.read("nowhere"), chasles.InputError, "nowhere"),
    (lambda slam, walk: chasles.evaluate({}, walk.truth), chasles.UsageError, "time"),
    (lambda slam, walk: slam.add_imu("now", [0, 0, 0], [0, 0, 0]), TypeError, "nanoseconds"),
    (lambda slam, walk: slam.add_imu(float("nan"), [0, 0, 0], [0, 0, 0]), ValueError, "finite"),
    (lambda slam, walk: slam.add_imu(1, numpy.zeros((2, 3)), numpy.zeros((2, 3))), ValueError, "2 x 3"),
    (lambda slam, walk: slam.add_imu(1.4e18, [0, 0, 0], [0, 0, 0]), ValueError, "Nanoseconds are ints"),
    (lambda slam, walk: slam.add_imu(2**70, [0, 0, 0], [0, 0, 0]), ValueError, "64 bits"),
    (lambda slam, walk: slam.add_imu(numpy.array([1.4e18]), [[0, 0, 0]], [[0, 0, 0]]), ValueError, "Nanoseconds are ints"),
    (lambda slam, walk: slam.add_imu(numpy.float32([1]), [[0, 0, 0]], [[0, 0, 0]]), TypeError, "numpy.float32"),
    (lambda slam, walk: slam.add_imu(numpy.array([[1]]), [[0, 0, 0]], [[0, 0, 0]]), ValueError, "2 dimensions"),
    (lambda slam, walk: slam.predicted(numpy.array([1])), TypeError, "numpy.ndarray"),
    (lambda slam, walk: slam.predicted(numpy.array(1.5)), TypeError, "numpy.ndarray"),
    (lambda slam, walk: chasles.run(walk, threads="4"), TypeError, "threads: found '4', expected an int"),
    (lambda slam, walk: chasles.run(walk, estimator=20), TypeError, "estimator: found 20, expected a str"),
    (lambda slam, walk: slam.add_images(1, [numpy.zeros((2, 2))]), ValueError, "uint8"),
    (lambda slam, walk: slam.add_images(1, []), chasles.InputError, "0"),
    (lambda slam, walk: chasles.Camera(10, 10, 5, 5, 5, 5, distortion="fisheye"), ValueError, "equidistant"),
    (lambda slam, walk: chasles.Camera(10, 10, 5, 5, 5, 5, cam_T_imu=2 * numpy.eye(4)), ValueError, "rotation"),
])
def test_bad_calls_are_errors_that_say_what_was_expected(images, walk, call, error, says):
    slam = chasles.Slam(images.cameras, images.imu_noise)
    with pytest.raises(error) as caught:
        call(slam, walk)
    assert says in str(caught.value)
    if issubclass(error, chasles.Error):
        assert isinstance(caught.value, ValueError)


def test_a_recording_that_cannot_start_says_why():
    with pytest.raises(chasles.NotInitialisedError, match="not initialised"):
        chasles.run(chasles.simulate("turntable", revolutions=0.03))


def test_it_releases_the_interpreter(images):
    done = []

    def count():
        while not done:
            counted[0] += 1
            time.sleep(0.001)

    counted = [0]
    thread = threading.Thread(target=count)
    thread.start()
    try:
        chasles.run(images)
    finally:
        done.append(True)
        thread.join()
    assert counted[0] > 20


def test_threads_take_turns(walk, walk_run):
    results = [None] * 3

    def work(i):
        results[i] = chasles.run(walk).states["position"]

    threads = [threading.Thread(target=work, args=(i,)) for i in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for positions in results:
        assert numpy.array_equal(positions, walk_run.states["position"])


def test_ctrl_c_ends_a_run():
    long = chasles.simulate("hallway")
    begin = time.process_time()  # other processes do not count
    chasles.run(long)
    whole = time.process_time() - begin
    threading.Timer(0.2, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    begin = time.process_time()
    with pytest.raises(KeyboardInterrupt):
        chasles.run(long)
    assert time.process_time() - begin < whole / 2


def test_signals_end_the_command(tmp_path):
    command = [sys.executable, "-c", "import chasles; chasles.main()"]
    with subprocess.Popen([*command, "simulate", "--help"], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as closed:
        closed.stdout.close()
        assert closed.wait(60) == -signal.SIGPIPE
    with subprocess.Popen([*command, "simulate", "hallway", "--images", "-o", tmp_path / "walk"]) as working:
        while working.poll() is None and not any(tmp_path.iterdir()):
            time.sleep(0.01)
        working.send_signal(signal.SIGINT)
        assert working.wait(60) == -signal.SIGINT


def test_the_page_is_one(walk_run, tmp_path):
    walk_run.show(tmp_path / "run.html")
    page = (tmp_path / "run.html").read_text()
    assert page.startswith("<!doctype html>") or page.startswith("<!DOCTYPE html>")
    comparison = chasles.compare(chasles.simulate("hallway", **SHORT), {"ours": {}, "<other>": {"chart": "standard"}})
    assert "nees_pose" in comparison._repr_html_() and "&lt;other&gt;" in comparison._repr_html_()


def test_settings_are_listed():
    known = chasles.settings()
    assert known["chart"]["default"] == "right-sen3"
    assert known["start.heading"]["unit"] == "rad"
    assert "velocity_axes" in chasles.settings("velocity")
    with pytest.raises(ValueError, match="imu"):
        chasles.settings("lidar")


def test_the_command_is_there(capfd):
    assert chasles.command("--version") == 0
    assert chasles.__version__ in capfd.readouterr().out
    assert chasles.command("no-such-command") == 1


def test_a_map_goes_from_run_to_run(tmp_path):
    scene = {"sections": 1, "hall_length": 16, **SMALL}
    walk = chasles.simulate("hallway", images=True, **scene)
    chasles.run(walk, save_map=tmp_path / "hall.map")
    run = chasles.run(chasles.simulate("hallway", images=True, run=1, **scene), map=tmp_path / "hall.map")
    assert run.summary["place_in_map"]["placed_ns"] is not None
    assert len(run.in_map["time"]) > 0


def test_a_run_whose_map_cannot_be_saved_is_not_lost(images, tmp_path):
    folder = tmp_path / "maps"
    folder.mkdir()

    def remove_folder(sight):
        if folder.exists():
            folder.rmdir()
        return (0.1, 0.1) if sight.inverse else (10, 10)

    chasles.register_depth_rule("remove-folder", remove_folder)
    with pytest.raises(chasles.UsageError, match="hall.map.*cannot be written") as caught:
        chasles.run(images, save_map=folder / "hall.map", init="fixed-depth", depth_rule="remove-folder")
    assert len(caught.value.run.states["time"]) > 10
    assert chasles.UsageError("another").run is None


def test_arrays_stay_what_they_are(walk):
    R, other = numpy.eye(3), numpy.diag([-1.0, -1.0, 1.0])
    state = chasles.ChartState(R, [1, 2, 3], [0, 0, 0], numpy.ones((5, 3)))
    kept = state.R, state.p, state.points
    state.R, state.p, state.points = other, [0, 0, 0], numpy.zeros((500, 3))
    for array, expected in zip(kept, (R, [1, 2, 3], numpy.ones((5, 3)))):
        assert (array == expected).all()
    assert (state.R == other).all() and state.points.shape == (500, 3)
