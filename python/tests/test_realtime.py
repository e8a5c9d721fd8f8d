"""SLAM on a thread of its own, and the state between images."""

import os
import signal
import threading
import time
import warnings

import numpy
import pytest

import chasles

SMALL = {"sections": 1, "hall_length": 8, "image_width": 320, "image_height": 240, "focal_length": 180, "center_u": 160,
         "center_v": 120, "frame_rate": 10}

NOTHING = {"samples": 0, "samples_not_finite": 0, "samples_late": 0, "samples_dropped": 0, "images": 0,
           "images_late": 0, "images_uncovered": 0}


@pytest.fixture(scope="module")
def images():
    return chasles.simulate("hallway", images=True, **SMALL)


def play(slam, recording, each=lambda estimates: None):
    """The events in the order of time."""
    imu, frames = recording.imu, recording.frame_times
    k = 0
    for i, time in enumerate(imu["time"]):
        each(slam.add_imu(int(time), imu["angular_rate"][i], imu["specific_force"][i]))
        while k < len(frames) and frames[k] <= time:
            each(slam.add_images(int(frames[k]), recording.images(k)))
            k += 1


def test_it_gives_the_estimates_of_the_blocking_one(images):
    blocking = chasles.Slam(images.cameras, images.imu_noise)
    expected = []
    play(blocking, images, expected.extend)
    expected += blocking.finish()
    slam = chasles.RealtimeSlam(images.cameras, images.imu_noise, most_images=0)
    play(slam, images)
    end = int(images.imu["time"][-1])
    estimates = slam.finish()
    assert [e.time for e in estimates] == [e.time for e in expected]
    assert all((a.covariance == b.covariance).all() for a, b in zip(estimates, expected))
    assert slam.counts == {"came": len(images), "taken": len(images), "dropped": 0, "waiting": 0,
                           **blocking.counts}
    assert blocking.counts == {**NOTHING, "samples": len(images.imu["time"]), "images": len(images)}
    a, b = slam.predicted(end), blocking.predicted(end)
    assert (a.world_T_imu == b.world_T_imu).all() and (a.covariance == b.covariance).all()
    assert len(slam.landmarks["id"]) == len(blocking.landmarks["id"]) > 10
    assert slam.take() == [] and slam.why_not_started == ""


@pytest.mark.parametrize("kind", [chasles.Slam, chasles.RealtimeSlam])
def test_what_gives_no_estimate_is_counted_and_said_once(images, kind, recwarn):
    slam = kind(images.cameras, images.imu_noise)
    rate, force = images.imu["angular_rate"][:4], images.imu["specific_force"][:4].copy()
    force[2] = numpy.nan
    for time in (1000, 1010, 1000, 990):  # ns; the last two are late
        slam.add_images(time, images.images(0))
        for _ in range(2):
            slam.add_imu(numpy.array([time, time + 5, time + 6, time + 7]), rate, force)
    slam.finish()
    counts = slam.counts
    assert counts["samples"] == 32 and counts["samples_not_finite"] == 8 and counts["images"] == 4
    assert counts["images_late"] == 2 and counts["samples_late"] > 8 and counts["images_uncovered"] == 0
    said = [str(w.message) for w in recwarn.list if w.category is RuntimeWarning]
    assert len(said) == 3 and len(set(said)) == 3  # once each: not finite, late samples, late images
    assert "not finite" in " ".join(said) and "images are not later" in " ".join(said)


@pytest.mark.parametrize("kind", [chasles.Slam, chasles.RealtimeSlam])
def test_a_warning_that_is_an_error_costs_no_estimate(images, kind):
    slam = kind(images.cameras, images.imu_noise, **({"most_images": 0} if kind is chasles.RealtimeSlam else {}))
    clean = chasles.Slam(images.cameras, images.imu_noise)
    imu = images.imu["time"], images.imu["angular_rate"], images.imu["specific_force"]
    expected, estimates, errors = clean.add_imu(*imu), [], 0

    def call(method, *arguments):
        nonlocal errors
        try:
            got = method(*arguments)
            estimates.extend(got if isinstance(got, list) else [])
        except RuntimeWarning:
            errors += 1

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        call(slam.add_imu, *imu)
        for i, time in enumerate(images.frame_times):
            expected += clean.add_images(int(time), images.images(i))
            for _ in range(2):  # the second time they are late
                call(slam.add_images, int(time), images.images(i))
        expected += clean.finish()
        for _ in range(2):
            call(slam.finish)
    assert errors == 1 and [e.time for e in estimates] == [e.time for e in expected]


def test_the_prediction_moves_as_the_truth_does(images):
    slam = chasles.Slam(images.cameras, images.imu_noise)
    errors, sigmas, moved = [], [], []
    truth = images.truth
    last = None
    imu, frames, k = images.imu, images.frame_times, 0
    for i, time in enumerate(imu["time"]):
        slam.add_imu(int(time), imu["angular_rate"][i], imu["specific_force"][i])
        now = slam.predicted(int(time))
        if now is not None:
            assert now.covariance.shape == (15, 15) and 0 <= now.seconds_since_estimate < 0.3
            if last is not None:
                moved.append(numpy.linalg.norm(now.position - last.position))
            last = now
            if time in truth["time"]:
                up = now.world_T_imu[:3, :3] @ rotation(truth["quaternion"][truth["time"] == time][0]).T @ [0, 0, 1]
                errors.append(numpy.hypot(up[0], up[1]))
                sigmas.append(numpy.sqrt(now.covariance[0, 0] + now.covariance[1, 1]))
        while k < len(frames) and frames[k] <= time:
            slam.add_images(int(frames[k]), images.images(k))
            k += 1
    assert len(moved) > 300 and max(moved) < 0.1  # no jumps at the rate of the IMU
    assert len(errors) > 20 and (numpy.array(errors) < 5 * numpy.array(sigmas)).all()
    assert slam.predicted(0) is None and slam.predicted(imu["time"][-1] / 1e9 + 0.6) is None


def rotation(q):
    x, y, z, w = q
    return numpy.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def test_images_that_nobody_has_time_for_are_dropped(images):
    slam = chasles.RealtimeSlam(images.cameras, images.imu_noise, most_images=1)
    k = images.frame_times
    first = images.images(0)
    displaced = sum(slam.add_images(int(k[0]) + i, first) for i in range(300))
    counts = slam.counts
    assert counts["came"] == 300 and counts["dropped"] == displaced > 0
    assert counts["came"] == counts["taken"] + counts["dropped"] + counts["waiting"]
    slam.finish()
    with pytest.raises(chasles.UsageError, match="after finish"):
        slam.add_images(int(k[-1]), images.images(-1))


def test_other_images_are_rejected_at_once(images):
    slam = chasles.RealtimeSlam(images.cameras, images.imu_noise)
    with pytest.raises(chasles.InputError, match="image"):
        slam.add_images(0, [numpy.zeros((3, 4), numpy.uint8)])
    with pytest.raises(chasles.UsageError, match="chart"):
        chasles.RealtimeSlam(images.cameras, images.imu_noise, chart="nope")


class Additive:
    """A chart of the additive errors, whose next call runs `then`, if there is one."""

    then = None

    def retract(self, x, xi, dpoints):
        K = numpy.array([[0, -xi[2], xi[1]], [xi[2], 0, -xi[0]], [-xi[1], xi[0], 0]])
        n = numpy.linalg.norm(xi[:3]) or 1e-12
        R = numpy.eye(3) + numpy.sin(n) / n * K + (1 - numpy.cos(n)) / n**2 * K @ K
        return chasles.ChartState(R @ x.R, x.p + xi[3:6], x.v + xi[6:], x.points + dpoints)

    def local(self, x, y):
        R = y.R @ x.R.T
        v = numpy.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
        s = numpy.linalg.norm(v)
        theta = v if s < 1e-12 else v * numpy.arctan2(s, (numpy.trace(R) - 1) / 2) / s
        return numpy.concatenate([theta, y.p - x.p, y.v - x.v]), y.points - x.points

    def motion_block(self, x):
        if self.then:
            self.then()
        return numpy.eye(9)


def with_chart(images, then=None, **arguments):
    """A RealtimeSlam with all events, whose chart calls `then` while it works."""
    chart = Additive()
    chasles.register_chart("additive", chart)
    slam = chasles.RealtimeSlam(images.cameras, images.imu_noise, most_images=0, chart="additive", keep_scale=False, **arguments)
    chart.then = then
    return slam


def test_it_may_end_while_a_chart_in_python_works(images):
    slam = with_chart(images)
    play(slam, images)
    del slam  # joins the thread


def test_an_error_of_a_chart_comes_with_each_call(images):
    def fail():
        raise ZeroDivisionError("mine")

    slam = with_chart(images, fail)
    with pytest.raises(ZeroDivisionError, match="mine"):
        play(slam, images)
        slam.finish()
    for call in (slam.finish, slam.finish, lambda: slam.landmarks, lambda: slam.add_imu(0, [0, 0, 0], [0, 0, 0])):
        with pytest.raises(ZeroDivisionError, match="mine"):
            call()


@pytest.mark.parametrize("use", [lambda slam: slam.landmarks, lambda slam: slam.why_not_started, lambda slam: slam.finish()])
def test_a_chart_that_asks_the_estimator_does_not_wait_for_ever(images, use):
    slam = with_chart(images, lambda: use(slam))
    with pytest.raises(chasles.UsageError, match="would wait for itself for ever"):
        play(slam, images)
        slam.finish()


def test_a_chart_may_have_the_last_reference(images):
    played, ended = threading.Event(), threading.Event()

    def drop():
        played.wait(60)
        slams.clear()
        ended.set()

    slams = [with_chart(images, drop)]
    play(*slams, images)
    played.set()
    assert ended.wait(60) and not slams
    assert len(chasles.run(images, chart="right-sen3").states["time"]) > 10  # no turn is left taken


def test_ctrl_c_ends_the_wait_for_a_slow_estimator(images):
    done = threading.Event()
    slam = with_chart(images, lambda: done.wait(60))
    play(slam, images)
    threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        slam.finish()
    assert time.monotonic() - begin < 30 and slam.counts["waiting"] > 0
    done.set()
