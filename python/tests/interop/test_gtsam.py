"""The problem of batch estimation in gtsam: the same cost, the same minimum, the same covariance."""

import gtsam
import numpy as np
import pytest
from gtsam.symbol_shorthand import B, L, V, X

import chasles
from chasles.interop import batch_problem, gtsam_graph

# Plain least squares, to the last digit.
PLAIN = {"loss": "none", "gate": 0, "tolerance": 1e-13, "covariance_factor": 1}


def flight(batch=PLAIN, **scene):
    recording = chasles.simulate("turntable", revolutions=0.15, **scene)
    return chasles.run(recording, estimator="batch", batch=batch)


@pytest.fixture(scope="module")
def plain():
    return flight()


def minimum(graph, values):
    params = gtsam.LevenbergMarquardtParams()
    params.setRelativeErrorTol(1e-13)
    params.setAbsoluteErrorTol(1e-9)
    params.setMaxIterations(200)
    return gtsam.LevenbergMarquardtOptimizer(graph, values, params).optimize()


def keyframe_differences(values, others, count):
    """[theta; dp] in world axes, of all keyframes."""
    rows = []
    for k in range(count):
        a, b = values.atPose3(X(k)), others.atPose3(X(k))
        theta = gtsam.Rot3.Logmap(a.rotation().compose(b.rotation().inverse()))
        rows.append(np.concatenate([theta, a.translation() - b.translation()]))
    return np.array(rows)


def moved_sigmas(run, values, others):
    """The largest difference, in the run's own standard deviations."""
    sigma = np.sqrt(np.diagonal(run.states["pose_covariance"], axis1=1, axis2=2))
    return np.max(np.abs(keyframe_differences(values, others, len(sigma))) / sigma)


def check_same(run, cost_tolerance, sigma_tolerance):
    graph, values = gtsam_graph(run)
    problem = batch_problem(run)
    assert graph.error(values) == pytest.approx(problem["cost"], rel=cost_tolerance)
    found = minimum(graph, values)
    assert graph.error(found) <= graph.error(values)
    moved = moved_sigmas(run, values, found)
    print(f"cost {graph.error(values) / problem['cost'] - 1:.2e}, moved {moved:.2e} sigma")
    assert moved < sigma_tolerance
    return graph, values, found


def test_the_graph_has_all_terms(plain):
    graph, values = gtsam_graph(plain)
    problem = batch_problem(plain)
    keyframes, views = len(problem["keyframes"]["time"]), len(problem["views"]["sigma"])
    assert graph.size() == 1 + (keyframes - 1) + views + len(problem["landmarks"]["id"])
    assert values.size() == 3 * keyframes + len(problem["landmarks"]["id"])
    assert np.allclose(values.atPose3(X(3)).translation(), plain.states["position"][3], atol=1e-12)
    assert np.allclose(values.atVector(V(3)), problem["keyframes"]["velocity"][3])
    assert np.allclose(values.atPoint3(L(0)), plain.landmarks["position"][0], atol=1e-9)


def test_cost_and_minimum_are_the_same(plain):
    check_same(plain, 1e-8, 1e-4)


def test_from_a_perturbed_start_gtsam_finds_the_minimum(plain):
    graph, values = gtsam_graph(plain)
    random = np.random.default_rng(5)
    start = gtsam.Values(values)
    for k in range(1, len(plain.states["time"])):
        start.update(X(k), values.atPose3(X(k)).retract(random.normal(0, [0.01] * 3 + [0.03] * 3)))
        start.update(V(k), values.atVector(V(k)) + random.normal(0, 0.05, 3))
        start.update(B(k), values.atConstantBias(B(k)).retract(random.normal(0, [0.02] * 3 + [0.002] * 3)))
    for i in range(len(plain.landmarks["id"])):
        start.update(L(i), values.atPoint3(L(i)) + random.normal(0, 0.02, 3))
    assert graph.error(start) > 100 * graph.error(values)
    found = minimum(graph, start)
    assert moved_sigmas(plain, values, found) < 1e-4


def test_covariances_are_the_same(plain):
    graph, values = gtsam_graph(plain)
    marginals = gtsam.Marginals(graph, values)
    for k in range(5, len(plain.states["time"]), 10):
        R = values.atPose3(X(k)).rotation().matrix()
        to_world = np.kron(np.eye(2), R)
        theirs = to_world @ marginals.marginalCovariance(X(k)) @ to_world.T
        ours = plain.states["pose_covariance"][k]
        unit = np.sqrt(np.outer(np.diag(ours), np.diag(ours)))
        assert np.abs((theirs - ours) / unit).max() < 1e-4


def test_the_defaults_with_loss_and_gate():
    check_same(flight(batch={"tolerance": 1e-13}), 1e-8, 1e-4)


def test_the_prior_of_the_inverse_depths_moves_both_minima_alike():
    """With a sigma that pulls the landmarks away."""
    run = flight(batch={**PLAIN, "inverse_depth_sigma": 0.05})
    problem = batch_problem(run)
    assert problem["inverse_depth_cost"] > 0.02 * problem["cost"]
    check_same(run, 1e-8, 1e-4)


def test_the_factor_of_the_covariance_is_not_in_the_graph(plain):
    wide = flight({**PLAIN, "covariance_factor": 4})
    assert np.allclose(wide.states["pose_covariance"], 4 * plain.states["pose_covariance"], rtol=1e-12)
    assert wide.summary["batch"]["covariance_factor"] == 4
    assert batch_problem(wide)["cost"] == batch_problem(plain)["cost"]


def test_cauchys_loss():
    check_same(flight(batch={**PLAIN, "loss": "cauchy", "loss_width": 1}), 1e-8, 1e-4)


def test_landmarks_as_points():
    check_same(flight(batch={**PLAIN, "landmarks": "cartesian"}), 1e-8, 1e-4)


def test_a_lens_that_gtsam_does_not_have(plain, monkeypatch):
    for model, coefficients, says in (("radtan", [0.1, 0, 0, 0, 0.01], "radtan lens with k3 = 0.01; gtsam's Cal3DS2"),
                                      ("radtan", [0.1, 0, 0, 0, 0, 0.1, 0, 0], "radtan lens with 8 coefficients"),
                                      ("ds", [-0.2, 0.6], "found the lens model ds; expected none, radtan")):
        lens = chasles.Camera(640, 480, 400, 400, 320, 240, model, coefficients)
        problem = {**batch_problem(plain), "cameras": [lens]}
        monkeypatch.setattr("chasles._gtsam.batch_problem", lambda run, part: problem)
        with pytest.raises(chasles.UsageError, match=says):
            gtsam_graph(plain)
    rolling = chasles.Camera(640, 480, 400, 400, 320, 240, readout_time=0.02)
    monkeypatch.setattr("chasles._gtsam.batch_problem", lambda run, part: {**batch_problem(plain), "cameras": [rolling]})
    with pytest.raises(chasles.UsageError, match="a rolling shutter of 20.0 ms; expected a global one"):
        gtsam_graph(plain)


@pytest.mark.parametrize("scene", [
    {"cameras": 2, "match_sigma": 0.3},
    {"distortion": "radtan", "distortion_1": -0.28, "distortion_2": 0.07, "distortion_3": 2e-4, "distortion_4": 1e-5},
    {"distortion": "equidistant", "distortion_1": -0.01, "distortion_2": 0.02, "distortion_3": -0.01, "distortion_4": 3e-3},
    {"camera_tilt_x": 0.2, "camera_tilt_y": -0.1, "camera_tilt_z": 0.3},
], ids=lambda scene: str(next(iter(scene.values()))))
def test_cameras_and_lenses(scene):
    check_same(flight(**scene), 1e-8, 1e-4)


def test_what_is_no_problem_of_batch_estimation(plain, tmp_path):
    for run in (chasles.run(chasles.simulate("hallway", sections=1)),
                chasles.run(chasles.simulate("street", route="L"), estimator="batch")):
        with pytest.raises(chasles.UsageError, match="no problem of batch estimation"):
            gtsam_graph(run)
    with pytest.raises(chasles.UsageError, match="part: found 1, expected 0 to 0"):
        gtsam_graph(plain, part=1)
