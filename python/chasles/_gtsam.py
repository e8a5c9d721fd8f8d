"""The problem of batch estimation, also as a factor graph of gtsam."""

from typing import Any, Dict, Tuple

import numpy as np

from ._core import UsageError
from ._optional import optional

# gtsam's covariance of a preintegration is singular for fewer steps, as that of docs/batch.md: intervals are divided.
_MANY_STEPS = 6
# A walk below this one counts as this one, as in docs/batch.md.
_LEAST_WALK = 1e-7


def batch_problem(run: Any, part: int = 0) -> Dict[str, Any]:
    """The problem that a batch run with an IMU has solved, at its minimum (docs/batch.md, section 1), for other solvers.

    run: of chasles.run(..., estimator="batch") in this process. part: where gaps of the IMU divide the recording. Returns
    a dictionary, with the world `nav` (z up) and time on the IMU's clock:

        keyframes   `time`, `position`, `quaternion`, `velocity`, `accelerometer_bias`, `gyroscope_bias`
        start       the prior on the first keyframe, of the same columns, and `covariance` (15, 15) of [rotation,
                    position, velocity, accelerometer bias, gyroscope bias]: R = Exp(theta) R_start in world axes, the
                    others are differences
        samples     by `keyframe` (the one before): `tau` [s], mean `specific_force` and `angular_rate` over it,
                    `noise_scale` (factor on the variances) and extra densities, which is the case where samples are missing
        landmarks   `id`, `position`
        views       `landmark` (its row), `keyframe`, `camera`, `pixel` (N, 2), `sigma` [px], `delay` of its line after the keyframe with a rolling
                    shutter [s]: those that the gate left
        cameras, imu_noise, gravity, loss ("none", "huber", "cauchy") beyond loss_width sigmas of a pixel
        inverse_depth_sigma     of the weak prior of a landmark's inverse depth, mean 0, in the camera of its first view;
                                None for Cartesian landmarks
        cost                    half of the weighted squares; of it that prior has inverse_depth_cost,
                                and that of an estimated calibration calibration_cost
        landmarks_beyond_infinity   landmarks in the cost without a position

    Raises UsageError for a run without such a problem."""
    parts = run._core._batch
    if not parts:
        raise UsageError("batch_problem: the run has no problem of batch estimation; expected a run of this process, of a "
                         "recording with an IMU: chasles.run(recording, estimator=\"batch\")")
    if not 0 <= part < len(parts):
        raise UsageError(f"batch_problem: part: found {part}, expected 0 to {len(parts) - 1}")
    return parts[part]


def gtsam_graph(run: Any, part: int = 0) -> Tuple[Any, Any]:
    """The problem of a batch run (batch_problem) as gtsam's NonlinearFactorGraph, and its minimum as Values. Keys are
    X(k), V(k), B(k) for pose, velocity and biases of keyframe k, and L(i) for landmark i of batch_problem.

    IMU terms are GalileanCombinedImuFactor, which integrates as Chasles does, pixels GenericProjectionFactor with the
    robust loss. The priors of the first keyframe and of the inverse depths are linear factors at the minimum.
    docs/interoperation.md has the differences. Raises UsageError for a run without such a problem and for a lens that
    gtsam does not have, ImportError without gtsam 4.3."""
    problem = batch_problem(run, part)
    return _Graph(_gtsam(), problem).all()


def _gtsam():
    gtsam = optional("gtsam", "'gtsam>=4.3'")
    if not hasattr(gtsam, "GalileanCombinedImuFactor"):
        raise ImportError("gtsam: found one without GalileanCombinedImuFactor, expected 4.3 or later: pip install "
                          "'gtsam>=4.3'", name="gtsam")
    return gtsam


def _rotation(gtsam, xyzw):
    x, y, z, w = xyzw
    return gtsam.Rot3.Quaternion(w, x, y, z)


class _Graph:
    def __init__(self, gtsam, problem):
        self._gtsam, self._problem = gtsam, problem
        self._graph, self._values = gtsam.NonlinearFactorGraph(), gtsam.Values()
        self._X, self._V, self._B, self._L = (getattr(gtsam.symbol_shorthand, letter) for letter in "XVBL")

    def all(self):
        self._add_values()
        self._add_start()
        self._add_samples()
        self._add_inverse_depths()
        self._add_views()
        return self._graph, self._values

    def _pose(self, columns, k=None):
        at = (lambda name: columns[name]) if k is None else (lambda name: columns[name][k])
        return self._gtsam.Pose3(_rotation(self._gtsam, at("quaternion")), np.array(at("position")))

    def _bias(self, columns, k=None):
        force, rate = columns["accelerometer_bias"], columns["gyroscope_bias"]
        return self._gtsam.imuBias.ConstantBias(*((force, rate) if k is None else (force[k], rate[k])))

    def _add_values(self):
        keyframes = self._problem["keyframes"]
        for k in range(len(keyframes["time"])):
            self._values.insert(self._X(k), self._pose(keyframes, k))
            self._values.insert(self._V(k), keyframes["velocity"][k])
            self._values.insert(self._B(k), self._bias(keyframes, k))
        for i, position in enumerate(self._problem["landmarks"]["position"]):
            self._values.insert(self._L(i), position)

    def _add_start(self):
        # gtsam has no prior over pose, velocity and biases together. A linear factor at the minimum has the cost of the
        # prior there, its gradient and its information; farther away it is linearised.
        gtsam, start, keyframes = self._gtsam, self._problem["start"], self._problem["keyframes"]
        pose, mean = self._pose(keyframes, 0), self._pose(start)
        theta = gtsam.Rot3.Logmap(pose.rotation().compose(mean.rotation().inverse()))
        names = "position", "velocity", "accelerometer_bias", "gyroscope_bias"
        error = np.concatenate([theta, *(keyframes[name][0] - start[name] for name in names)])
        # By gtsam's errors of the pose: rotation and position in its own axes. Of -theta, because theta is in the world's.
        R = pose.rotation().matrix()
        by_errors = np.eye(15)
        by_errors[:3, :3], by_errors[3:6, 3:6] = gtsam.Rot3.LogmapDerivative(-theta) @ R, R
        sigmas = np.sqrt(np.diag(start["covariance"]))
        root = np.linalg.cholesky(start["covariance"] / np.outer(sigmas, sigmas))
        whitened = np.linalg.solve(root, np.diag(1 / sigmas))
        A = whitened @ by_errors
        factor = gtsam.JacobianFactor(self._X(0), A[:, :6], self._V(0), A[:, 6:9], self._B(0), A[:, 9:], -whitened @ error,
                                      gtsam.noiseModel.Unit.Create(15))
        at = gtsam.Values()
        at.insert(self._X(0), pose)
        at.insert(self._V(0), keyframes["velocity"][0])
        at.insert(self._B(0), self._bias(keyframes, 0))
        self._graph.add(gtsam.LinearContainerFactor(factor, at))

    def _params(self, weights, samples, rows):
        """Of a preintegration; densities are means over its time."""
        gtsam, noise = self._gtsam, self._problem["imu_noise"]
        # MakeSharedU points down by the given magnitude.
        params = gtsam.PreintegrationCombinedParams.MakeSharedU(-self._problem["gravity"][2])
        scale = weights @ samples["noise_scale"][rows]
        force = noise.accelerometer_noise_density**2 * scale + weights @ samples["accelerometer_extra_density"][rows] ** 2
        rate = noise.gyroscope_noise_density**2 * scale + weights @ samples["gyroscope_extra_density"][rows] ** 2
        params.setAccelerometerCovariance(force * np.eye(3))
        params.setGyroscopeCovariance(rate * np.eye(3))
        params.setIntegrationCovariance(np.zeros((3, 3)))
        params.setBiasAccCovariance(max(noise.accelerometer_random_walk, _LEAST_WALK) ** 2 * np.eye(3))
        params.setBiasOmegaCovariance(max(noise.gyroscope_random_walk, _LEAST_WALK) ** 2 * np.eye(3))
        return params

    def _add_samples(self):
        gtsam, keyframes, samples = self._gtsam, self._problem["keyframes"], self._problem["samples"]
        ends = np.searchsorted(samples["keyframe"], np.arange(len(keyframes["time"])))
        for k in range(len(keyframes["time"]) - 1):
            rows = slice(ends[k], ends[k + 1])
            tau = samples["tau"][rows]
            preintegrated = gtsam.PreintegratedCombinedMeasurementsG(
                self._params(tau / tau.sum(), samples, rows), self._bias(keyframes, k))
            pieces = 1 if len(tau) >= _MANY_STEPS else _MANY_STEPS
            for seconds, force, rate in zip(tau, samples["specific_force"][rows], samples["angular_rate"][rows]):
                for _ in range(pieces):
                    preintegrated.integrateMeasurement(force, rate, seconds / pieces)
            self._graph.add(gtsam.GalileanCombinedImuFactor(self._X(k), self._V(k), self._X(k + 1), self._V(k + 1),
                                                            self._B(k), self._B(k + 1), preintegrated))

    def _add_inverse_depths(self):
        sigma, cameras = self._problem["inverse_depth_sigma"], self._problem["cameras"]
        if sigma is None:
            return
        gtsam, views = self._gtsam, self._problem["views"]
        unit = gtsam.noiseModel.Unit.Create(1)
        anchors = np.unique(views["landmark"], return_index=True)[1]
        for i, (k, c) in enumerate(zip(views["keyframe"][anchors].tolist(), views["camera"][anchors].tolist())):
            pose, point = self._values.atPose3(self._X(k)), self._values.atPoint3(self._L(i))
            R = pose.rotation().matrix()
            in_imu = R.T @ (point - pose.translation())
            forward, offset = cameras[c].cam_T_imu[2, :3], cameras[c].cam_T_imu[2, 3]
            inverse = 1 / (forward @ in_imu + offset)
            # By gtsam's errors of the pose, rotation and position in its own axes, and by the point.
            by_depth = -(inverse**2) / sigma
            by_pose = by_depth * np.concatenate([np.cross(forward, in_imu), -forward])
            at = gtsam.Values()
            at.insert(self._X(k), pose)
            at.insert(self._L(i), point)
            factor = gtsam.JacobianFactor(self._X(k), by_pose[None], self._L(i), by_depth * (forward @ R.T)[None],
                                          np.array([-inverse / sigma]), unit)
            self._graph.add(gtsam.LinearContainerFactor(factor, at))

    def _noise(self, sigma):
        noise, width = self._gtsam.noiseModel, self._problem["loss_width"]
        plain = noise.Isotropic.Sigma(2, sigma)
        if self._problem["loss"] == "none":
            return plain
        estimator = noise.mEstimator.Huber if self._problem["loss"] == "huber" else noise.mEstimator.Cauchy
        return noise.Robust.Create(estimator.Create(width), plain)

    def _add_views(self):
        lenses = [_lens(self._gtsam, camera) for camera in self._problem["cameras"]]
        imu_T_cameras = [self._gtsam.Pose3(np.linalg.inv(camera.cam_T_imu)) for camera in self._problem["cameras"]]
        views, noises = self._problem["views"], {}
        for i, k, c, pixel, sigma in zip(*(views[name].tolist() for name in ("landmark", "keyframe", "camera")),
                                         views["pixel"], views["sigma"].tolist()):
            if sigma not in noises:
                noises[sigma] = self._noise(sigma)
            factor, lens = lenses[c]
            # A point behind a camera has a constant error, and does not end the search.
            self._graph.add(factor(pixel, noises[sigma], self._X(k), self._L(i), lens, False, False, imu_T_cameras[c]))


def _lens(gtsam, camera):
    """The factor and the calibration of a camera."""
    if camera.readout_time > 0:
        raise UsageError(f"gtsam_graph: found a rolling shutter of {1e3 * camera.readout_time:.1f} ms; expected a global one: "
                         "the factors of gtsam take all lines of an image as of one time (batch_problem's views have a delay)")
    pinhole = camera.fx, camera.fy, 0.0, camera.cx, camera.cy
    if camera.distortion == "none":
        return gtsam.GenericProjectionFactorCal3_S2, gtsam.Cal3_S2(*pinhole)
    if camera.distortion == "equidistant":
        return gtsam.GenericProjectionFactorCal3Fisheye, gtsam.Cal3Fisheye(*pinhole, *camera.coefficients)
    if camera.distortion != "radtan":
        raise UsageError(f"gtsam_graph: found the lens model {camera.distortion}; expected none, radtan with k1, k2, p1 and p2, "
                         "or equidistant, which gtsam has: calibrate with one of these")
    if len(camera.coefficients) > 4:
        what = f"k3 = {camera.coefficients[4]}" if len(camera.coefficients) == 5 else f"{len(camera.coefficients)} coefficients"
        raise UsageError(f"gtsam_graph: found a radtan lens with {what}; gtsam's Cal3DS2 has k1, k2, "
                         "p1 and p2: calibrate with these four, or with the equidistant model")
    return gtsam.GenericProjectionFactorCal3DS2, gtsam.Cal3DS2(*pinhole, *camera.coefficients)
