"""A program ends in order while a thread of it is in a call."""

import subprocess
import sys
import textwrap
import time

import pytest

import chasles

IMAGES = {"image_width": 320, "image_height": 240, "focal_length": 180, "center_u": 160, "center_v": 120, "frame_rate": 20,
          "sections": 2, "hall_length": 30}
ARRAYS = """
imu = recording.imu
recording = chasles.Recording.from_arrays(
    imu_time=imu["time"], angular_rate=imu["angular_rate"], specific_force=imu["specific_force"],
    image_time=recording.frame_times, images=recording.images, cameras=recording.cameras, imu_noise=recording.imu_noise)
"""
SLAM = """
def feed(slam):
    imu = recording.imu
    slam.add_imu(imu["time"], imu["angular_rate"], imu["specific_force"])
    for i, when in enumerate(recording.frame_times):
        slam.add_images(int(when), recording.images(i))
"""
CHART = """
import numpy
class Slow:
    def retract(self, x, xi, points):
        sum(range(2000))
        return chasles.ChartState(numpy.eye(3) @ x.R, x.p + xi[3:6], x.v + xi[6:], x.points + points)
    def local(self, x, y):
        return numpy.concatenate([numpy.zeros(3), y.p - x.p, y.v - x.v]), y.points - x.points
    def motion_block(self, x):
        return numpy.eye(9)
from chasles import _core
try:
    _core.register_chart("slow", Slow())
except chasles.UsageError:
    pass
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("exit") / "walk"
    sets = [word for name, value in IMAGES.items() for word in ("--set", f"{name}={value}")]
    assert chasles.command("simulate", "hallway", "--images", *sets, "-o", folder, "--quiet") == 0
    return folder


def ends_in_order(folder, prepare, call, last="", timeout=60):
    """Seconds from the end of the program, a thread of which is in the call, to that of its process."""
    program = "\n".join((
        "import sys, threading, time, chasles", prepare, "def work():", "    try:", f"        {call}", "    finally:",
        "        print('came back', flush=True)", "threading.Thread(target=work, daemon=True).start()", "time.sleep(.4)",
        last, "print('end', time.monotonic(), flush=True)"))
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=folder.parent, timeout=timeout)
    now = time.monotonic()
    assert done.returncode == 0 and done.stderr == "", (done.returncode, done.stderr)
    lines = done.stdout.split()
    assert lines[0] == "end", "the call was over before"
    return now - float(lines[1])


READ = "recording = chasles.read('walk')"


@pytest.mark.parametrize("prepare, call", [
    (READ, "chasles.run(recording)"),
    ("recording = chasles.simulate('hallway', hall_length=60)", "chasles.run(recording, estimator='batch')"),
    (READ, "chasles.check(recording)"),
    ("", "chasles.simulate('walk', images=True)"),
    ("", "chasles.monte_carlo('hallway', {'a': {}}, runs=50)"),
    ("", "chasles.monte_carlo('hallway', {'a': {}}, runs=50, workers=2)"),
    (READ + ARRAYS, "chasles.run(recording)"),
    ("", "[chasles.read('walk') for _ in iter(int, 1)]"),
    (READ + SLAM, "[feed(chasles.Slam(recording.cameras, recording.imu_noise)) for _ in iter(int, 1)]"),
    (READ + SLAM, "[feed(chasles.RealtimeSlam(recording.cameras, recording.imu_noise)) for _ in iter(int, 1)]"),
    ("", "chasles.command('simulate', 'walk', '--images', '-o', 'out')"),
], ids=["run", "batch", "check", "simulate", "monte-carlo", "workers", "arrays", "reads", "slam", "realtime", "command"])
def test_a_thread_in_a_call_does_not_abort_the_exit(folder, prepare, call):
    assert ends_in_order(folder, prepare, call) < 3.0


def test_a_chart_of_python_in_a_realtime_slam_does_not_abort_the_exit(folder):
    prepare = READ + SLAM + CHART
    last = "slam = chasles.RealtimeSlam(recording.cameras, recording.imu_noise, most_images=0); feed(slam)"
    assert ends_in_order(folder, prepare, "time.sleep(60)", last) < 3.0


def test_an_exit_after_an_interruption_is_in_order(folder):
    last = """
import os, signal
threading.Timer(.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
try:
    chasles.simulate("walk", images=True)
except KeyboardInterrupt:
    pass
"""
    assert ends_in_order(folder, READ + "\n", "chasles.run(recording)", last) < 3.0


def test_a_function_of_atexit_may_join_a_thread_in_a_call(folder):
    program = textwrap.dedent("""
        import atexit, threading, time
        atexit.register(lambda: (thread.join(), print("joined", flush=True)))  # before the module's own
        import chasles
        thread = threading.Thread(target=lambda: [chasles.run("walk") for _ in iter(int, 1)], daemon=True)
        thread.start()
        time.sleep(.4)
    """)
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=folder.parent, timeout=30)
    assert (done.returncode, done.stdout, done.stderr) == (0, "joined\n", "")


def test_the_end_waits_for_a_callback_at_most_five_seconds(folder):
    prepare = READ + ARRAYS.replace("images=recording.images", "images=lambda i: threading.Event().wait()")
    assert ends_in_order(folder, prepare, "chasles.run(recording)") < 7.0


def test_a_thread_that_is_waited_for_ends_its_call(folder):
    program = ("import threading, chasles; w = chasles.simulate('hallway', sections=1, hall_length=12); "
               "threading.Thread(target=lambda: print(len(chasles.run(w).states['time']))).start()")
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0 and int(done.stdout) > 50 and done.stderr == ""


def test_functions_of_atexit_may_call(folder):
    program = textwrap.dedent("""
        import atexit
        def last():
            import chasles
            recording = chasles.read("walk", stop=2)
            imu = recording.imu
            made = chasles.Recording.from_arrays(
                imu_time=imu["time"], angular_rate=imu["angular_rate"], specific_force=imu["specific_force"],
                image_time=recording.frame_times, images=recording.images, cameras=recording.cameras,
                imu_noise=recording.imu_noise)
            print(len(chasles.run(made).states["time"]))
        atexit.register(last)
        import chasles
    """)
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=folder.parent, timeout=60)
    assert done.returncode == 0 and int(done.stdout) > 10, done.stderr
