"""The examples run as they are."""

import ast
import os
import pathlib
import re
import subprocess
import sys

import pytest

import chasles

EXAMPLES = pathlib.Path(__file__).resolve().parents[1] / "examples"
WALK = ["sections=1", "hall_length=8", "image_width=320", "image_height=240", "focal_length=180", "center_u=160", "center_v=120", "frame_rate=10"]


@pytest.fixture(scope="module")
def walk(tmp_path_factory):
    folder = tmp_path_factory.mktemp("examples") / "walk"
    sets = [word for setting in WALK for word in ("--set", setting)]
    assert chasles.command("simulate", "hallway", "--images", *sets, "-o", folder, "--quiet") == 0
    return folder


def example(*arguments):
    return subprocess.run([sys.executable, EXAMPLES / "webcam_and_imu.py", *arguments], timeout=120, capture_output=True, text=True)


def test_a_recording_is_played_in_real_time(walk):
    done = example("--play", walk, "--speed", "2", "--stop", "8")
    assert done.returncode == 0, done.stderr
    *lines, last = done.stdout.splitlines()
    assert len(lines) > 20 and all(re.search(r"\+- \d+\.\d{3} m  (ok|degraded)  \d+ ms old, \d+ dropped", line) for line in lines)
    found = re.fullmatch(r"(\d+) estimates of (\d+) images, (\d+) dropped; age of an estimate: median (\d+) ms, .*", last)
    assert found and int(found[1]) == len(lines) and int(found[1]) + int(found[3]) <= int(found[2])


def test_too_fast_a_recording_drops_images_and_says_so(walk):
    done = example("--play", walk, "--speed", "200", "--most-images", "1")
    counted = re.search(r"of (\d+) images, (\d+) dropped", done.stdout + done.stderr)
    assert counted, done.stderr
    assert int(counted[2]) > 10


def test_bad_input_says_what_was_expected(tmp_path):
    assert "expected --play RECORDING, or --calibration FILE" in example().stderr
    assert "no such" in example("--play", tmp_path / "nothing").stderr.lower()


def lines_of_code(program):
    """Without the docstring, imports, comments and empty lines."""
    text = program.read_text()
    docstring, *statements = ast.parse(text).body
    apart = [docstring, *(one for one in statements if isinstance(one, (ast.Import, ast.ImportFrom)))]
    left_out = {number for one in apart for number in range(one.lineno, one.end_lineno + 1)}
    return [line for number, line in enumerate(text.splitlines(), 1)
            if number not in left_out and line.strip() and not line.strip().startswith("#")]


@pytest.mark.parametrize("name", ["aria_to_chasles.py", "stray_scanner_to_chasles.py"])
def test_a_conversion_is_a_program_of_thirty_lines(name):
    lines = lines_of_code(EXAMPLES / name)
    assert 10 < len(lines) <= 30 and max(map(len, lines)) <= 120


FEED = pathlib.Path(os.environ.get("CHASLES_BINARY", "/none")).with_name("feed_from_stdin")


def sensors(recording):
    """The recording as the program reads it, in the order of time."""
    imu, frames = recording.imu, recording.frame_times
    k = 0
    for i, stamp in enumerate(imu["time"]):
        values = " ".join(repr(float(x)) for x in (*imu["angular_rate"][i], *imu["specific_force"][i]))
        yield f"imu {stamp} {values}\n".encode()
        while k < len(frames) and frames[k] <= stamp:
            yield f"images {frames[k]}\n".encode() + b"".join(image.tobytes() for image in recording.images(k))
            k += 1


def feed(*arguments, data):
    return subprocess.run([FEED, *arguments], input=b"".join(data), timeout=120, capture_output=True)


@pytest.mark.skipif(not FEED.exists(), reason="feed_from_stdin is not built")
def test_the_program_fed_by_a_pipe_has_the_estimates_of_the_library(walk):
    recording = chasles.read(walk)
    done = feed(walk, "--wait", data=sensors(recording))
    assert done.returncode == 0, done.stderr
    lines = [list(map(float, line.split())) for line in done.stdout.decode().splitlines()]
    expected = chasles.run(recording, exact_map=False).states
    assert len(lines) == len(expected["time"])
    for line, position in zip(lines, expected["position"]):
        assert line[1:4] == pytest.approx(position, abs=6e-4)
        assert line[4] >= 0 and line[5] >= 0 and line[6] == 0
    assert lines[0][4] < lines[-1][4] < 0.1
    assert f"{len(lines)} estimates of {len(recording)} images, 0 dropped" in done.stderr.decode()
    # All at once is faster than any estimator: images are dropped, and counted.
    hasty = feed(walk, data=sensors(recording)).stderr.decode()
    found = re.search(r"(\d+) estimates of (\d+) images, (\d+) dropped", hasty)
    assert int(found[2]) == len(recording) and int(found[3]) > 10


@pytest.mark.skipif(not FEED.exists(), reason="feed_from_stdin is not built")
def test_the_program_says_what_it_cannot_read(walk):
    for data, message in [(b"imu 5 1 2\n", "item 1: found 'imu 5 1 2', expected imu TIME"),
                          (b"gps 5\n", "found 'gps 5'"), (b"images 7\nabc", "ends within an image"),
                          (b"", "0 estimates of 0 images")]:
        done = feed(walk, data=[data])
        assert done.returncode == 1 and message in done.stderr.decode(), done.stderr
    assert feed(data=[]).returncode == 2
    assert "feed_from_stdin: /nothing" in feed("/nothing", data=[]).stderr.decode()
