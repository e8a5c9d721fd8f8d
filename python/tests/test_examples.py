"""The examples run as they are."""

import os
import pathlib
import re
import socket
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
    counted = re.search(r"of (\d+) images(?:, (\d+) dropped)?", done.stdout + done.stderr)
    assert counted, done.stderr
    if done.returncode == 0:
        assert int(counted[2]) > 10


def test_bad_input_says_what_was_expected(tmp_path):
    assert "expected --play RECORDING, or --calibration FILE" in example().stderr
    assert "no such" in example("--play", tmp_path / "nothing").stderr.lower()
