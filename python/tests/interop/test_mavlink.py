"""`chasles export -o run.tlog`, read by pymavlink. Expected numbers come from states.csv."""

import os

os.environ["MAVLINK20"] = "1"  # of pymavlink: before its first import

import numpy as np
import pytest

from test_exports import BINARY, Walk, numbers

pytestmark = pytest.mark.skipif(BINARY is None, reason="CHASLES_BINARY names no command")

FRD = np.diag([1.0, -1, -1])


@pytest.fixture(scope="module")
def walk(tmp_path_factory):
    return Walk(tmp_path_factory.mktemp("walk"))


def messages_of(file):
    from pymavlink import mavutil
    log = mavutil.mavlink_connection(str(file))
    messages = []
    while (message := log.recv_match()) is not None:
        messages.append(message)
    return messages


def rotation(wxyz):
    w, x, y, z = wxyz
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def symmetric(triangle):
    full = np.zeros((6, 6))
    full[np.triu_indices(6)] = triangle
    return full + np.triu(full, 1).T


def test_pymavlink_reads_the_states_in_frd_axes(walk):
    from pymavlink import mavutil
    messages = messages_of(walk.export("mavlink", "run.tlog"))
    assert {message.get_type() for message in messages} == {"ODOMETRY"}, "no message is damaged"
    assert [message.time_usec for message in messages] == (walk.time_ns // 1000).tolist()
    assert [message._timestamp for message in messages] == pytest.approx(walk.time_ns * 1e-9, abs=2e-6)
    names = {name: value for name, value in vars(mavutil.mavlink).items() if name.startswith("MAV_")}
    velocity = numbers(walk.states, "velocity_x", "velocity_y", "velocity_z")
    sigma_v = numbers(walk.states, *(f"sigma_velocity_{axis}" for axis in "xyz"))
    for i, message in enumerate(messages):
        assert message.frame_id == names["MAV_FRAME_LOCAL_FRD"]
        assert message.child_frame_id == names["MAV_FRAME_BODY_FRD"]
        assert message.estimator_type == names["MAV_ESTIMATOR_TYPE_VIO"]
        assert message.get_srcComponent() == names["MAV_COMP_ID_VISUAL_INERTIAL_ODOMETRY"]
        assert (message.quality, message.reset_counter) == (100, 0)
        R, p = walk.world_T_imu[i][:3, :3], walk.world_T_imu[i][:3, 3]
        assert np.allclose([message.x, message.y, message.z], FRD @ p, atol=1e-6)
        assert np.allclose(rotation(message.q), FRD @ R @ FRD, atol=1e-6)
        assert np.allclose([message.vx, message.vy, message.vz], FRD @ R.T @ velocity[i], atol=1e-6)
        # states.csv: rotation in world axes first, then position.
        ours = symmetric([float(walk.states[f"cov_{a}{b}"][i]) for a in range(6) for b in range(a, 6)])
        J = np.zeros((6, 6))
        J[:3, 3:], J[3:, :3] = FRD, FRD @ R.T
        assert np.allclose(symmetric(message.pose_covariance), J @ ours @ J.T, rtol=1e-5, atol=1e-12)
        of_velocity = symmetric(message.velocity_covariance)
        B = FRD @ R.T
        assert np.allclose(of_velocity[:3, :3], B @ np.diag(sigma_v[i] ** 2) @ B.T, rtol=1e-5, atol=1e-12)
        assert np.isnan(of_velocity[3:]).all()


def test_the_walk_goes_forward_and_its_axes_are_those_of_the_vehicle(walk):
    messages = messages_of(walk.export("mavlink", "vehicle.tlog"))
    # A walk on level ground: mostly forward, and gravity pulls along +z of an upright body.
    assert messages[-1].vx > 5 * abs(messages[-1].vy) and messages[-1].vx > 0.3
    assert all(rotation(message.q)[2, 2] > 0.9 for message in messages)
    turned = messages_of(walk.export("mavlink", "turned.tlog", "--body", "y,x,-z"))
    assert turned[-1].vy == pytest.approx(messages[-1].vx, abs=1e-6)


def test_the_smoothed_path_has_no_covariance_of_velocity(walk):
    messages = messages_of(walk.export("mavlink", "smoothed.tlog", "--smoothed"))
    smoothed = walk.run / "smoothed.csv"
    assert len(messages) == len(smoothed.read_text().splitlines()) - 1
    assert all(np.isnan(message.velocity_covariance[0]) for message in messages)
