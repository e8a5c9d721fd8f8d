"""calibrate_cameras() against OpenCV's calibrateCamera(), with the same corners and the same lens."""

import time

import numpy as np
import pytest

import chasles

SIZE = (752, 480)
CORNERS = np.array([[0.08 * i, 0.08 * j, 0.0] for j in range(6) for i in range(8)])
K = np.array([[458.7, 0, 367.2], [0, 457.3, 248.4], [0, 0, 1]])
COEFFICIENTS = np.array([-0.283, 0.074, 0.0002, 0.00002])
SIGMA = 0.2


def white_noise(rng, most):
    """(corners, 2) [px]; no error is longer than `most` sigma."""
    errors = rng.normal(0, SIGMA, (20 * len(CORNERS), 2))
    return errors[np.linalg.norm(errors, axis=1) < most * SIGMA][: len(CORNERS)]


def views_of_board(cv2, most, count=40):
    rng = np.random.default_rng(3)
    views = []
    for i in range(count):
        turn = np.append(rng.uniform(-0.7, 0.7, 2), rng.uniform(-0.3, 0.3))
        place = rng.uniform(0.5, 0.9) * np.array([*rng.uniform([-0.45, -0.25], [0.45, 0.25]), 1])
        place = place - cv2.Rodrigues(turn)[0] @ CORNERS.mean(axis=0)
        pixels = cv2.projectPoints(CORNERS, turn, place, K, COEFFICIENTS)[0][:, 0] + white_noise(rng, most)
        ids = np.flatnonzero(((pixels > 2) & (pixels < np.array(SIZE) - 3)).all(axis=1))
        if len(ids) >= 15:
            # calibrateCamera() takes floats of 32 bits.
            views.append((2_000_000_000 * i, 0, ids, pixels[ids].astype(np.float32)))
    return views


def both(cv2, views):
    begin = time.perf_counter()
    ours = chasles.calibrate_cameras(CORNERS.astype(np.float32), views, [SIZE], "radtan", bend=False)
    middle = time.perf_counter()
    rms, matrix, coefficients, _, _, sigmas, _, _ = cv2.calibrateCameraExtended(
        [CORNERS[ids].astype(np.float32) for _, _, ids, _ in views], [pixels for *_, pixels in views], SIZE, None, None,
        flags=cv2.CALIB_FIX_K3, criteria=(cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 200, 1e-16))
    print(f"{len(views)} views: {middle - begin:.2f} s with guess and halves, OpenCV {time.perf_counter() - middle:.2f} s")
    theirs = np.array([matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2], *np.ravel(coefficients)[:4]])
    return ours, rms, theirs, np.ravel(sigmas)[:8]


def test_the_optimum_is_that_of_opencv():
    import cv2

    # Errors within the quadratic part of the loss: OpenCV has none.
    ours, rms, theirs, _ = both(cv2, views_of_board(cv2, 2.4))
    names, values, sigmas = ours.parameters
    assert names == [f"cam0.{name}" for name in ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2")]
    assert ours.rms[0] == pytest.approx(rms, rel=1e-6)
    # The tangential coefficients are near zero.
    assert values[:6] == pytest.approx(theirs[:6], rel=1e-5)
    assert (abs(values - theirs) < 1e-3 * sigmas).all()


def test_the_sigmas_are_those_of_opencv_for_white_noise():
    import cv2

    ours, _, _, theirs = both(cv2, views_of_board(cv2, 10))
    assert 1 <= ours.correlation_factor < 1.5
    assert ours.parameters.sigmas / ours.correlation_factor**0.5 == pytest.approx(theirs, rel=0.03)
