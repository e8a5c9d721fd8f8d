#!/usr/bin/env bash
# AllanTools 2024.6 (Allan deviations, from which the noise of an IMU is read)
#
# Behaviour: edf_greenhall, from which confidence_interval_noiseID takes its interval, gives for the overlapping Allan
# variance of 6000 samples at m = 1 (means of single samples) 4695 equivalent degrees of freedom for white noise and
# 4577 for a random walk of samples. By their definition, 2 E[v]^2 / var(v) with the exact covariance of the second differences,
# they are 3999.6 and 5999, and 2000 simulated series confirm this. For white noise it is up to 11 % low at m = 3 to 5,
# and 3 % low at 33; from m = 34 it is right to 0.11 %, and from 100 to 0.05 %. At m = 1 the numbers are those of phases
# that are themselves means over one sample interval, to all digits. The sums of samples that oadev forms are not.
#
# A good engineer would guess: m = 1, where a closed form is easy, is the most certain point of the table.
#
# So: sum the exact covariance at short averaging times, and compare with edf_greenhall from m = 100 only.
. "$(dirname "$0")/lib.sh"
python_with AllanTools==2024.6 numpy==2.2.6 scipy==1.15.3
timeout 300 nice -n 10 "$python" - << 'PY'
import numpy as np
from allantools.ci import edf_greenhall
samples = 6000

def edf_of(covariance, terms):
    """2 E[v]^2 / var(v) of the mean v of the squares of `terms` Gaussian numbers with this covariance by lag."""
    r = np.zeros(terms)
    n = min(terms, len(covariance))
    r[:n] = covariance[:n] / covariance[0]
    pairs = 2.0 * (terms - np.arange(terms))
    pairs[0] = terms
    return terms**2 / (pairs @ r**2)

def exact(walk, m):
    weights = np.repeat([-1.0, 1.0], m)  # of the samples in a difference of two neighbouring means
    if walk:
        weights = -np.cumsum(weights)[:-1]  # of the walk's steps
    return edf_of(np.correlate(weights, weights, "full")[len(weights) - 1:], samples + 1 - 2 * m)

def simulated(walk, m, seeds=2000):
    v = []
    for seed in range(seeds):
        y = np.random.default_rng(seed).standard_normal(samples)
        x = np.cumsum(np.r_[0, np.cumsum(y) if walk else y])
        v.append(np.mean((x[2 * m:] - 2 * x[m:-m] + x[:-2 * m])**2))
    return 2 * np.mean(v)**2 / np.var(v, ddof=1)

def averaged_phases(walk):
    """At m = 1, if the phases are means over one interval of the integral of continuous noise."""
    power, order = (5, 6) if walk else (3, 6)
    row = np.array([1.0])
    for _ in range(order):
        row = np.convolve(row, [1, -1])
    lags = np.arange(5)[:, None] + np.arange(order + 1) - order // 2
    return edf_of((row * np.abs(lags)**float(power)).sum(1), samples - 1)

for walk, name in ((False, "white noise"), (True, "random walk")):
    found = {m: edf_greenhall(-2 if walk else 0, 2, m, samples + 1, overlapping=True) for m in (1, 3, 10, 33, 34, 100, 1000)}
    off = {m: found[m] / exact(walk, m) - 1 for m in found}
    seen = {m: simulated(walk, m) for m in (1, 10)}
    for m in found:
        more = f", simulated {seen[m]:.0f}" if m in seen else ""
        print(f"  {name}, m {m}: edf_greenhall {found[m]:.2f}, exact {exact(walk, m):.2f} ({100 * off[m]:+.2f} %){more}")
    print(f"  {name}, m 1, of phases that are means: {averaged_phases(walk):.2f}")
    # The edf of n seeds has a sigma of sqrt(2 / n), 3 %.
    assert all(abs(seen[m] / exact(walk, m) - 1) < 0.1 for m in seen)
    assert abs(found[1] - (4576.65 if walk else 4695.07)) < 0.01 and abs(exact(walk, 1) - (5999 if walk else 3999.56)) < 0.01
    assert abs(averaged_phases(walk) / found[1] - 1) < 1e-6
    assert all(abs(off[m]) < 1.2e-3 for m in found if m >= 34) and all(abs(off[m]) < 1e-3 for m in found if m >= 100)
    assert walk or (off[3] < -0.1 and off[33] < -0.02)
PY
