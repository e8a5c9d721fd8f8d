"""Paired differences: statistics, words and numbers for studies/paired.py and studies/halves.py. Needs numpy."""

import numpy as np

from studies.trajectories import ROOT, mean_and_error

PAGE = ROOT / "studies/batch.md"
DRAWS = 20000  # of random signs


def student(dof):
    """The 97.5 % quantile of Student's t (Cornish and Fisher's series; 3 digits from 5 on)."""
    z = 1.959964
    return z + (z**3 + z) / (4 * dof) + (5 * z**5 + 16 * z**3 + 3 * z) / (96 * dof**2) + (3 * z**7 + 19 * z**5 + 17 * z**3 - 15 * z) / (384 * dof**3)


def interval(values):
    mean, error = mean_and_error(values)
    half = student(len(values) - 1) * error
    return mean - half, mean + half


def sign_flips(differences):
    """Two-sided p value of the mean if both signs of each difference are equally likely."""
    n = len(differences)
    if n <= 14:
        signs = 1 - 2 * ((np.arange(2**n)[:, None] >> np.arange(n)) & 1)
    else:
        signs = np.vstack([np.ones(n), np.random.default_rng(1).choice([-1, 1], (DRAWS, n))])
    return np.mean(np.abs(signs @ differences) >= abs(differences.sum()) * (1 - 1e-12))


def holm(p):
    """Holm's correction: adjusted p, in the same order."""
    order, adjusted, least = np.argsort(p), np.empty(len(p)), 0.0
    for i, k in enumerate(order):
        least = max(least, min(1.0, (len(p) - i) * p[k]))
        adjusted[k] = least
    return adjusted


def verdict(difference, p, adjusted):
    if p >= 0.05:
        return "no difference"
    return ("**{}**" if adjusted < 0.05 else "{} (uncorrected p)").format("better" if difference < 0 else "worse")


def small(p):
    return f"{p:.2f}" if p >= 0.095 else f"{p:.1g}" if p >= 1e-4 else "< 0.0001"


def metres(value):
    return f"{value:.2f}" if abs(value) >= 1 else f"{value:.4f}" if abs(value) < 0.1 else f"{value:.3f}"


def signed(value):
    return ("+" if value >= 0 else "−") + metres(abs(value))


def table(header, rows):
    """`header`: names and alignment of the columns."""
    lines = [list(header), list(header.values()), *rows]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in lines)
