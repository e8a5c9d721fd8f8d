"""calibrate_cameras() on simulated corners, which numpy projects by itself."""

import copy

import numpy
import pytest

import chasles

SIZE = (752, 480)
LEFT = {"fx": 458.7, "fy": 457.3, "cx": 367.2, "cy": 248.4, "k": [-0.283, 0.074, 0.0002, 0.00002]}
RIGHT = {"fx": 461.0, "fy": 460.1, "cx": 379.9, "cy": 255.2, "k": [-0.28, 0.07, -0.0001, 0.0003]}
#: cam1_T_cam0
RIGHT_TURN, RIGHT_PLACE = numpy.array([0.01, -0.02, 0.005]), numpy.array([-0.11, 0.001, 0.002])
CORNERS = numpy.array([[0.08 * i, 0.08 * j, 0.0] for j in range(6) for i in range(8)])
SIGMA = 0.2


def rotation(vector):
    """Rodrigues' formula."""
    angle = numpy.linalg.norm(vector)
    x, y, z = vector / angle
    K = numpy.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return numpy.eye(3) + numpy.sin(angle) * K + (1 - numpy.cos(angle)) * K @ K


def pixels_of(camera, points):
    """Brown and Conrady's model of the points (N, 3) in the camera."""
    x, y = points[:, 0] / points[:, 2], points[:, 1] / points[:, 2]
    k1, k2, p1, p2 = camera["k"]
    r2 = x * x + y * y
    radial = 1 + k1 * r2 + k2 * r2 * r2
    u = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    v = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    return numpy.column_stack([camera["fx"] * u + camera["cx"], camera["fy"] * v + camera["cy"]])


def simulated(cameras=2, instants=40, seed=1):
    """Views of the board, which is held in all parts of the image, tilted by up to 40 degrees."""
    rng = numpy.random.default_rng(seed)
    middle = CORNERS.mean(axis=0)
    turns, places = [numpy.eye(3), rotation(RIGHT_TURN)], [numpy.zeros(3), RIGHT_PLACE]
    views = []
    for i in range(instants):
        turn = rotation(numpy.append(rng.uniform(-0.7, 0.7, 2), rng.uniform(-0.3, 0.3)))
        place = rng.uniform(0.5, 0.9) * numpy.array([*rng.uniform([-0.45, -0.25], [0.45, 0.25]), 1])
        board = (CORNERS - middle) @ turn.T + place
        for c, camera in enumerate((LEFT, RIGHT)[:cameras]):
            pixels = pixels_of(camera, board @ turns[c].T + places[c]) + rng.normal(0, SIGMA, (len(CORNERS), 2))
            inside = ((pixels > 2) & (pixels < numpy.array(SIZE) - 3)).all(axis=1)
            ids = rng.permutation(numpy.flatnonzero(inside))
            if len(ids) >= 15:
                views.append((2_000_000_000 * i, c, ids, pixels[ids]))
    return views


@pytest.fixture(scope="module")
def stereo():
    return chasles.calibrate_cameras(CORNERS, simulated(), [SIZE, SIZE], "radtan", bend=False)


def test_the_truth_is_within_four_sigma(stereo):
    truth = [*(LEFT[name] for name in ("fx", "fy", "cx", "cy")), *LEFT["k"], *(RIGHT[name] for name in ("fx", "fy", "cx", "cy")),
             *RIGHT["k"], *RIGHT_TURN, *RIGHT_PLACE]
    names, values, sigmas = stereo.parameters
    assert names[0] == "cam0.fx" and names[-1] == "cam1.position_z" and len(names) == len(truth)
    assert (abs(values - truth) < 4 * sigmas).all()
    assert (abs(values - truth) / sigmas).mean() > 0.2
    assert numpy.allclose(numpy.diag(stereo.covariance), sigmas**2, rtol=1e-12, atol=0)
    assert numpy.allclose(stereo.rms, SIGMA * 2**0.5, rtol=0.05) and abs(stereo.pixel_sigma - SIGMA) < 0.01


def test_the_parts_of_a_calibration_agree(stereo):
    left, right = stereo.cameras
    assert (left.width, left.height) == SIZE and left.distortion == "radtan" and stereo.lenses == ["radtan", "radtan"]
    assert left.fx == stereo.parameters.values[0] and right.coefficients == list(stereo.parameters.values[12:16])
    assert (stereo.cam_T_cam0[1] == right.cam_T_imu).all() and (stereo.cam_T_cam0[0] == numpy.eye(4)).all()
    assert numpy.allclose(stereo.cam_T_cam0[1][:3, :3], rotation(stereo.parameters.values[16:19]), rtol=0, atol=1e-12)
    views, errors = stereo.views, stereo.errors
    one = errors["view"] == 3
    pose, camera = views["cam_T_target"][3], stereo.cameras[views["camera"][3]]
    points = CORNERS[errors["id"][one]] @ pose[:3, :3].T + pose[:3, 3]
    k = {"fx": camera.fx, "fy": camera.fy, "cx": camera.cx, "cy": camera.cy, "k": camera.coefficients}
    assert numpy.allclose(errors["pixel"][one] - errors["error"][one], pixels_of(k, points), rtol=0, atol=1e-6)
    assert numpy.isclose(views["rms"][3], numpy.sqrt((errors["error"][one] ** 2).sum(axis=1).mean()))
    assert "cam1.fx" in str(stereo) and "radtan" in repr(stereo) and "<pre>" in stereo._repr_html_()
    stereo.report["cameras"].clear()
    stereo.views["rms"][:] = 0
    assert len(stereo.cameras) == 2 and stereo.views["rms"][3] > 0 and stereo.report["cameras"]


def test_the_projection_is_uncertain_where_no_corners_are(stereo):
    grid = stereo.projection_uncertainty(1)
    away = numpy.linalg.norm(grid["pixel"] - numpy.array(SIZE) / 2, axis=1)
    assert grid["sigma_px"][away.argmax()] > 3 * grid["sigma_px"][away.argmin()] > 0
    assert numpy.allclose(grid["sigma_rad"][away.argmin()] * stereo.cameras[1].fx, grid["sigma_px"][away.argmin()], rtol=0.05)
    with pytest.raises(chasles.UsageError, match="found 2, expected 0 to 1"):
        stereo.projection_uncertainty(2)


def test_halves_agree_within_their_sigmas(stereo):
    halves = stereo.halves
    assert (abs(halves.difference) < 4 * halves.sigma).all()
    assert halves.held_out_rms == pytest.approx(SIGMA * 2**0.5, rel=0.1)
    assert halves.pixels.shape == halves.pixels_sigma.shape == (2,)


def test_the_order_of_views_and_corners_and_the_start_do_not_matter(stereo):
    views = [(time / 1e9, camera, list(ids[::-1]), pixels[::-1, None, :]) for time, camera, ids, pixels in simulated()]
    again = chasles.calibrate_cameras(CORNERS.tolist(), views[::-1], [SIZE, SIZE], ["radtan", "radtan"],
                                      start=stereo.cameras, bend=False)
    assert (abs(again.parameters.values - stereo.parameters.values) < 0.01 * stereo.parameters.sigmas).all()


def test_the_z_axis_of_the_target_may_point_to_the_cameras(stereo):
    turn = numpy.diag([1.0, -1, -1])
    again = chasles.calibrate_cameras(CORNERS @ turn, simulated(), [SIZE, SIZE], "radtan", bend=False)
    assert (again.parameters.values == stereo.parameters.values).all()
    assert (again.views["cam_T_target"][:, :3, :3] @ turn == stereo.views["cam_T_target"][:, :3, :3]).all()


def test_a_bent_board_is_found_and_a_lens_chosen():
    bent = CORNERS + [0, 0, 1] * (0.002 * (1 - ((CORNERS[:, :1] - 0.28) / 0.28) ** 2))
    corners, views = CORNERS.copy(), []
    try:
        CORNERS[:] = bent
        views = simulated(cameras=1, instants=30)
    finally:
        CORNERS[:] = corners
    found = chasles.calibrate_cameras(corners, views, [SIZE], "radtan,equidistant")
    index = found.parameters.names.index("target.bend_x")
    assert abs(found.parameters.values[index] - 0.002) < 4 * found.parameters.sigmas[index] < 0.001
    assert found.lenses == ["radtan"] and len(found.report["cameras"][0]["lenses"]) == 2


def wrong(change, match, **arguments):
    views = [list(view) for view in copy.deepcopy(simulated(cameras=1, instants=6))]
    given = {"corners": CORNERS, "views": views, "sizes": [SIZE], "lenses": "radtan", **arguments}
    change(given["views"])
    with pytest.raises(chasles.InputError, match=match):
        chasles.calibrate_cameras(**given)


def test_views_that_cannot_be_used_are_errors():
    def put(view, part, value):
        return lambda views: views[view].__setitem__(part, value)

    def spoilt(row, column, value):
        return lambda views: views[2][3].__setitem__((row, column), value)

    wrong(put(1, 0, "now"), r"views\[1\]: time: found 'now', expected an int \[ns\] or a finite float \[s\]")
    wrong(put(1, 0, numpy.nan), r"views\[1\]: time")
    wrong(put(1, 1, 1), r"views\[1\]: camera: found 1, expected 0 to 0")
    wrong(put(1, 1, 0.5), r"views\[1\]: camera: found 0.5")
    wrong(put(0, 2, [0, 1, 48, 3]), r"views\[0\]: found 4 ids and \d+ pixels")
    wrong(lambda views: views[0][2].__setitem__(0, 48), r"views\[0\]: found the id 48, expected 0 to 47")
    wrong(lambda views: views[0][2].__setitem__(0, -1), r"views\[0\]: found the id -1")
    wrong(lambda views: views[0][2].__setitem__(0, views[0][2][1]), r"the id \d+ twice")
    wrong(put(0, 2, numpy.full(48, 0.5)), "ids: found an array .* of float64, expected whole numbers")
    wrong(spoilt(4, 1, numpy.nan), r"views\[2\]: pixels: found .*nan.* in row 4, expected finite")
    wrong(put(2, 3, numpy.zeros((48, 3))), r"views\[2\]: pixels: found .*\(48, 3\)")
    wrong(put(2, 3, "far"), r"views\[2\]: pixels: found 'far'")
    wrong(put(3, 0, 4_000_000_000), r"views\[2\] and views\[3\] of camera 0 at the time 4000000000")
    wrong(lambda views: views.__setitem__(0, [1, 2]), r"views\[0\]: found \[1, 2\], expected \(time, camera, ids, pixels\)")
    wrong(lambda views: views.clear(), "cam0: found 0 views")
    wrong(lambda views: None, "found an array .*, expected an array", corners=CORNERS[:, :2])
    wrong(lambda views: None, "row 7, expected finite", corners=numpy.where(numpy.arange(48)[:, None] == 7, numpy.inf, CORNERS))
    wrong(lambda views: None, "not flat", corners=CORNERS + numpy.arange(48)[:, None])
    wrong(lambda views: None, "sizes: found", sizes=[(0, 480)])
    wrong(lambda views: None, "sizes: found", sizes=SIZE)
    wrong(lambda views: None, "start: found cameras", start=chasles.Camera(64, 48, 50, 50, 32, 24))
    views = simulated(cameras=1, instants=6)
    with pytest.raises(chasles.UsageError, match="lenses.*'plastic'"):
        chasles.calibrate_cameras(CORNERS, views, [SIZE], "plastic")
    with pytest.raises(chasles.UsageError, match="expected one str, or one for each of 1"):
        chasles.calibrate_cameras(CORNERS, views, [SIZE], ["radtan", "ds"])


def test_what_the_views_do_not_show_is_uncertain():
    flat = []
    for i in range(10):
        # Parallel to the image: the focal length and the distance have the same effect.
        pixels = pixels_of(LEFT, CORNERS - CORNERS.mean(axis=0) + [0.002 * i, 0, 0.8])
        flat.append((i * 10**9, 0, numpy.arange(len(CORNERS)), pixels + numpy.random.default_rng(i).normal(0, SIGMA, pixels.shape)))
    found = chasles.calibrate_cameras(CORNERS, flat, [SIZE], "none", bend=False)
    assert found.parameters.sigmas[0] > 100 and any("leans by at most" in remark for remark in found.remarks)
