"""CaptureGuide and Target: what is missing while views are recorded."""

import numpy
import pytest
from test_calibrate import CORNERS, LEFT, SIZE, simulated

import chasles

BOARD = "target_type: checkerboard\ntargetCols: 6\ntargetRows: 5\nrowSpacingMeters: 0.04\ncolSpacingMeters: 0.04\n"


@pytest.fixture
def board(tmp_path):
    file = tmp_path / "board.yaml"
    file.write_text(BOARD)
    return file


def drawn_board(corner, square):
    """A checkerboard of 7 x 6 squares before a white wall, its first inner corner from the upper left at (x, y)."""
    image = numpy.full((480, 640), 210, numpy.uint8)
    x, y = corner
    for row in range(6):
        for column in range(7):
            if (row + column) % 2 == 1:
                left, top = x + (column - 1) * square, y + (row - 1) * square
                image[top:top + square, left:left + square] = 30
    return image


def test_the_corners_of_an_image_are_found(board):
    target = chasles.Target(board)
    assert target.corners.shape == (30, 3) and numpy.allclose(target.corners[1] - target.corners[0], [0.04, 0, 0])
    ids, pixels = target.find(drawn_board((150, 120), 50))
    assert sorted(ids) == list(range(30)) and pixels.shape == (30, 2)
    # Corners lie between pixels, whose centres are whole numbers.
    expected = numpy.array([[150 + 50 * i - 0.5, 120 + 50 * j - 0.5] for j in range(5) for i in range(6)])
    found = numpy.array(sorted(pixels.tolist(), key=lambda p: (round(p[1] / 50), p[0])))
    assert abs(found - expected).max() < 0.05
    ids, pixels = target.find(numpy.zeros((480, 640), numpy.uint8))
    assert ids.shape == (0,) and pixels.shape == (0, 2)
    with pytest.raises(ValueError, match="image"):
        target.find(numpy.zeros((4, 4, 3), numpy.uint8))
    with pytest.raises(chasles.Error, match="none.yaml"):
        chasles.Target("none.yaml")


@pytest.mark.parametrize("turn", [1, -1])
def test_the_guide_says_what_is_missing_until_it_is_enough(turn):
    guide = chasles.CaptureGuide(CORNERS * [1, turn, turn], [SIZE, SIZE], "radtan")
    assert guide.missing[0].startswith("cam0: it has not seen the target") and guide.focal_lengths == [None, None]
    counts = []
    for time, camera, ids, pixels in simulated(instants=60):
        guide.add(time / 1e9, camera, ids[:, None], pixels[:, None])
        counts.append(len(guide.missing))
    assert counts[0] > 5 > counts[-1], guide.missing
    assert not [one for one in guide.missing if "leans" in one or "together" in one], guide.missing
    focal, sigma = guide.focal_lengths[0]
    assert abs(focal - LEFT["fx"]) < 4 * sigma and sigma < 2


def test_a_target_is_a_target(board):
    target = chasles.Target(board)
    guide = chasles.CaptureGuide(target, [(640, 480)])
    for k in range(3):
        guide.add(1_000_000_000 * k, 0, *target.find(drawn_board((150 + 60 * k, 120), 50)))
    guide.add(9.0, 0, [], [])
    assert [one for one in guide.missing if "parts of its image" in one]


@pytest.mark.parametrize("view, message", [
    ((0, 2, [0], [[1, 1]]), "camera 2"),
    ((0, 0, [99], [[1, 1]]), "from 0 to 47"),
    ((0, 0, [1, 1], [[1, 1], [2, 2]]), "the id 1 twice"),
    ((0, 0, [0.5], [[1, 1]]), "expected whole numbers"),
    ((0, 0, [0, 1], [[1, 1]]), r"expected \(2, 2\)"),
    ((0, 0, [0], [[float("nan"), 1]]), "not finite"),
    ((0, 0, [0], [[-40, 1]]), "expected it in the image"),
    (("now", 0, [0], [[1, 1]]), "time"),
])
def test_what_is_no_view_is_rejected(view, message):
    guide = chasles.CaptureGuide(CORNERS, [SIZE, SIZE])
    with pytest.raises((ValueError, TypeError), match=message):
        guide.add(*view)
    assert guide.missing[0].startswith("cam0: it has not seen")


def test_what_is_no_target_is_rejected():
    for corners, sizes, lenses in [(CORNERS[:, :2], [SIZE], "auto"), (CORNERS, [], "auto"), (CORNERS, [(0, 5)], "auto"),
                                   (CORNERS, [SIZE], "bad")]:
        with pytest.raises((ValueError, TypeError), match="CaptureGuide"):
            chasles.CaptureGuide(corners, sizes, lenses)
