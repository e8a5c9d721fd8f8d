"""Interoperation without the other packages, which python/tests/interop needs: alignments, the problem of batch estimation
and the errors."""

import sys

import numpy as np
import pytest

import chasles
from chasles import interop


@pytest.fixture(scope="module")
def batch():
    return chasles.run(chasles.simulate("turntable", revolutions=0.1, cameras=2), estimator="batch")


def test_a_known_transformation_is_found(batch):
    truth = batch.truth
    angle, scale, p = 0.7, 1.1, np.array([1.0, -2, 3])
    R = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    moved = {"time": truth["time"], "position": (truth["position"] - p) @ R / scale}
    found = interop.align(moved, truth, "Sim(3)")
    assert found["scale"] == pytest.approx(scale) and found["rank"] == 2
    assert np.allclose(found["truth_T_estimate"][:3, :3], R) and np.allclose(found["truth_T_estimate"][:3, 3], p)
    assert found["ate_m"] < 1e-9 and found["matched"] == len(truth["time"])
    assert interop.align(moved, truth, "SE(3)")["ate_m"] > 1e-2


def test_alignments_are_those_of_evaluate(batch):
    figures = batch.evaluate()
    for alignment, name in (("SE(3)", "ate_m"), ("position + yaw", "ate_posyaw_m"), ("first pose", "ate_first_pose_m")):
        assert interop.align(batch, batch.truth, alignment)["ate_m"] == figures[name]


def test_the_problem_has_the_pixels_and_states_of_the_run(batch):
    problem = interop.batch_problem(batch)
    summary = batch.summary["batch"]
    assert len(problem["views"]["sigma"]) == summary["observations"]
    assert problem["cost"] == pytest.approx(summary["final_cost"])
    assert problem["loss"] == "huber" and problem["loss_width"] == summary["loss_width"]
    keyframes = problem["keyframes"]
    assert np.array_equal(keyframes["position"], batch.states["position"])
    assert np.array_equal(problem["landmarks"]["position"], batch.landmarks["position"])
    samples = problem["samples"]
    for k in range(len(keyframes["time"]) - 1):
        tau = samples["tau"][samples["keyframe"] == k].sum()
        assert tau == pytest.approx((keyframes["time"][k + 1] - keyframes["time"][k]) / 1e9, abs=1e-9)


def test_the_landmarks_project_to_the_pixels(batch):
    """With the keyframes' poses and the cameras: residuals as large as stated."""
    problem = interop.batch_problem(batch)
    views, keyframes = problem["views"], problem["keyframes"]
    p = problem["landmarks"]["position"][views["landmark"]] - keyframes["position"][views["keyframe"]]
    x, y, z, w = keyframes["quaternion"][views["keyframe"]].T
    u = np.stack([-x, -y, -z], 1)  # the inverse rotation
    p = p + 2 * np.cross(u, np.cross(u, p) + w[:, None] * p)
    for c, camera in enumerate(problem["cameras"]):
        of = views["camera"] == c
        q = p[of] @ camera.cam_T_imu[:3, :3].T + camera.cam_T_imu[:3, 3]
        pixels = q[:, :2] / q[:, 2:] * [camera.fx, camera.fy] + [camera.cx, camera.cy]
        residuals = (pixels - views["pixel"][of]) / views["sigma"][of, None]
        assert of.sum() > 100 and 0.7 < np.sqrt(np.mean(residuals**2)) < 1.2


def test_runs_without_a_problem(batch, tmp_path):
    batch.save(tmp_path / "run")
    for run in (chasles.read_run(tmp_path / "run"), chasles.run(chasles.simulate("hallway", sections=1, hall_length=8))):
        with pytest.raises(chasles.UsageError, match="a run of this process, of a recording with an IMU"):
            interop.batch_problem(run)
    with pytest.raises(chasles.UsageError, match="part: found 3, expected 0 to 0"):
        interop.batch_problem(batch, 3)


@pytest.mark.parametrize("package, named, call", [
    ("evo", "evo", lambda run: interop.to_evo(run)), ("gtsam", "'gtsam>=4.3'", lambda run: interop.gtsam_graph(run)),
    ("rerun", "rerun-sdk", lambda run: interop.log_to_rerun(run))])
def test_a_missing_package_is_named_as_the_index_has_it(package, named, call, batch, monkeypatch):
    for name in [name for name in sys.modules if name.partition(".")[0] == package]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, package, None)  # as if it were not installed
    with pytest.raises(ImportError, match=f"pip install {named}$") as raised:
        call(batch)
    assert raised.value.name.partition(".")[0] == package


def test_an_old_gtsam_is_named(batch, monkeypatch):
    import types

    monkeypatch.setitem(sys.modules, "gtsam", types.ModuleType("gtsam"))
    with pytest.raises(ImportError, match="expected 4.3 or later"):
        interop.gtsam_graph(batch)


def test_wrong_arguments(batch):
    with pytest.raises(chasles.UsageError, match="alignment: found 'se3', expected one of 'none', .*'SE\\(3\\)'"):
        interop.align(batch, batch.truth, "se3")
    with pytest.raises(chasles.UsageError, match="estimate: found columns time; .* position is missing"):
        interop.align({"time": [0]}, batch.truth)
    with pytest.raises(chasles.UsageError, match="every: found 0, expected 1 or more"):
        interop.log_to_rerun(batch, every=0)
