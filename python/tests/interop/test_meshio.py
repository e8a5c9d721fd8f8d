"""Clouds of points that meshio reads."""

import meshio
import numpy
import pytest

import chasles


def test_meshio_reads_a_cloud_without_lines(tmp_path, capfd):
    run = chasles.run(chasles.simulate("hallway", sections=1, hall_length=8))
    run.save(tmp_path / "run")
    assert chasles.command("export", tmp_path / "run", "-o", tmp_path / "run.ply", "--points", "--quiet") == 0
    cloud = meshio.read(tmp_path / "run.ply")
    n = len(run.landmarks["id"])
    assert cloud.points[:n] == pytest.approx(run.landmarks["position"], abs=1e-5)
    assert cloud.points[n:n + len(run.states["time"])] == pytest.approx(run.states["position"], abs=1e-5)
    assert numpy.array_equal(cloud.point_data["landmark"][:n], run.landmarks["id"])
