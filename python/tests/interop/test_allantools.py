"""Allan deviations against those of allantools."""

import allantools
import numpy
import pytest

import chasles

RATE = 100.0


def test_overlapping_deviations_are_those_of_allantools():
    random = numpy.random.default_rng(7)
    walk = numpy.cumsum(random.normal(scale=1e-4, size=(12_000, 6)), axis=0)
    samples = walk + random.normal(scale=2e-3, size=walk.shape)
    calibration = chasles.calibrate_noise({"time": numpy.arange(len(samples)) / RATE,
                                           "specific_force": samples[:, :3], "angular_rate": samples[:, 3:]})
    for axis, name in enumerate(["accelerometer_x", "accelerometer_y", "accelerometer_z",
                                 "gyroscope_x", "gyroscope_y", "gyroscope_z"]):
        allan = calibration.allan[name]
        taus, deviations, _, counts = allantools.oadev(samples[:, axis], rate=RATE, data_type="freq", taus=allan["tau"])
        assert taus == pytest.approx(allan["tau"], rel=1e-9)
        assert allan["deviation"] == pytest.approx(deviations, rel=1e-12)
        assert (allan["differences"] == counts).all()


def test_degrees_of_freedom_are_near_those_of_greenhall_and_riley():
    random = numpy.random.default_rng(8)
    samples = random.normal(scale=2e-3, size=(6_000, 6))
    allan = chasles.calibrate_noise({"time": numpy.arange(len(samples)) / RATE, "specific_force": samples[:, :3],
                                     "angular_rate": samples[:, 3:]}).allan["gyroscope_x"]
    for factor in (100, 1000):  # theirs is exact for long means
        at = int(numpy.argmin(abs(allan["tau"] * RATE - factor)))
        expected = allantools.edf_greenhall(0, 2, factor, len(samples) + 1, overlapping=True, modified=False)
        assert allan["dof"][at] == pytest.approx(expected, rel=1e-3)
