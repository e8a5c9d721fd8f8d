"""What a consistent filter's NEES and NIS keep to."""

import math


def mean_band(dof: int, count: int) -> list[float]:
    """95 % band of the mean of `count` independent chi-square variables, per degree of freedom, by
    Wilson and Hilferty's approximation: exact to 0.001 for 30 degrees of freedom or more in all."""
    n = dof * count
    return [(1 - 2 / (9 * n) + z * math.sqrt(2 / (9 * n))) ** 3 for z in (-1.959964, 1.959964)]
