"""Ctrl-C ends every long call soon, and processes that are forks either work or say why not."""

import multiprocessing
import os
import signal
import subprocess
import sys
import textwrap
import threading
import time

import pytest

import chasles

SOON = 3.0  # [s]: 1 s on a machine with nothing else to do
IMAGES = ("image_width=320, image_height=240, focal_length=180, center_u=160, center_v=120, frame_rate=10, sections=1, "
          "hall_length=12")
PREPARE = f"recording = chasles.simulate('hallway', images=True, {IMAGES})"
LONG_BATCH = """recording = chasles.simulate('hallway', images=True, image_width=320, image_height=240, focal_length=180,
                             center_u=160, center_v=120, frame_rate=20, sections=2, hall_length=30)
slam = chasles.{kind}(recording.cameras, recording.imu_noise, estimator='batch'{more})
imu = recording.imu
slam.add_imu(imu['time'], imu['angular_rate'], imu['specific_force'])
for i, when in enumerate(recording.frame_times):
    slam.add_images(int(when), recording.images(i))
"""


def seconds_to_end(folder, prepare, call, after):
    """Of a process that works in this folder and gets SIGINT so many seconds after the call began."""
    program = textwrap.dedent("""
        import sys, chasles
        {prepare}
        print("begin", flush=True)
        try:
            {call}
        except KeyboardInterrupt:
            print("interrupted", flush=True)
        else:
            print("finished", flush=True)
    """).format(prepare=prepare, call=call)
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True, cwd=folder)
    try:
        assert process.stdout.readline() == "begin\n"
        time.sleep(after)
        begin = time.monotonic()
        process.send_signal(signal.SIGINT)
        said = next(line for line in process.stdout if line in ("interrupted\n", "finished\n"))
        return said.strip(), time.monotonic() - begin
    finally:
        process.kill()
        process.wait()


@pytest.mark.parametrize("prepare, call, after", [
    ("", "chasles.simulate('walk', images=True)", 0.5),
    ("", "chasles.simulate('hallway', images=True)", 0.3),
    ("", "chasles.monte_carlo('hallway', {'a': {}, 'b': {'chart': 'standard'}}, runs=50)", 0.7),
    ("", "chasles.monte_carlo('hallway', {'a': {'estimator': 'batch'}}, runs=50)", 1.5),
    ("", "chasles.monte_carlo('hallway', {'a': {'estimator': 'window:20'}}, runs=50)", 1.0),
    ("", "chasles.monte_carlo('hallway', {'a': {}, 'b': {}}, runs=50, workers=2)", 0.7),
    ("recording = chasles.simulate('hallway', hall_length=60)", "chasles.run(recording, estimator='batch')", 2.0),
    ("recording = chasles.simulate('hallway', images=True)", "chasles.check(recording)", 0.7),
    ("", "chasles.command('simulate', 'walk', '--images', '-o', 'out')", 0.5),
    ("chasles.command('simulate', 'hallway', '-o', 'scene', '--set', 'hall_length=60', '--quiet')",
     "chasles.command('run', 'scene', '-o', 'out', '--quiet', '--estimator', 'window:30')", 0.3),
    ("chasles.command('simulate', 'hallway', '-o', 'scene', '--images', '--quiet', '--set', 'sections=1')",
     "chasles.command('check', 'scene')", 0.5),
], ids=["walk", "images", "monte-carlo", "batches", "windows", "workers", "run", "check", "command", "command-run",
        "command-check"])
def test_ctrl_c_ends_it_soon(tmp_path, prepare, call, after):
    said, seconds = seconds_to_end(tmp_path, prepare, call, after)
    if said == "finished":
        pytest.skip("it was over before")
    assert said == "interrupted" and seconds < SOON


def test_ctrl_c_ends_reading(tmp_path):
    folder = tmp_path / "walk"
    assert chasles.command("simulate", "hallway", "--set", "sections=1", "--set", "hall_length=6", "-o", folder, "--quiet") == 0
    table = folder / "imu.csv"
    head = table.read_text().splitlines()[:1]
    rest = "0.01,0,0,0,0,9.81"
    with open(table, "w") as file:  # hours of samples
        file.write("\n".join(head) + "\n")
        for begin in range(0, 6_000_000, 100_000):
            file.write("".join(f"{1000 * i},{rest}\n" for i in range(begin, begin + 100_000)))
    said, seconds = seconds_to_end(tmp_path, "", f"chasles.read({str(folder)!r})", 0.3)
    assert said == "interrupted" and seconds < SOON


@pytest.mark.parametrize("kind, more", [("Slam", ""), ("RealtimeSlam", ", most_images=0")])
def test_ctrl_c_ends_the_last_smoothing(tmp_path, kind, more):
    prepare = LONG_BATCH.format(kind=kind, more=more)
    said, seconds = seconds_to_end(tmp_path, prepare, "slam.finish()", 1.0)
    if said == "finished":
        pytest.skip("it was over before")
    assert said == "interrupted" and seconds < SOON


def test_after_an_interruption_the_next_call_works():
    threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        chasles.monte_carlo("hallway", {"a": {}}, runs=200)
    study = chasles.monte_carlo("hallway", {"a": {}}, runs=1, sections=1, hall_length=8)
    assert study.summary["runs"] == 1


def test_slam_takes_nothing_after_finish():
    recording = chasles.simulate("hallway", images=True, image_width=320, image_height=240, focal_length=180, center_u=160,
                                 center_v=120, frame_rate=10, sections=1, hall_length=4)
    for slam in (chasles.Slam(recording.cameras, recording.imu_noise), chasles.RealtimeSlam(recording.cameras, recording.imu_noise)):
        slam.finish()
        with pytest.raises(chasles.UsageError, match="expected no sample after finish"):
            slam.add_imu(1, [0, 0, 0], [0, 0, 9.81])
        with pytest.raises(chasles.UsageError, match="expected no images after finish"):
            slam.add_images(1, recording.images(0))


# In the forks. Each says what it got, or the error.
def in_a_fork(work, seconds=60):
    context = multiprocessing.get_context("fork")
    receive, send = context.Pipe(duplex=False)

    def report():
        try:
            send.send(("done", work()))
        except Exception as error:
            send.send((type(error).__name__, str(error)))

    process = context.Process(target=report)
    process.start()
    try:
        assert receive.poll(seconds), "the fork hangs"
        answer = receive.recv()
        process.join(seconds)
        assert process.exitcode == 0, "the fork does not end"
        return answer
    finally:
        process.kill()


@pytest.fixture(scope="module")
def walk():
    return chasles.simulate("hallway", sections=1, hall_length=12)


def test_a_fork_works_where_nothing_works_in_its_parent(walk):
    expected = chasles.run(walk).states["position"].tolist()
    assert in_a_fork(lambda: chasles.run(walk).states["position"].tolist()) == ("done", expected)
    assert chasles.run(walk).states["position"].tolist() == expected  # the parent goes on


def test_a_fork_during_a_run_says_spawn(walk):
    long = chasles.simulate("hallway", hall_length=60)
    done = []
    thread = threading.Thread(target=lambda: done.append(chasles.run(long)))
    thread.start()
    time.sleep(0.3)
    assert not done
    try:
        name, text = in_a_fork(lambda: len(chasles.run(walk).states["time"]))
        assert name == "UsageError" and "spawn" in text
        assert in_a_fork(lambda: len(walk.frame_times)) == ("done", len(walk))  # what needs no estimator works
    finally:
        thread.join()
    assert in_a_fork(lambda: len(chasles.run(walk).states["time"]))[0] == "done"


def test_a_fork_of_a_realtime_slam_says_spawn(walk):
    slam = chasles.RealtimeSlam(walk.cameras, walk.imu_noise)
    slam.add_imu(0, [0, 0, 0], [0, 0, 9.81])
    slam.landmarks  # its thread has nothing to do
    for use in (lambda: slam.add_imu(1, [0, 0, 0], [0, 0, 9.81]), lambda: slam.finish(), lambda: slam.landmarks,
                lambda: slam.counts, lambda: slam.predicted(1), lambda: slam.take()):
        name, text = in_a_fork(use)
        assert name == "UsageError" and "spawn" in text
    assert in_a_fork(lambda: len(chasles.run(walk).states["time"]))[0] == "done"  # another estimator works
    assert slam.finish() == []  # the parent's goes on


def test_a_pool_of_forks_reads_one_recording(tmp_path):
    folder = tmp_path / "walk"
    assert chasles.command("simulate", "hallway", "--images", *(word for one in IMAGES.split(", ") for word in ("--set", one)),
                           "-o", folder, "--quiet") == 0
    recording = chasles.read(folder)
    expected = [int(recording.images(i)[0].sum()) for i in range(12)]
    global pool_of
    pool_of = recording
    with multiprocessing.get_context("fork").Pool(3) as pool:
        assert pool.map(image_sum, range(12), chunksize=1) == expected


pool_of = None


def image_sum(i):
    return int(pool_of.images(i)[0].sum())
