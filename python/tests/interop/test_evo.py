"""Errors of trajectories against evo's, on the same pairs of poses and with the same alignments."""

import copy

import numpy as np
import pytest
from evo.core import geometry, lie_algebra, sync
from evo.core.metrics import APE, RPE, PoseRelation, StatisticsType, Unit

import chasles
from chasles.interop import align, from_evo, to_evo

RMSE, MEAN = StatisticsType.rmse, StatisticsType.mean


def close(ours, evos):
    return ours == pytest.approx(evos, rel=1e-9, abs=1e-9)


def rotation(axis, angle):
    return lie_algebra.so3_exp(np.asarray(axis) * angle)


@pytest.fixture(scope="module")
def walk():
    """A real run, whose frames are at stamps of the truth."""
    recording = chasles.simulate("hallway", sections=2)
    run = chasles.run(recording)
    return run.states, recording.truth


@pytest.fixture(scope="module")
def drive():
    """700 m with errors that grow, at a scale of 1.02, in a world of its own."""
    random = np.random.default_rng(3)
    n, dt = 4000, 0.05
    heading = np.cumsum(0.3 * np.sin(np.arange(n) * 0.004) * dt)
    truth_R = [rotation([0, 0, 1], h) @ rotation([1, 0, 0], 0.05 * np.sin(i * 0.01)) for i, h in enumerate(heading)]
    velocity = np.stack([R @ [3.5, 0, 0.1] for R in truth_R])
    truth_p = np.cumsum(velocity * dt, axis=0)
    world_R, world_p = rotation([0.2, -0.1, 0.9], 1.3), np.array([5.0, -20, 3])
    errors = np.cumsum(random.normal(0, 2e-4, (n, 3)), axis=0)
    R = np.stack([world_R @ rotation(e, 1.0) @ A for e, A in zip(errors, truth_R)])
    p = np.cumsum(np.stack([A @ B.T @ v for A, B, v in zip(R, truth_R, 1.02 * velocity)]) * dt, axis=0) + world_p
    time = 1_700_000_000_000_000_000 + (np.arange(n) * 50_000_000).astype(np.int64)
    quaternion = lambda list_of_R: np.stack([lie_algebra.sst_rotation_from_matrix(A).as_quat() for A in list_of_R])
    return ({"time": time, "position": p, "quaternion": quaternion(R)},
            {"time": time, "position": truth_p, "quaternion": quaternion(truth_R)})


@pytest.fixture(params=["walk", "drive"])
def pair(request):
    """(estimate, truth) as columns, and as evo's trajectories, paired by evo."""
    estimate, truth = request.getfixturevalue(request.param)
    evos_truth, evos_estimate = sync.associate_trajectories(to_evo(truth), to_evo(estimate), max_diff=1e-6)
    assert evos_estimate.num_poses == len(estimate["time"])
    return estimate, truth, evos_estimate, evos_truth


def evos_error(metric, truth, estimate):
    metric.process_data((truth, estimate))
    return metric


def absolute(truth, estimate):
    """Root mean squares of position [m] and attitude [deg]."""
    return tuple(evos_error(APE(relation), truth, estimate).get_statistic(RMSE)
                 for relation in (PoseRelation.translation_part, PoseRelation.rotation_angle_deg))


def check_absolute(ours, evos):
    assert evos[0] > 1e-3 and evos[1] > 1e-3  # something to compare
    assert close(ours[0], evos[0]) and close(ours[1], evos[1])


def test_se3_alignment(pair):
    estimate, truth, evos, evos_truth = pair
    evos.align(evos_truth)
    figures, error = chasles.evaluate(estimate, truth), absolute(evos_truth, evos)
    check_absolute((figures["ate_m"], figures["attitude_deg"]), error)
    found = align(estimate, truth)
    check_absolute((found["ate_m"], found["attitude_deg"]), error)


def test_evos_interpolation_is_ours_where_the_truth_has_more_poses(walk):
    """Stamps of the estimate between those of the truth: evo resamples the truth, as we do."""
    from evo.core.sync_method import SyncMethod

    estimate, truth = walk
    every = slice(1, -1, 3)
    late = {"time": estimate["time"][every] + 3_000_000, "position": estimate["position"][every],
            "quaternion": estimate["quaternion"][every]}
    evos_truth, evos = sync.associate_trajectories(to_evo(truth), to_evo(late), sync_method=SyncMethod.interpolation,
                                                   max_diff=0.1)
    evos.align(evos_truth)
    figures = chasles.evaluate(late, truth)
    assert evos.num_poses == len(late["time"])
    check_absolute((figures["ate_m"], figures["attitude_deg"]), absolute(evos_truth, evos))


def test_sim3_alignment(pair):
    estimate, truth, evos, evos_truth = pair
    R, p, scale = evos.align(evos_truth, correct_scale=True)
    found = align(estimate, truth, "Sim(3)")
    assert close(found["scale"], scale)
    assert np.allclose(found["truth_T_estimate"], lie_algebra.se3(R, p), rtol=1e-9, atol=1e-9)
    check_absolute((found["ate_m"], found["attitude_deg"]), absolute(evos_truth, evos))


def test_alignment_by_position_and_yaw(pair):
    """evo's Umeyama method in the plane, and the mean height, are the least squares with z axes that stay vertical."""
    estimate, truth, evos, evos_truth = pair
    R, p, _ = geometry.umeyama_alignment(evos.positions_xyz[:, :2].T, evos_truth.positions_xyz[:, :2].T)
    T = np.eye(4)
    T[:2, :2], T[:2, 3] = R, p
    T[2, 3] = np.mean(evos_truth.positions_xyz[:, 2] - evos.positions_xyz[:, 2])
    evos.transform(T)
    figures, error = chasles.evaluate(estimate, truth), absolute(evos_truth, evos)
    check_absolute((figures["ate_posyaw_m"], figures["attitude_posyaw_deg"]), error)


def test_alignment_by_the_first_pose(pair):
    estimate, truth, evos, evos_truth = pair
    evos.align_origin(evos_truth)
    figures = chasles.evaluate(estimate, truth)
    check_absolute((figures["ate_first_pose_m"], figures["attitude_first_pose_deg"]), absolute(evos_truth, evos))


def test_relative_error_over_a_number_of_frames(pair):
    """Stamps are regular, so that a second is a number of frames; ours start at every tenth."""
    estimate, truth, evos, evos_truth = pair
    frames = round(1e9 / np.median(np.diff(estimate["time"])))
    figures = chasles.evaluate(estimate, truth)
    for relation, name in ((PoseRelation.translation_part, "rpe_1s_m"),
                           (PoseRelation.rotation_angle_deg, "rpe_1s_deg")):
        errors = evos_error(RPE(relation, frames, Unit.frames, all_pairs=True), evos_truth, evos).error
        assert len(errors) == len(estimate["time"]) - frames
        assert figures[name] > 1e-4 and close(figures[name], np.mean(errors[::10]))


def pairs_over_a_distance(truth, length):
    """docs/evaluation.md, section 4."""
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(truth["position"], axis=0), axis=1))])
    for first in range(0, len(along), 10):
        last = np.searchsorted(along, along[first] + length, side="right")
        if last < len(along):
            yield first, int(last)


def test_relative_error_over_a_distance(drive):
    """evo chooses the stamp nearest to the length, we the first beyond it: evo gets our pairs, as poses one after the
    other."""
    estimate, truth = drive
    figures = chasles.evaluate(estimate, truth)
    pairs = list(pairs_over_a_distance(truth, 100))
    assert len(pairs) > 300
    poses = np.ravel(pairs)
    several = []
    for columns in (truth, estimate):
        path = to_evo({name: values[poses] for name, values in columns.items()})
        path.timestamps = np.arange(len(poses), dtype=float)
        several.append(path)
    for relation, name, unit in ((PoseRelation.translation_part, "rpe_100m_percent", 1.0),
                                 (PoseRelation.rotation_angle_deg, "rpe_100m_deg_per_m", 0.01)):
        errors = evos_error(RPE(relation, 1, Unit.frames), *several).error[::2]
        assert len(errors) == len(pairs)
        assert figures[name] > 1e-4 and close(figures[name], unit * np.mean(errors))


def test_evos_own_pairs_over_a_distance_are_near(drive):
    """The choice of the stamp shifts the figure by less than a hundredth of it."""
    estimate, truth = drive
    evos = evos_error(RPE(PoseRelation.translation_part, 100, Unit.meters, 0.01, all_pairs=True,
                          pairs_from_reference=True), to_evo(truth), to_evo(estimate)).error
    assert chasles.evaluate(estimate, truth)["rpe_100m_percent"] == pytest.approx(np.mean(evos[::10]), rel=0.01)


def test_a_path_survives_the_way_to_evo_and_back(pair):
    estimate, _, _, _ = pair
    back = from_evo(to_evo(estimate))
    assert np.abs(back["time"] - estimate["time"]).max() <= 120  # ns: a double of seconds since 1970
    assert np.array_equal(back["position"], estimate["position"])
    assert np.array_equal(back["quaternion"], estimate["quaternion"])
    assert chasles.evaluate(back, back)["ate_m"] == pytest.approx(0, abs=1e-9)
    valid, details = to_evo(estimate).check()
    assert valid, details


def test_an_alignment_by_evo_comes_back(walk):
    estimate, truth = walk
    evos = copy.deepcopy(to_evo(estimate))
    evos.align(to_evo(truth))
    moved = from_evo(evos)
    moved["time"] = estimate["time"]
    assert align(moved, truth, "none")["ate_m"] == pytest.approx(align(estimate, truth)["ate_m"], rel=1e-9)


def test_what_is_no_trajectory():
    with pytest.raises(chasles.UsageError, match="found columns time, position; .* quaternion is missing"):
        to_evo({"time": np.arange(3), "position": np.zeros((3, 3))})
    with pytest.raises(TypeError, match="PoseTrajectory3D"):
        from_evo(object())
