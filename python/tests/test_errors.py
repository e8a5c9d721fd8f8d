"""Run.errors(), its tables and its pictures, against figures computed with numpy and the files of the command."""

import csv
import importlib.util
import xml.etree.ElementTree

import numpy
import pytest

import chasles


@pytest.fixture(scope="module")
def walk():
    return chasles.simulate("hallway", sections=1, hall_length=12)


@pytest.fixture(scope="module")
def run(walk):
    return chasles.run(walk, chart="standard")


def matrices(quaternions):
    x, y, z, w = quaternions.T
    return numpy.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]).transpose(2, 0, 1)


def test_errors_are_truth_minus_estimate(run):
    errors = run.errors()
    n = len(errors["time"])
    assert n > 50 and all(len(errors[name]) == n for name in errors if not name.startswith("world_T"))
    assert numpy.array_equal(errors["position"], run.states["position"][errors["state"]])
    assert numpy.allclose(errors["position_error"], errors["truth_position"] - errors["position"], atol=1e-12)
    turned = matrices(errors["truth_quaternion"]) @ matrices(errors["quaternion"]).transpose(0, 2, 1)
    small = (turned - turned.transpose(0, 2, 1))[:, [2, 0, 1], [1, 2, 0]] / 2  # sin(angle) * axis
    assert numpy.allclose(errors["attitude_error"], small, atol=1e-4)
    sigma = numpy.sqrt(numpy.diagonal(run.states["pose_covariance"], axis1=1, axis2=2))[errors["state"]]
    assert numpy.array_equal(errors["attitude_sigma"], sigma[:, :3]) and numpy.array_equal(errors["position_sigma"], sigma[:, 3:])


def test_the_nees_is_that_of_numpy_and_of_the_summary(run):
    errors = run.errors()
    e = numpy.concatenate([errors["attitude_error"], errors["position_error"]], axis=1)
    P = run.states["pose_covariance"][errors["state"]]
    good = numpy.isfinite(errors["nees_pose"])
    nees = numpy.einsum("ni,ni->n", e[good], numpy.linalg.solve(P[good], e[good][:, :, None])[:, :, 0])
    assert good.sum() > 50
    assert errors["nees_pose"][good] == pytest.approx(nees, rel=1e-6)
    assert numpy.nanmean(errors["nees_pose"]) == pytest.approx(run.summary["nees_pose"], rel=1e-9)
    assert numpy.nanmean(errors["nees_position"]) == pytest.approx(run.summary["nees_position"], rel=1e-9)


def test_the_alignments_are_those_of_the_figures(run):
    errors = run.errors()
    back = numpy.linalg.inv(errors["world_T_truth"])
    truth = errors["truth_position"] @ back[:3, :3].T + back[:3, 3]
    fit = errors["world_T_truth_fit"]
    ate = numpy.sqrt((((truth @ fit[:3, :3].T + fit[:3, 3]) - errors["position"]) ** 2).sum(1).mean())
    assert ate == pytest.approx(run.summary["ate_m"], rel=1e-6)
    assert errors["position_error"][0] == pytest.approx(0, abs=1e-12)  # by the position of the first pose


def test_another_truth_counts(run):
    truth = {name: values.copy() for name, values in run.truth.items()}
    truth["position"] += numpy.linspace(0, 1, len(truth["time"]))[:, None] * [0.3, 0, 0]
    assert abs(run.errors(truth)["position_error"]).max() > 0.2
    truth["time"] = truth["time"] + 10**15
    with pytest.raises(chasles.InputError, match="errors: "):
        run.errors(truth)


def test_without_a_truth_it_says_so(walk, run, tmp_path):
    run.save(tmp_path / "run")
    (tmp_path / "run/truth.tum").unlink()
    arrays = chasles.simulate("hallway", images=True, sections=1, hall_length=6, image_width=320, image_height=240,
                              focal_length=180, center_u=160, center_v=120, frame_rate=10)
    imu = arrays.imu
    none = chasles.Recording.from_arrays(
        imu_time=imu["time"], angular_rate=imu["angular_rate"], specific_force=imu["specific_force"],
        image_time=arrays.frame_times, images=arrays.images, cameras=arrays.cameras, imu_noise=arrays.imu_noise)
    other = chasles.run(none)
    assert not other.has_truth and run.has_truth
    with pytest.raises(chasles.UsageError, match="no truth"):
        other.errors()
    assert "ATE" not in other._repr_html_() and "<svg" in other._repr_html_()


def test_a_dataframe_has_the_columns_of_the_file(walk, run, tmp_path):
    pandas = pytest.importorskip("pandas")
    table = run.to_dataframe()
    run.save(tmp_path / "run")
    with open(tmp_path / "run/states.csv") as file:
        header, first = next(rows := csv.reader(file)), next(rows)
    names = [name for name in header if not name.startswith("cov_")]
    assert list(table.columns) == ["frame", "seconds", "image_time_ns", *names]
    values = dict(zip(header, first))
    for name in ("x", "qw", "sigma_rz", "sigma_z", "velocity_x", "sigma_velocity_x", "nis_dof"):
        assert float(table[name].iloc[0]) == pytest.approx(float(values[name]), rel=1e-9), name
    assert (walk.frame_times[table["frame"].to_numpy(dtype=int)] == table["image_time_ns"]).all()
    assert table["seconds"].iloc[-1] == pytest.approx(1e-9 * (table["time_ns"].iloc[-1] - table["time_ns"].iloc[0]))
    read = chasles.read_run(tmp_path / "run").to_dataframe()
    assert read["frame"].isna().all()
    pandas.testing.assert_series_equal(read["image_time_ns"], table["image_time_ns"])


def test_frames_are_those_of_the_images_where_the_offset_is_estimated():
    images = chasles.simulate("hallway", images=True, sections=1, hall_length=6, image_width=320, image_height=240,
                              focal_length=180, center_u=160, center_v=120, frame_rate=10)
    run = chasles.run(images)
    assert "time_offset" in run.states
    stamps = run._image_times()
    assert numpy.isin(stamps, images.frame_times).all() and (numpy.diff(stamps) > 0).all()
    assert abs(stamps - run.states["time"]).max() < 50_000_000


def test_earlier_names_of_sigmas_stay(run):
    assert run.states["velocity_x_sigma"] is run.states["sigma_velocity_x"]
    with pytest.raises(KeyError, match="there are time"):
        run.states["velocity"]


def test_a_notebook_shows_a_small_picture(run):
    text = run._repr_html_()
    assert len(text) < 60_000 and "ATE" in text and "iframe" not in text
    drawings = [text[begin:text.index("</svg>", begin) + 6] for begin in range(len(text)) if text.startswith("<svg", begin)]
    assert len(drawings) == 2
    path, errors = (xml.etree.ElementTree.fromstring(drawing) for drawing in drawings)
    assert len(path.findall("polyline")) == 2 and len(errors.findall("polyline")) == 10
    for line in [*path.findall("polyline"), *errors.findall("polyline")]:
        x, y = numpy.array([point.split(",") for point in line.get("points").split()], dtype=float).T
        assert x.min() >= 0 and x.max() <= 380 and y.min() >= 0 and y.max() <= 260


def test_plot_draws_the_path_and_the_errors(run):
    pytest.importorskip("matplotlib")
    figure = run.plot()
    path, position, attitude, nees = figure.axes
    assert numpy.array_equal(path.lines[-1].get_xydata(), run.states["position"][:, :2])
    assert numpy.array_equal(position.lines[0].get_ydata(), run.errors()["position_error"][:, 0])
    assert numpy.array_equal(position.lines[2].get_ydata(), 3 * run.errors()["position_sigma"][:, 0])
    assert "deg" in attitude.get_ylabel() and "NEES" in nees.get_ylabel()


@pytest.mark.skipif(importlib.util.find_spec("matplotlib") is not None, reason="matplotlib is installed")
def test_plot_says_what_to_install(run):
    with pytest.raises(ImportError, match="pip install matplotlib"):
        run.plot()


def test_no_change_of_what_a_run_returns_changes_the_run(walk):
    run = chasles.run(walk)
    figures, text = run.evaluate(), repr(run)
    for columns in (run.states, run.smoothed, run.truth, run.landmarks):
        for name, values in columns.items():
            with pytest.raises(ValueError, match="read-only"):
                values[:] = values[::-1].copy()
        columns.update({name: None for name in list(columns)})
    summary = run.summary
    summary["ate_m"] = 99
    summary["settings"].clear()
    assert run.evaluate() == figures and repr(run) == text and run.summary["ate_m"] < 1 and run.summary["settings"]
    study = chasles.monte_carlo("hallway", {"a": {}}, runs=1, sections=1, hall_length=8)
    study.figures["a"].clear()
    assert study.figures["a"]
    check = chasles.check(walk)
    check.findings.append(None)
    check.report.clear()
    assert None not in check.findings and check.report


def test_evaluate_has_the_defaults_of_the_run(run):
    other = chasles.run(chasles.simulate("hallway", sections=1, hall_length=12), chart="right-sen3")
    figures = other.evaluate()
    assert figures["nees_pose"] == pytest.approx(other.summary["nees_pose"], rel=1e-9)
    assert chasles.evaluate(other, other.truth) == figures == chasles.evaluate(other.states, other.truth)
    assert chasles.evaluate(other, other.truth, chart="standard")["nees_pose"] != figures["nees_pose"]
    bare = {name: other.states[name] for name in ("time", "position", "quaternion", "pose_covariance")}
    assert chasles.evaluate(bare, other.truth) == chasles.evaluate(bare, other.truth, chart="standard", level=False)


def test_evaluate_finds_how_the_bodys_axes_of_the_truth_are_turned(run):
    """By two degrees about z, which the estimate's own attitude error of its first second cannot be."""
    half = numpy.radians(2) / 2
    x, y, z, w = run.truth["quaternion"].T
    turned = numpy.stack([x, y, z, w], 1) * numpy.cos(half) + numpy.stack([y, -x, w, -z], 1) * numpy.sin(half)
    truth = {**run.truth, "quaternion": turned}
    found = run.evaluate(truth, truth_errors="auto")["truth_errors"]["body_rotation_deg"]
    known = run.evaluate(truth_errors="auto")["truth_errors"]["body_rotation_deg"]
    assert found["value"][2] - known["value"][2] == pytest.approx(-2, abs=0.7)
    assert "truth_errors" not in run.evaluate(truth)
    with pytest.raises(chasles.UsageError, match="truth_errors: the estimate has no covariances"):
        chasles.evaluate(run.truth, run.truth, truth_errors="auto")
    with pytest.raises(chasles.UsageError, match="truth_errors: the truth has positions alone"):
        run.evaluate({"time": truth["time"], "position": truth["position"]}, truth_errors="auto")


def positions_alone(shift=0):
    """A run of 6 m whose truth has positions, `shift` nanoseconds late."""
    images = chasles.simulate("hallway", images=True, sections=1, hall_length=6, image_width=320, image_height=240,
                              focal_length=180, center_u=160, center_v=120, frame_rate=10)
    imu, truth = images.imu, images.truth
    return images, chasles.run(chasles.Recording.from_arrays(
        imu_time=imu["time"], angular_rate=imu["angular_rate"], specific_force=imu["specific_force"],
        image_time=images.frame_times, images=images.images, cameras=images.cameras, imu_noise=images.imu_noise,
        truth={"time": truth["time"] + shift, "position": truth["position"]}))


def test_a_truth_of_positions_alone_has_no_errors_of_attitude():
    images, run = positions_alone()
    whole = chasles.run(images)
    errors = run.errors()
    assert "quaternion" not in run.truth
    assert numpy.isnan(errors["attitude_error"]).all() and numpy.isnan(errors["nees_pose"]).all()
    assert numpy.nanmean(errors["nees_position"]) < 30
    figures = run.evaluate()
    assert figures["ate_m"] == pytest.approx(whole.summary["ate_m"], rel=1e-6)
    assert figures["attitude_deg"] is None and figures["nees_pose"] is None
    assert "attitude" not in run._repr_html_()
    if importlib.util.find_spec("matplotlib"):
        labels = [axes.get_ylabel() for axes in run.plot().axes]
        assert labels == ["y [m]", "position error [m]", "NEES"]


def test_a_truth_of_another_time_does_not_hide_the_estimate():
    _, run = positions_alone(10**15)
    assert "<svg" in run._repr_html_()
    pytest.importorskip("matplotlib")
    figure = run.plot()
    assert numpy.array_equal(figure.axes[0].lines[0].get_xydata(), run.states["position"][:, :2])
    assert "sigma" in figure.axes[1].get_ylabel()
    title = figure.texts[0].get_text()  # Debian's matplotlib has no get_suptitle()
    assert "have a truth" in title


def test_the_picture_shows_the_story_of_the_summary(run):
    text = run._repr_html_()
    assert f"<td style='text-align:left'>health</td><td>{run.summary['health']}</td>" in text
    assert f"{run.summary['attitude_posyaw_deg']:.3g}°" in text and "aligned by yaw" in text
    assert isinstance(run.states["health"], numpy.ndarray) and run.states["health"][0] in ("ok", "degraded")


def test_legends_cover_no_curve(run):
    pytest.importorskip("matplotlib")
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure = run.plot()
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    for axes in figure.axes:
        legend, frame = axes.get_legend().get_window_extent(), axes.get_window_extent()
        assert legend.y0 >= frame.y1 - 1
        ticks = [tick.label1.get_window_extent() for tick in axes.yaxis.get_major_ticks() if tick.label1.get_text()]
        ticks = sorted((one.y0, one.y1) for one in ticks if frame.y0 <= (one.y0 + one.y1) / 2 <= frame.y1)
        assert all(low[1] <= high[0] for low, high in zip(ticks, ticks[1:])), axes.get_ylabel()
