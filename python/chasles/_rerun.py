"""A run in the viewer of rerun."""

from typing import Any, Optional

import numpy as np

from ._core import UsageError
from ._optional import optional
from .alignment import align

# Times from here on count from 1970 [ns]; earlier ones are durations since an unknown instant.
_SINCE_1970 = 10**17
_LANDMARK_RADII = 0.01, 0.1  # [m]
_LANDMARK_SIGMAS = 0.003, 0.3  # colours from certain to uncertain [m]
_CERTAIN, _UNCERTAIN = np.array([64, 160, 255]), np.array([255, 96, 32])
_PATH, _TRUTH, _ELLIPSOID = [64, 200, 96], [160, 160, 160], [255, 200, 64]


def log_to_rerun(run: Any, recording: Any = None, *, stream: Any = None, root: str = "world", sigmas: float = 3.0,
                 alignment: Optional[str] = None, every: int = 1, jpeg_quality: int = 75) -> Any:
    """Logs a run on the timeline `time`, and returns rerun's RecordingStream. Without `stream` it is the current one, or
    a new one named after the run: `stream.save("run.rrd")` or `stream.spawn()` show what follows, so call them first.

    Below `root`: `body` (the pose over time), `path`, `covariance` (ellipsoids of the position of that many sigmas),
    `landmarks` (radius and colour by their sigma), and `truth`, in the estimate's world after `alignment` ("SE(3)";
    "position + yaw" for a run with an IMU; None chooses). Beside it the plots `sigma` and, with a truth, `error` [m]
    and `nis_per_dof`. recording: with it also its cameras below `body`, and every n-th of its images as JPEG.

    Raises UsageError for a run without estimates and an `every` below 1, ImportError without rerun."""
    if every < 1:
        raise UsageError(f"log_to_rerun: every: found {every}, expected 1 or more")
    if len(run.states["time"]) == 0:
        raise UsageError("log_to_rerun: the run has no estimate, expected one or more")
    rr = optional("rerun", "rerun-sdk")
    stream = stream or rr.get_global_data_recording() or rr.RecordingStream(f"chasles_{run.name}")
    log = _Log(rr, stream, root)
    log.estimates(run.states, sigmas)
    log.landmarks(run.landmarks)
    if len(run.truth["time"]) > 0:
        log.truth(run, alignment or ("position + yaw" if run._core._level else "SE(3)"))
    if recording is not None:
        log.recording(recording, every, jpeg_quality)
    return stream


def _quaternions(R):
    """(N, 4) x y z w of rotations (N, 3, 3): the largest eigenvector of a symmetric matrix, without a case for each sign."""
    K = np.empty((len(R), 4, 4))
    trace = np.trace(R, axis1=1, axis2=2)
    K[:, :3, :3] = R + R.transpose(0, 2, 1) - trace[:, None, None] * np.eye(3)
    K[:, 3, :3] = K[:, :3, 3] = np.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], 1)
    K[:, 3, 3] = trace
    return np.linalg.eigh(K)[1][:, :, 3]


def _ellipsoids(covariances):
    """Semi-axes of one sigma (N, 3) and quaternions of the axes (N, 4)."""
    squares, axes = np.linalg.eigh(covariances)
    axes[np.linalg.det(axes) < 0, :, 0] *= -1  # a rotation
    return np.sqrt(np.maximum(squares, 0)), _quaternions(axes)


def _has_images(recording):
    try:
        recording.images(0)
    except IndexError:
        return False
    return True


class _Log:
    def __init__(self, rr, stream, root):
        self._rr, self._stream, self._root = rr, stream, root
        self._static("", rr.ViewCoordinates.RIGHT_HAND_Z_UP)

    def _entity(self, name):
        return f"{self._root}/{name}" if name else self._root

    def _static(self, name, *archetypes):
        self._stream.log(self._entity(name), *archetypes, static=True)

    def _send(self, entity, time, columns):
        self._rr.send_columns(entity, [self._times(time)], columns, recording=self._stream)

    def _times(self, time):
        if time[0] >= _SINCE_1970:
            return self._rr.TimeColumn("time", timestamp=time.astype("datetime64[ns]"))
        return self._rr.TimeColumn("time", duration=time.astype("timedelta64[ns]"))

    def _plot(self, entity, time, vectors):
        for axis, values in zip("xyz", vectors.T):
            self._send(f"{entity}/{axis}", time, self._rr.Scalars.columns(scalars=values))

    def estimates(self, states, sigmas):
        rr, time, position = self._rr, states["time"], states["position"]
        self._static("path", rr.LineStrips3D([position], colors=[_PATH]))
        self._send(self._entity("body"), time, rr.Transform3D.columns(translation=position, quaternion=states["quaternion"]))
        covariance = states["pose_covariance"][:, 3:, 3:]
        half_sizes, quaternions = _ellipsoids(covariance)
        self._static("covariance", rr.Ellipsoids3D.from_fields(colors=[_ELLIPSOID]))
        self._send(self._entity("covariance"), time,
                   rr.Ellipsoids3D.columns(centers=position, half_sizes=sigmas * half_sizes, quaternions=quaternions))
        self._plot("sigma/position", time, np.sqrt(np.diagonal(covariance, axis1=1, axis2=2)))
        used = states["nis_dof"] > 0
        if used.any():
            self._send("nis_per_dof", time[used],
                       rr.Scalars.columns(scalars=states["nis"][used] / states["nis_dof"][used]))

    def landmarks(self, landmarks):
        if len(landmarks["id"]) == 0:
            return
        sigma = np.sqrt(np.maximum(np.linalg.eigvalsh(landmarks["covariance"])[:, -1], 0))
        low, high = np.log(_LANDMARK_SIGMAS)
        share = np.clip((np.log(np.maximum(sigma, 1e-12)) - low) / (high - low), 0, 1)[:, None]
        colors = np.rint((1 - share) * _CERTAIN + share * _UNCERTAIN).astype(np.uint8)
        self._static("landmarks", self._rr.Points3D(landmarks["position"], radii=np.clip(sigma, *_LANDMARK_RADII),
                                                    colors=colors))

    def truth(self, run, alignment):
        found = align(run, run.truth, alignment)
        R, p = found["truth_T_estimate"][:3, :3], found["truth_T_estimate"][:3, 3]
        truth = (run.truth["position"] - p) @ R / found["scale"]
        self._static("truth", self._rr.LineStrips3D([truth], colors=[_TRUTH]))
        time, known = run.states["time"], run.truth["time"]
        inside = (known[0] <= time) & (time <= known[-1])
        # From a common origin: int64 nanoseconds since 1970 do not fit a double.
        at = [np.interp(time[inside] - known[0], known - known[0], component) for component in truth.T]
        self._plot("error/position", time[inside], np.stack(at, 1) - run.states["position"][inside])

    def recording(self, recording, every, jpeg_quality):
        rr = self._rr
        for i, camera in enumerate(recording.cameras):
            imu_T_camera = np.linalg.inv(camera.cam_T_imu)
            self._static(f"body/camera_{i}",
                         rr.Transform3D(translation=imu_T_camera[:3, 3], mat3x3=imu_T_camera[:3, :3]),
                         rr.Pinhole(focal_length=[camera.fx, camera.fy], principal_point=[camera.cx, camera.cy],
                                    resolution=[camera.width, camera.height], camera_xyz=rr.ViewCoordinates.RDF))
        if not _has_images(recording):
            return
        for i in range(0, len(recording), every):
            time = recording.frame_times[i : i + 1]
            images = [image for image in enumerate(recording.images(i)) if image[1] is not None]
            for camera, image in images:
                encoded = rr.Image(image).compress(jpeg_quality=jpeg_quality)
                self._set_time(time[0])
                self._stream.log(self._entity(f"body/camera_{camera}"), encoded)

    def _set_time(self, time):
        if time >= _SINCE_1970:
            self._stream.set_time("time", timestamp=np.datetime64(int(time), "ns"))
        else:
            self._stream.set_time("time", duration=np.timedelta64(int(time), "ns"))
