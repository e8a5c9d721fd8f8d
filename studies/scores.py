#!/usr/bin/env python3
"""python3 -m studies.scores SQUARE TRUTH: scores of poses and covariances by smfeval, and the scale of the path.
Both files are those of `chasles export RUN -o run.square --truth truth.tum`. Prints JSON: `scale` and, of smfeval,
`k` (median NEES of the position over that of chi-square), `coverage` (share of the positions in their 90 % ellipsoid)
and `crps` [m]. Call it with the Python of tools/studies-venv, which has numpy and smfeval."""

import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from studies.arrays import Array, rotations, tum
from studies.program import Json, parser

SMFEVAL = pathlib.Path(sys.prefix) / "bin/smfeval"
SECONDS = 600  # of a call
TRIANGLE = np.tril_indices(6)  # of a covariance in SQUARE, row by row


def matched(square: pathlib.Path, truth: pathlib.Path) -> tuple[Array, Array]:
    """The rows of both files that have the same time."""
    rows, true_rows = tum(square), tum(truth)
    _, i, j = np.intersect1d(rows[:, 0], true_rows[:, 0], return_indices=True)
    return rows[i], true_rows[j]


def scale_to_truth(positions: Array, true_positions: Array) -> float:
    """The factor on the positions that fits the truth best (Umeyama 1991), below 1 if the estimate is too large."""
    a, b = (p - p.mean(axis=0) for p in (positions, true_positions))
    U, d, Vt = np.linalg.svd(b.T @ a)
    d[2] *= np.sign(np.linalg.det(U) * np.linalg.det(Vt))
    return float(d.sum() / (a**2).sum())


def in_world_axes(rows: Array) -> Array:
    """Rows of SQUARE with a body frame that is parallel to the world. For the CRPS smfeval takes the covariance, which
    is in the axes of the body, for one in the axes of the world (findings/smfeval_crps_axes.sh)."""
    R = rotations(rows[:, 4:8])
    P = np.zeros((len(rows), 6, 6))
    P[:, TRIANGLE[0], TRIANGLE[1]] = P[:, TRIANGLE[1], TRIANGLE[0]] = rows[:, 8:]
    for block in (slice(0, 3), slice(3, 6)):
        P[:, block, :] = R @ P[:, block, :]
        P[:, :, block] = P[:, :, block] @ R.transpose(0, 2, 1)
    return np.column_stack([without_rotation(rows), P[:, TRIANGLE[0], TRIANGLE[1]]])


def without_rotation(rows: Array) -> Array:
    return np.column_stack([rows[:, :4], np.tile([0, 0, 0, 1.0], (len(rows), 1))])


def smfeval(verb: str, square: pathlib.Path, truth: pathlib.Path, *more: str) -> Json:
    command = [str(SMFEVAL), verb, str(square), str(truth), "--ref-body-frame", "imu", "--json", *more]
    done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS)
    if done.returncode != 0:
        sys.exit(f"studies/scores.py: smfeval {verb} ended with {done.returncode}: {done.stderr.strip()}")
    found: Json = json.loads(done.stdout)
    return found


def crps(square: pathlib.Path, truth: pathlib.Path, rows: Array, true_rows: Array) -> float:
    """[m] Mean over poses and axes of the position's continuous ranked probability score."""
    header = "".join(line for line in square.read_text().splitlines(keepends=True) if line.startswith("#"))
    with tempfile.TemporaryDirectory() as name:
        turned, reference = pathlib.Path(name) / "turned.square", pathlib.Path(name) / "turned.tum"
        np.savetxt(turned, in_world_axes(rows), fmt="%.17g", header=header.rstrip(), comments="")
        np.savetxt(reference, without_rotation(true_rows), fmt="%.17g")
        # The samples are for other scores.
        found = smfeval("score", turned, reference, "--n_samples", "2")
    return float(found["scores"]["translation_crps"]["mean"])


def scores(square: pathlib.Path, truth: pathlib.Path) -> Json:
    rows, true_rows = matched(square, truth)
    verdict = smfeval("nees", square, truth)
    return {"scale": scale_to_truth(rows[:, 1:4], true_rows[:, 1:4]), "k": verdict["k"],
            "coverage": verdict["coverage"], "crps": crps(square, truth, rows, true_rows)}


def main() -> None:
    arguments = parser(__doc__)
    for name in ("square", "truth"):
        arguments.add_argument(name, type=pathlib.Path, metavar=name.upper())
    chosen = arguments.parse_args()
    print(json.dumps(scores(chosen.square, chosen.truth)))


if __name__ == "__main__":
    main()
