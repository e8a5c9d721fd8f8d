"""The noise of an IMU."""

import json

import numpy
import pytest

import chasles

RATE = 100.0
DENSITY = {"specific_force": 2e-3, "angular_rate": 1.7e-4}


def samples(seconds=40, moving=False):
    """An IMU that lies level, or is moved by hand."""
    random = numpy.random.default_rng(3)
    time = numpy.arange(int(seconds * RATE)) / RATE
    imu = {"time": time}
    for name, density in DENSITY.items():
        imu[name] = density * RATE**0.5 * random.normal(size=(len(time), 3))
        if moving:
            imu[name] += numpy.sin(2 * numpy.pi * 1.3 * time)[:, None]
    imu["specific_force"][:, 2] += 9.81
    return imu


def test_arrays_of_a_standstill_have_their_densities_and_limits_of_the_walks(tmp_path):
    calibration = chasles.calibrate_noise(samples())
    report = calibration.report
    assert report["standstill"]["seconds"] == pytest.approx(40, abs=0.1)
    assert report["gyroscope"]["noise_density"]["value"] == pytest.approx(1.7e-4, rel=0.06)
    assert report["gyroscope"]["random_walk"]["is_limit"]
    assert calibration.imu_noise.accelerometer_noise_density == report["accelerometer"]["noise_density"]["value"]
    assert calibration.allan["gyroscope_y"]["deviation"][0] == pytest.approx(1.7e-3, rel=0.1)
    assert calibration.remarks == []
    assert "a filter takes" in str(calibration) and "arrays" in repr(calibration)
    calibration.save(tmp_path / "noise")
    assert json.loads((tmp_path / "noise/noise.json").read_text()) == report
    assert "gyroscope_noise_density" in (tmp_path / "noise/imu.yaml").read_text()
    assert (tmp_path / "noise/allan.csv").read_text().startswith("axis,tau_s")


def test_a_motion_has_no_walks():
    calibration = chasles.calibrate_noise(samples(moving=True))
    assert calibration.imu_noise is None and calibration.allan == {}
    assert calibration.report["gyroscope"]["noise_density"]["is_limit"]


def test_recordings_and_tables_are_the_same(tmp_path):
    recording = chasles.simulate("hallway", rest_duration=20, sections=1, hall_length=8, frame_rate=2)
    of_recording = chasles.calibrate_noise(recording, stop=20)
    imu = recording.imu
    table = numpy.column_stack([imu["angular_rate"], imu["specific_force"]])
    lines = [f"{time},{','.join(repr(float(x)) for x in row)}" for time, row in zip(imu["time"], table)]
    (tmp_path / "imu.csv").write_text("\n".join(["time_ns,wx,wy,wz,ax,ay,az", *lines]) + "\n")
    of_table = chasles.calibrate_noise(tmp_path / "imu.csv", stop=20)
    assert of_table.report["accelerometer"]["noise_density"] == of_recording.report["accelerometer"]["noise_density"]
    assert of_recording.report["stated"]["gyroscope_noise_density"] == recording.imu_noise.gyroscope_noise_density


def test_what_shows_no_noise_is_an_error():
    with pytest.raises(chasles.InputError, match="found 2.0 s of samples"):
        chasles.calibrate_noise(samples(seconds=2))
    with pytest.raises(chasles.UsageError, match="has no 'angular_rate'"):
        chasles.calibrate_noise({"time": [0.0], "specific_force": [[0, 0, 0]]})
    with pytest.raises(ValueError, match="found 2 times, specific_force 1 x 3"):
        chasles.calibrate_noise({"time": [0.0, 1.0], "specific_force": [[0, 0, 0]], "angular_rate": [[0, 0, 0]]})
    with pytest.raises(chasles.UsageError, match="did you mean 'start'"):
        chasles.calibrate_noise(samples(), starts=1)
    with pytest.raises(chasles.InputError, match="the gyroscope's z axis shows 0 rad/s"):
        dead = samples()
        dead["angular_rate"][:, 2] = 0
        chasles.calibrate_noise(dead)
