"""Runs with body velocities instead of an IMU, against the simulator's truth and the command."""

import os
import subprocess

import numpy
import pytest

import chasles

BINARY = os.environ.get("CHASLES_BINARY")


@pytest.fixture(scope="module")
def drive():
    return chasles.simulate("street")


def test_a_drive_agrees_with_the_truth(drive):
    run = chasles.run(drive, chart="right-sen3")
    assert run.summary["chart"] == "right-sen3" and run.summary["ate_m"] < 2
    figures = run.evaluate()
    assert figures["ate_m"] == pytest.approx(run.summary["ate_m"], rel=1e-9)
    assert figures["nees_pose"] == pytest.approx(run.summary["nees_pose"], rel=1e-9)
    assert 0.3 < figures["nees_pose"] / 6 < 3  # 3.9 to 8.8 with three seeds
    assert len(run.smoothed["time"]) == len(run.states["time"]) == len(drive)
    assert drive.tracks(0)["pixel"].shape[1] == 4  # of a rectified pair
    assert "velocity" in chasles.settings("velocity")["velocity_sigma"]["meaning"]


@pytest.mark.skipif(BINARY is None, reason="CHASLES_BINARY names no command")
def test_its_files_are_those_of_the_command(drive, tmp_path):
    subprocess.run([BINARY, "simulate", "street", "-o", tmp_path / "street", "--quiet"], check=True, timeout=60)
    subprocess.run([BINARY, "run", tmp_path / "street", "--set", "gate=0.99", "-o", tmp_path / "command", "--quiet"], check=True, timeout=60)
    chasles.run(tmp_path / "street", gate=0.99).save(tmp_path / "python")
    for name in ("states.csv", "landmarks.csv", "trajectory.tum"):
        assert (tmp_path / "python" / name).read_bytes() == (tmp_path / "command" / name).read_bytes(), name


def test_settings_of_the_other_kind_are_rejected(drive):
    with pytest.raises(chasles.UsageError, match="vibration_noise"):
        chasles.run(drive, vibration_noise=1)
    with pytest.raises(chasles.UsageError, match="images and run are for scenes with an IMU"):
        chasles.simulate("street", images=True)
    assert numpy.isfinite(chasles.run(drive, estimator="window:10").summary["ate_m"])


def test_settings_of_the_reader_are_for_a_path(drive, tmp_path):
    assert chasles.command("simulate", "street", "-o", tmp_path / "street", "--quiet") == 0
    run = chasles.run(tmp_path / "street", reader={"stale_pixels": "keep"})
    assert run.summary["settings"]["reader.stale_pixels"] == "keep"
    with pytest.raises(chasles.UsageError, match="expected its path, as in chasles.run"):
        chasles.run(drive, reader={"stale_pixels": "keep"})
