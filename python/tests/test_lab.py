"""Charts and depth rules that are written in Python, against those of the library; studies and comparisons."""

import numpy
import pytest

import chasles


def hat(v):
    return numpy.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0.0]])


def exp(theta):
    angle = numpy.linalg.norm(theta)
    if angle < 1e-9:
        return numpy.eye(3) + hat(theta)
    K = hat(theta / angle)
    return numpy.eye(3) + numpy.sin(angle) * K + (1 - numpy.cos(angle)) * K @ K


def log(R):
    v = numpy.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
    sine, cosine = numpy.linalg.norm(v), (numpy.trace(R) - 1) / 2
    return v if sine < 1e-9 else v * numpy.arctan2(sine, cosine) / sine


def left_jacobian(theta):
    angle = numpy.linalg.norm(theta)
    if angle < 1e-6:
        return numpy.eye(3) + hat(theta) / 2
    K = hat(theta / angle)
    return (numpy.eye(3) + (1 - numpy.cos(angle)) / angle * K + (1 - numpy.sin(angle) / angle) * K @ K)


class WorldTwist:
    """The library's right-sen3, written anew."""

    def retract(self, x, xi, dpoints):
        R, J = exp(xi[:3]), left_jacobian(xi[:3])
        return chasles.ChartState(R @ x.R, R @ x.p + J @ xi[3:6], R @ x.v + J @ xi[6:], x.points @ R.T + dpoints @ J.T)

    def local(self, x, y):
        R = y.R @ x.R.T
        theta = log(R)
        inverse = numpy.linalg.inv(left_jacobian(theta))
        xi = numpy.concatenate([theta, inverse @ (y.p - R @ x.p), inverse @ (y.v - R @ x.v)])
        return xi, (y.points - x.points @ R.T) @ inverse.T

    def motion_block(self, x):
        T = numpy.eye(9)
        T[3:6, :3], T[6:, :3] = hat(x.p), hat(x.v)
        return T

    def landmark_block(self, p_world):
        return hat(p_world)


class BodyAttitude:
    """The attitude's error in body axes; the rest additive."""

    def retract(self, x, xi, dpoints):
        return chasles.ChartState(x.R @ exp(xi[:3]), x.p + xi[3:6], x.v + xi[6:], x.points + dpoints)

    def local(self, x, y):
        return numpy.concatenate([log(x.R.T @ y.R), y.p - x.p, y.v - x.v]), y.points - x.points

    def motion_block(self, x):
        T = numpy.eye(9)
        T[:3, :3] = x.R.T
        return T


SHORT = {"sections": 1, "hall_length": 10}


def test_a_chart_in_python_is_that_of_the_library_to_rounding():
    chasles.register_chart("world-twist", WorldTwist())
    walk = chasles.simulate("hallway", **SHORT)
    own = chasles.run(walk, chart="world-twist")
    library = chasles.run(walk, chart="right-sen3")
    assert numpy.allclose(own.states["position"], library.states["position"], rtol=0, atol=1e-9)
    covariance, expected = own.states["pose_covariance"], library.states["pose_covariance"]
    assert numpy.allclose(covariance, expected, rtol=1e-6, atol=1e-9 * abs(expected).max())
    assert own.summary["chart"] == "world-twist"
    standard = chasles.run(walk, chart="standard")
    assert abs(standard.states["position"] - library.states["position"]).max() > 1e-4


def test_a_study_of_charts_finds_the_inconsistent_one(tmp_path):
    chasles.register_chart("body-attitude", BodyAttitude())
    paper = {"landmarks": "cartesian", "init": "fixed-depth"}  # where the chart matters most
    filters = {"own": {"chart": "body-attitude", **paper}, "standard": {"chart": "standard", **paper}, "ours": paper}
    study = chasles.monte_carlo("hallway", filters, runs=2, folder=tmp_path / "study", sections=2, hall_length=12,
                                hall_width=8)
    nees = {name: figures["nees_pose_per_dof"] for name, figures in study.figures.items()}
    # A rotation of the error's axes is no other filter: the same estimates and NEES, up to second order.
    assert nees["own"] == pytest.approx(nees["standard"], rel=0.2)
    assert nees["own"] > 3 * nees["ours"]
    assert study.summary["runs"] == 2 and "own" in study.table and "2 runs" in repr(study)
    curve = study.curves("ours")
    assert len(curve["second"]) > 10 and numpy.isfinite(curve["position_error_m"]).all()
    with pytest.raises(chasles.UsageError, match="no filter 'theirs'; there are own, standard, ours"):
        study.curves("theirs")
    assert study.page().startswith("<!") and "<iframe" in study._repr_html_()
    assert (tmp_path / "study/trials.jsonl").exists()
    with pytest.raises(chasles.UsageError, match="workers: found 2, expected 1"):
        chasles.monte_carlo("hallway", filters, runs=2, workers=2, **SHORT)


def test_workers_change_nothing():
    one, two = (chasles.monte_carlo("hallway", {"ours": {}}, runs=2, workers=workers, **SHORT) for workers in (1, 2))
    assert one.summary == two.summary
    assert one.summary["filters"][0]["diverged"] == 0


@pytest.mark.parametrize(
    "change, message",
    [
        (lambda c: setattr(c, "motion_block", lambda x: numpy.eye(9)), "to be the derivative of local"),
        (lambda c: setattr(c, "local", lambda x, y: numpy.zeros(9)),
         r"error chart 'broken': local returned an array \(9,\), expected a pair of arrays \(\(9,\), \(N, 3\)\)"),
        (lambda c: setattr(c, "local", lambda x, y: (numpy.zeros(3), None)), r"local returned \(an array \(3,\), None\)"),
        (lambda c: setattr(c, "motion_block", lambda x: numpy.eye(3)), r"an array \(3, 3\), expected an array \(9, 9\)"),
        (lambda c: setattr(c, "landmark_block", lambda p: "no"), r"landmark_block returned 'no', expected an array \(3, 3\)"),
        (lambda c: setattr(c, "retract", lambda x, xi, d: None), "retract returned None, expected a ChartState"),
        (lambda c: setattr(c, "local", lambda x, y: (numpy.zeros(9), x.points)), r"expected local\(x, retract\(x, xi\)\) = xi"),
        (lambda c: setattr(c, "retract", lambda x, xi, d: chasles.ChartState(x.R, x.p + 1, x.v, x.points)),
         r"expected retract\(x, 0\) = x, but they differ by 1"),
        (lambda c: setattr(c, "retract", lambda x, xi, d: chasles.ChartState(x.R, x.p, x.v, numpy.zeros((7, 3)))),
         "retract returned points 7 x 3"),
    ])
def test_a_chart_that_is_none_is_rejected(change, message):
    chart = WorldTwist()
    change(chart)
    with pytest.raises((ValueError, TypeError), match=message):
        chasles.register_chart("broken", chart)
    with pytest.raises(chasles.UsageError, match="chart"):
        chasles.run(chasles.simulate("hallway", **SHORT), chart="broken")


def test_names_of_the_library_are_taken():
    with pytest.raises(chasles.UsageError, match="'standard' is one of the library"):
        chasles.register_chart("standard", WorldTwist())
    with pytest.raises(chasles.UsageError, match="'constant' is one of the library"):
        chasles.register_depth_rule("constant", lambda sight: None)


def test_an_error_in_a_chart_is_the_callers():
    class Later(BodyAttitude):
        armed = False

        def motion_block(self, x):
            if self.armed:
                raise ZeroDivisionError("mine")
            return super().motion_block(x)

    chart = Later()
    chasles.register_chart("later", chart)
    chart.armed = True
    with pytest.raises(ZeroDivisionError, match="mine"):
        chasles.run(chasles.simulate("hallway", **SHORT), chart="later")
    with pytest.raises(ZeroDivisionError, match="mine"):
        chasles.monte_carlo("hallway", {"later": {"chart": "later"}}, runs=2, **SHORT)


def test_ctrl_c_in_a_rule_ends_a_study():
    def interrupted(sight):
        raise KeyboardInterrupt

    chasles.register_depth_rule("interrupted", interrupted)
    filters = {"own": {"init": "fixed-depth", "depth_rule": "interrupted"}}
    with pytest.raises(KeyboardInterrupt):
        chasles.monte_carlo("hallway", filters, runs=2, **SHORT)


@pytest.mark.parametrize("use", [lambda slam, walk: slam.started, lambda slam, walk: chasles.run(walk),
                                 lambda slam, walk: chasles.command("--version")])
def test_a_rule_that_uses_an_estimator_does_not_wait_for_ever(use):
    walk = chasles.simulate("hallway", **SHORT)
    slam = chasles.Slam(walk.cameras, walk.imu_noise)
    chasles.register_depth_rule("nosy", lambda sight: use(slam, walk))
    with pytest.raises(chasles.UsageError, match="would wait for itself for ever"):
        chasles.run(walk, init="fixed-depth", depth_rule="nosy")
    assert not slam.started  # the turn is given back


def test_a_depth_rule_sees_what_the_filter_sees():
    walk = chasles.simulate("hallway", **SHORT)
    seen = []

    def of_the_scene(sight):
        """Half of the median depth of the known landmarks in view, if there are any."""
        seen.append(sight)
        camera_T_world = numpy.linalg.inv(sight.world_T_camera)
        depth = (sight.points @ camera_T_world[:3, :3].T + camera_T_world[:3, 3])[:, 2]
        depth = depth[depth > 0.5]
        mean = numpy.median(depth) if len(depth) else 8.0
        return (mean, mean / 2) if not sight.inverse else (1 / mean, 0.5 / mean)

    chasles.register_depth_rule("of-the-scene", of_the_scene)
    own = chasles.run(walk, init="fixed-depth", depth_rule="of-the-scene")
    assert len(seen) > 20 and own.summary["ate_m"] < 0.5
    assert all(s.inverse and s.ray[2] == 1 and s.camera == 0 for s in seen)
    assert max(len(s.points) for s in seen) > 5
    assert not any(numpy.shares_memory(getattr(seen[0], name), getattr(seen[0], name)) for name in ("points", "ray", "pixel"))
    constant = chasles.run(walk, init="fixed-depth")
    assert abs(own.states["position"] - constant.states["position"]).max() > 1e-6
    chasles.register_depth_rule("wrong", lambda sight: (-1, 1))
    with pytest.raises(chasles.UsageError, match=r"depth rule 'wrong': found -1 \+- 1"):
        chasles.run(walk, init="fixed-depth", depth_rule="wrong")
    chasles.register_depth_rule("wrong", lambda sight: 5.0)
    with pytest.raises(TypeError, match=r"depth rule 'wrong' returned 5.0, expected \(mean, sigma\), or None"):
        chasles.run(walk, init="fixed-depth", depth_rule="wrong")
    with pytest.raises(chasles.UsageError, match="of-the-scene"):
        chasles.run(walk, init="fixed-depth", depth_rule="of-the-scenery")


def test_a_comparison_is_the_runs_one_by_one():
    walk = chasles.simulate("hallway", **SHORT)
    comparison = chasles.compare(walk, {"filter": {}, "window": {"estimator": "window:10"}}, chart="right-se3")
    alone = chasles.run(walk, estimator="window:10", chart="right-se3")
    assert (comparison.runs["window"].states["position"] == alone.states["position"]).all()
    assert comparison.figures["filter"]["chart"] == "right-se3"
    page = comparison.page()
    assert "window" in page and page.startswith("<!")
    with pytest.raises(chasles.UsageError, match="estimators: found none"):
        chasles.compare(walk, {})
