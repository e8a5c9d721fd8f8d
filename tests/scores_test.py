"""studies/scores.py: smfeval's k, coverage and CRPS of poses whose errors are known, and the scale of a path. It needs
the Python of tools/studies-venv, without which it is skipped (exit code 77)."""

import json
import math
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
PYTHON = ROOT / "build/studies-venv/bin/python"
SIGMAS = (0.5, 0.02, 0.1)  # m, forward, left, up; the body drives north
ERRORS = (1, 1, 1, 4)  # of the forward sigma, in turn
POSES = 40


def written(folder):
    """Poses of a body that looks along y of the world, with errors forward alone."""
    header = ["FORMAT SQUARE/0.3", "REPRESENTATION gaussian_se3", "POSE_FRAME world", "BODY_FRAME imu", "GAUGE fixed",
              "TIMESTAMP_UNIT seconds", "ALGORITHM test", "ALGORITHM_VERSION 1",
              "TANGENT_CONVENTION right_perturbation", "TANGENT_ORDER translation_rotation",
              "ROTATION_PARAM axis_angle"]
    q = f"0 0 {math.sqrt(0.5)} {math.sqrt(0.5)}"
    variances = [*(s * s for s in SIGMAS), 1e-4, 1e-4, 1e-4]
    triangle = " ".join(str(variances[i] if i == j else 0) for i in range(6) for j in range(i + 1))
    rows, truths = [], []
    for k in range(POSES):
        rows.append(f"{k / 10} 0 {k} {k % 3} {q} {triangle}")
        truths.append(f"{k / 10} 0 {k + SIGMAS[0] * ERRORS[k % 4]} {k % 3} {q}")
    square, truth = folder / "run.square", folder / "truth.tum"
    square.write_text("".join(f"#%{line}\n" for line in header) + "\n".join(rows) + "\n")
    # The last pose has no truth, and one truth has no pose.
    truth.write_text("# t tx ty tz qx qy qz qw\n" + "\n".join([*truths[:-1], f"99 0 0 0 {q}"]) + "\n")
    return square, truth


def crps_of(error, sigma):
    """Of a Gaussian, by the integral of its definition."""
    steps, reach, total = 20000, 12 * sigma + abs(error), 0.0
    width = 2 * reach / steps
    for i in range(steps):
        x = -reach + (i + 0.5) * width
        total += ((0.5 * (1 + math.erf(x / sigma / math.sqrt(2)))) - (x >= error)) ** 2 * width
    return total


def test_scores(folder):
    square, truth = written(folder)
    command = [PYTHON, "-m", "studies.scores", square, truth]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    errors = [ERRORS[k % 4] for k in range(POSES - 1)]
    # The median of chi-square with three degrees of freedom is 2.366; 90 % are below 6.251.
    assert abs(found["k"] - 1 / 2.36597) < 1e-5, found
    assert abs(found["coverage"] - errors.count(1) / len(errors)) < 1e-12, found
    # Along y the sigma is the forward one, not that of the body's second axis.
    other_axes = crps_of(0, SIGMAS[1]) + crps_of(0, SIGMAS[2])
    expected = sum(crps_of(SIGMAS[0] * e, SIGMAS[0]) + other_axes for e in errors) / 3 / len(errors)
    assert abs(found["crps"] / expected - 1) < 1e-3, (found, expected)
    square.write_text(square.read_text().replace("GAUGE fixed", "GAUGE none"))
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 1 and "studies/scores.py: smfeval nees ended with 2" in done.stderr, done.stderr


def test_scale():
    import numpy as np
    from studies.scores import scale_to_truth
    random = np.random.default_rng(1)
    turn, _ = np.linalg.qr(random.standard_normal((3, 3)))
    turn *= np.linalg.det(turn)
    path = random.standard_normal((50, 3))
    assert abs(scale_to_truth(path, 0.98 * path @ turn.T + [1, 2, 3]) - 0.98) < 1e-12
    # A mirrored path is no rotation: its worst axis counts against the scale.
    assert scale_to_truth(path, path * [1, 1, -1]) < 0.9


def main():
    if not PYTHON.exists():
        print(f"skipped: no {PYTHON} (tools/studies-venv)")
        sys.exit(77)
    if pathlib.Path(sys.prefix) != PYTHON.parent.parent:
        sys.exit(subprocess.run([PYTHON, "-B", __file__]).returncode)
    sys.path.insert(0, str(ROOT))
    test_scale()
    with tempfile.TemporaryDirectory() as name:
        test_scores(pathlib.Path(name))


main()
