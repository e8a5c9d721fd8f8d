"""An accelerometer and a gyroscope that are read apart."""

import numpy
import pytest

import chasles

GYRO = 1_600_000_000_000_000_000 + 5_000_000 * numpy.arange(400)
ACCEL = 1_600_000_000_001_000_000 + 16_000_000 * numpy.arange(100)


def forces(times):
    """Linear in time."""
    seconds = (times - GYRO[0]) * 1e-9
    return numpy.column_stack([0.1 + seconds, 0.2 - seconds, 9.5 + 2 * seconds])


def test_the_joined_samples_are_those_of_the_gyroscope_with_interpolated_forces():
    rates = numpy.random.default_rng(1).normal(size=(400, 3))
    joined = chasles.join_imu(GYRO, rates, ACCEL, forces(ACCEL))
    inside = (GYRO >= ACCEL[0]) & (GYRO <= ACCEL[-1])
    assert (joined["time"] == GYRO[inside]).all()
    assert (joined["angular_rate"] == rates[inside]).all()
    assert numpy.allclose(joined["specific_force"], forces(GYRO[inside]), rtol=0, atol=1e-9)
    assert "accelerometer, 62.5 Hz" in joined["remarks"][0] and "83 of 400" in joined["remarks"][1]


def test_what_cannot_be_joined_is_an_error():
    rates = numpy.ones((400, 3))
    with pytest.raises(chasles.InputError, match="1.00 h"):
        chasles.join_imu(GYRO, rates, ACCEL + 3_600_000_000_000, forces(ACCEL))
    with pytest.raises(ValueError, match="found 400 times and values 400 x 2 of the gyroscope"):
        chasles.join_imu(GYRO, rates[:, :2], ACCEL, forces(ACCEL))
