"""Files of a run as arrays, and rotations. Needs NumPy."""

import pathlib
import typing

import numpy as np
import numpy.typing

Array = numpy.typing.NDArray[typing.Any]


def tum(file: pathlib.Path) -> Array:
    """Rows of time, position and quaternion; of SQUARE also the triangle of the covariance."""
    return np.loadtxt(file, ndmin=2)


def table_of(file: pathlib.Path) -> Array:
    """A csv by the names of its columns."""
    return np.genfromtxt(file, delimiter=",", names=True)


def rotations(q: Array) -> Array:
    """The matrices of unit quaternions x, y, z, w."""
    x, y, z, w = q.T
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]).transpose(2, 0, 1)
