"""calibrate_imu_cameras() and calibrate_from_motion() against the truth; numpy simulates views and samples by itself."""

import numpy
import pytest

import chasles
from test_calibrate import CORNERS, LEFT, SIGMA, SIZE, pixels_of, rotation

NOISE = chasles.ImuNoise(accelerometer_noise_density=2e-3, gyroscope_noise_density=1.7e-4, accelerometer_random_walk=3e-4,
                         gyroscope_random_walk=2e-5)
CAM_R_IMU, CAM_P_IMU = rotation(numpy.array([0.02, -0.01, 1.55])), numpy.array([0.06, -0.02, 0.01])
OFFSET = 0.013
GRAVITY = 9.80665 * numpy.array([0.1, 0.99, 0.0995])
GRAVITY *= 9.80665 / numpy.linalg.norm(GRAVITY)


def attitude(t):
    """target_R_imu"""
    turn = [0.35 * numpy.sin(1.9 * t) + 0.1 * numpy.sin(5.3 * t), 0.35 * numpy.sin(2.3 * t + 1) + 0.08 * numpy.sin(6.1 * t),
            0.5 * numpy.sin(1.3 * t + 2)]
    return rotation(numpy.array(turn)) @ CAM_R_IMU


def place(t):
    return CORNERS.mean(axis=0) + numpy.array([0.2 * numpy.sin(1.1 * t) + 0.04 * numpy.sin(6.7 * t),
                                               0.15 * numpy.sin(1.7 * t) + 0.03 * numpy.sin(7.3 * t),
                                               -0.7 + 0.15 * numpy.sin(0.9 * t + 1) + 0.03 * numpy.sin(5.9 * t)])


def samples(seconds=9.0, rate=200, seed=1):
    rng = numpy.random.default_rng(seed)
    times, h = numpy.arange(0, seconds, 1 / rate), 1e-4
    force, turning = [], []
    for t in times:
        R, change = attitude(t), attitude(t - h).T @ attitude(t + h)
        turning.append(numpy.array([change[2, 1] - change[1, 2], change[0, 2] - change[2, 0], change[1, 0] - change[0, 1]]) / (4 * h))
        acceleration = (place(t + 1e-3) - 2 * place(t) + place(t - 1e-3)) / 1e-6
        force.append(R.T @ (acceleration - GRAVITY))
    white = rate**0.5
    return {"time": numpy.round(times * 1e9).astype(numpy.int64),
            "specific_force": force + rng.normal(0, 2e-3 * white, (len(times), 3)) + [0.03, -0.02, 0.05],
            "angular_rate": turning + rng.normal(0, 1.7e-4 * white, (len(times), 3)) + [0.004, -0.003, 0.002]}


def views(seconds=8.0, seed=1):
    rng = numpy.random.default_rng(seed)
    result = []
    for t in numpy.arange(0.5, seconds, 0.05):
        points = (CORNERS - place(t)) @ attitude(t) @ CAM_R_IMU.T + CAM_P_IMU
        pixels = pixels_of(LEFT, points) + rng.normal(0, SIGMA, (len(CORNERS), 2))
        ids = numpy.flatnonzero(((pixels > 2) & (pixels < numpy.array(SIZE) - 3)).all(axis=1) & (points[:, 2] > 0.1))
        if len(ids) >= 15:
            result.append((int(round(1e9 * (t - OFFSET))), 0, ids, pixels[ids]))
    return result


def calibrated(corners=CORNERS, **arguments):
    return chasles.calibrate_imu_cameras(corners, views(), [SIZE], samples(), "radtan", noise=NOISE, bend=False, **arguments)


@pytest.fixture(scope="module")
def rig():
    return calibrated()


def test_the_truth_is_within_four_sigma(rig):
    names, values, sigmas = rig.parameters
    row = {name: i for i, name in enumerate(names)}
    truth = {"cam0.time_offset": OFFSET, **{f"cam0.{name}": LEFT[name] for name in ("fx", "fy", "cx", "cy")},
             **{f"cam0.position_{axis}": p for axis, p in zip("xyz", CAM_P_IMU)},
             **{name: 0 for name in names if name.startswith("imu.")}}
    for name, true in truth.items():
        assert abs(values[row[name]] - true) < 4 * sigmas[row[name]], name
    assert sigmas[row["cam0.time_offset"]] < 1e-3 and sigmas[row["cam0.position_x"]] < 0.01
    turn = rig.cam_T_imu[0, :3, :3] @ CAM_R_IMU.T
    assert numpy.linalg.norm(turn - numpy.eye(3)) < 4 * 2**0.5 * numpy.linalg.norm(sigmas[row["cam0.rotation_x"]:][:3])
    assert numpy.isclose(numpy.linalg.norm(rig.gravity), 9.80665)
    lean = numpy.arccos(rig.gravity @ GRAVITY / 9.80665**2)
    assert lean < 4 * numpy.hypot(sigmas[row["gravity_1"]], sigmas[row["gravity_2"]])
    assert numpy.allclose(rig.gyroscope_bias, [0.004, -0.003, 0.002], rtol=0, atol=1e-3)
    assert numpy.allclose(rig.accelerometer_bias, [0.03, -0.02, 0.05], rtol=0, atol=0.05)


def test_the_parts_of_a_calibration_agree(rig):
    camera, = rig.cameras
    assert (camera.cam_T_imu == rig.cam_T_imu[0]).all() and rig.time_offsets[0] == rig.report["cameras"][0]["time_offset_s"]
    assert rig.readout_times == [0] and rig.lenses == ["radtan"] and numpy.allclose(rig.cam_T_cam0, numpy.eye(4), rtol=0, atol=1e-15)
    assert numpy.allclose(numpy.diag(rig.covariance), rig.parameters.sigmas**2, rtol=1e-12, atol=0)
    scale = rig.parameters.names.index("imu.accelerometer_scale_x")
    assert rig.imu_correction.force[0, 0] == rig.parameters.values[scale] and (numpy.triu(rig.imu_correction.force, 1) == 0).all()
    errors = rig.errors
    assert len(errors["error"]) == sum(len(view[2]) for view in views())
    assert numpy.isclose((errors["error"] ** 2).sum(axis=1).mean(), rig.rms[0] ** 2, rtol=1e-9)
    assert "no comparison of halves: found views over 7.5 s" in " ".join(rig.remarks) and rig.halves is None
    assert "cam0.time_offset" in str(rig) and "ImuCamerasCalibration: radtan" in repr(rig)
    rig.imu_correction.force[:] = 7
    assert rig.imu_correction.force[0, 0] < 1


def test_the_z_axis_of_the_target_may_point_to_the_cameras(rig):
    turn = numpy.diag([1.0, -1, -1])
    again = calibrated(CORNERS @ turn)
    assert (again.parameters.values == rig.parameters.values).all() and (again.gravity @ turn == rig.gravity).all()
    assert (abs(again.covariance) == abs(rig.covariance)).all()
    # How gravity changes in the frame together with the mounting.
    row, other = (rig.parameters.names.index(name) for name in ("gravity_1", "cam0.rotation_x"))
    changes = []
    for one in (rig, again):
        axis = numpy.array([-one.gravity[1], one.gravity[0], 0]) / numpy.hypot(*one.gravity[:2])
        changes.append(numpy.cross(axis, one.gravity) * one.covariance[row, other])
    assert numpy.allclose(changes[1] @ turn, changes[0], rtol=1e-9, atol=0)


def test_a_readout_time_and_an_exact_imu():
    found = calibrated(rolling=True, exact_imu=True)
    names, values, sigmas = found.parameters
    row = names.index("cam0.readout_time")
    assert abs(values[row]) < 4 * sigmas[row] < 2e-3
    assert not any(name.startswith("imu.") for name in names) and not found.imu_correction.rate.any()


def test_samples_that_cannot_be_used_are_errors():
    def wrong(match, error=chasles.InputError, **changes):
        given = {"imu": samples(), "noise": NOISE, **changes}
        with pytest.raises(error, match="^calibrate_imu_cameras: " + match if error is chasles.InputError else match):
            chasles.calibrate_imu_cameras(CORNERS, views(), [SIZE], lenses="radtan", bend=False, **given)

    def changed(**columns):
        return {**samples(), **columns}

    force, time = samples()["specific_force"], samples()["time"]
    wrong("imu: found 3 without 'time', expected a dictionary", imu=3)
    wrong("imu: found .* without 'angular_rate'", imu={"time": time, "specific_force": force})
    wrong(r"imu: specific_force: found an array .*, expected an array \(N, 3\)", imu=changed(specific_force=force[:, :2]))
    wrong("imu: specific_force: found .*nan.* in row 5, expected finite",
          imu=changed(specific_force=numpy.where(numpy.arange(len(force))[:, None] == 5, numpy.nan, force)))
    wrong("imu: found time an array .*1799 rows", imu=changed(specific_force=force[1:]))
    wrong("imu: time: found .* after .* in row 1, expected rising times", imu=changed(time=time[::-1].copy()))
    wrong("imu: time: found an array", imu=changed(time=time.astype(str)))
    wrong("noise: found 0.1, expected an ImuNoise", chasles.UsageError, noise=0.1)
    wrong("gravity: found 1.0, expected 9.7 to 9.9", chasles.UsageError, gravity=1.0)
    with pytest.raises(chasles.InputError, match=r"^calibrate_imu_cameras: views\[0\]: found \[1, 2\]"):
        chasles.calibrate_imu_cameras(CORNERS, [[1, 2]], [SIZE], samples(), noise=NOISE)
    with pytest.raises(chasles.InputError, match="the accelerometer has the other sign"):
        chasles.calibrate_imu_cameras(CORNERS, views(), [SIZE], changed(specific_force=-force), "radtan", noise=NOISE, bend=False)


def test_a_motion_without_a_target():
    recording = chasles.simulate("turntable", revolutions=0.5)
    found = chasles.calibrate_from_motion(recording)
    names, stated, values, sigmas = found.parameters
    assert "imu_T_cam0_x" in names and (abs(values - stated) < 5 * sigmas).all() and (sigmas > 0).all()
    assert abs(found.time_offset) < 0.05 and len(found.cameras) == len(recording.cameras)
    assert found.cameras[0].cam_T_imu.shape == (4, 4) and "imu_T_cam0_x" in str(found) and isinstance(found.remarks, list)
    assert found.report["parameters"][0]["name"] == names[0] and "MotionCalibration of" in repr(found)
    assert (recording.cameras[0].cam_T_imu != found.cameras[0].cam_T_imu).any(), "the recording keeps its calibration"
    with pytest.raises(chasles.InputError, match="no-such-recording"):
        chasles.calibrate_from_motion("no-such-recording")
