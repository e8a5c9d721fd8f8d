"""A run in rerun's file, read back by rerun."""

import numpy as np
import pytest
import rerun as rr
from rerun.chunk import RrdReader

import chasles
from chasles.interop import align, log_to_rerun


class Logged:
    """The contents of a file, by entity and component."""

    def __init__(self, path):
        self.rows, self.times, self.statics = {}, {}, set()
        for chunk in RrdReader(path).stream():
            batch = chunk.to_record_batch()
            if chunk.is_static:
                self.statics.add(chunk.entity_path)
            for name in batch.schema.names:
                column = batch.column(name).to_pylist()
                if name == "time":
                    self.times.setdefault(chunk.entity_path, []).extend(column)
                else:
                    component = name.rpartition(":")[2]
                    self.rows.setdefault((chunk.entity_path, component), []).extend(column)

    def __getitem__(self, key):
        return self.rows[key]


def logged(tmp_path, run, *arguments, **options):
    path = tmp_path / "run.rrd"
    stream = rr.RecordingStream("test")
    stream.save(path)
    assert log_to_rerun(run, *arguments, stream=stream, **options) is stream
    stream.flush()
    stream.disconnect()
    return Logged(path)


@pytest.fixture(scope="module")
def recording():
    return chasles.simulate("hallway", sections=1)


@pytest.fixture(scope="module")
def run(recording):
    return chasles.run(recording)


def single(rows):
    """Lists of one element as an array."""
    return np.array([row[0] for row in rows if row is not None], dtype=float)


def nanoseconds(times):
    return np.array([np.timedelta64(time, "ns") if not hasattr(time, "value") else time.value for time in times],
                    dtype="timedelta64[ns]").astype(np.int64)


def test_path_and_poses(tmp_path, run):
    log = logged(tmp_path, run)
    states = run.states
    assert np.allclose(single(log["/world/body", "translation"]), states["position"], atol=1e-5)
    assert np.allclose(single(log["/world/body", "quaternion"]), states["quaternion"], atol=1e-6)
    strip = np.array(log["/world/path", "strips"][0][0])
    assert np.allclose(strip, states["position"], atol=1e-5) and "/world/path" in log.statics


def test_times_are_those_of_the_run(tmp_path, run):
    assert np.array_equal(nanoseconds(logged(tmp_path, run).times["/world/body"]), run.states["time"])


def test_ellipsoids_are_the_covariances(tmp_path, run):
    log = logged(tmp_path, run, sigmas=2)
    half = single(log["/world/covariance", "half_sizes"])
    x, y, z, w = single(log["/world/covariance", "quaternions"]).T
    R = np.stack([np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], 1),
                  np.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)], 1),
                  np.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], 1)], 1)
    covariances = np.einsum("nij,nj,nkj->nik", R, (half / 2) ** 2, R)
    expected = run.states["pose_covariance"][:, 3:, 3:]
    assert np.allclose(covariances, expected, atol=1e-5 * expected.max())
    assert np.allclose(single(log["/world/covariance", "centers"]), run.states["position"], atol=1e-5)


def test_landmarks_have_the_size_and_colour_of_their_sigma(tmp_path, run):
    log = logged(tmp_path, run)
    landmarks = run.landmarks
    assert np.allclose(log["/world/landmarks", "positions"][0], landmarks["position"], atol=1e-4)
    sigma = np.sqrt(np.linalg.eigvalsh(landmarks["covariance"])[:, -1])
    radii, colors = np.array(log["/world/landmarks", "radii"][0]), np.array(log["/world/landmarks", "colors"][0])
    assert np.allclose(radii, np.clip(sigma, 0.01, 0.1), atol=1e-6)
    red, blue = colors >> 24, (colors >> 8) & 255
    order = np.argsort(sigma)
    assert np.all(np.diff(red[order]) >= 0) and np.all(np.diff(blue[order]) <= 0)
    assert red[order[0]] < red[order[-1]]


def test_plots_of_sigma_and_error(tmp_path, run):
    log = logged(tmp_path, run)
    error = np.stack([single(log[f"/error/position/{axis}", "scalars"]) for axis in "xyz"], 1)
    sigma = np.stack([single(log[f"/sigma/position/{axis}", "scalars"]) for axis in "xyz"], 1)
    rms = np.sqrt(np.mean(np.sum(error**2, axis=1)))
    assert rms == pytest.approx(run.summary["ate_posyaw_m"], rel=0.01)
    assert np.allclose(sigma**2, np.diagonal(run.states["pose_covariance"], axis1=1, axis2=2)[:, 3:])
    truth = np.array(log["/world/truth", "strips"][0][0])
    found = align(run, run.truth, "position + yaw")["truth_T_estimate"]
    assert np.allclose(truth @ found[:3, :3].T + found[:3, 3], run.truth["position"], atol=1e-4)
    nis = single(log["/nis_per_dof", "scalars"])
    assert np.mean(nis) == pytest.approx(1, abs=0.2)


def test_images_and_cameras_on_the_timeline(tmp_path):
    recording = chasles.simulate("hallway", images=True, sections=1, hall_length=6, frame_rate=5)
    run = chasles.run(recording, max_landmarks=30)
    log = logged(tmp_path, run, recording, every=4)
    camera = recording.cameras[0]
    K = np.array(log["/world/body/camera_0", "image_from_camera"][0][0]).reshape(3, 3).T
    assert np.allclose(K, [[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1]])
    translation = np.array([row[0] for row in log["/world/body/camera_0", "translation"] if row])[0]
    assert np.allclose(translation, np.linalg.inv(camera.cam_T_imu)[:3, 3], atol=1e-6)
    blobs = [row for row in log["/world/body/camera_0", "blob"] if row]
    assert len(blobs) == len(range(0, len(recording), 4))
    times = sorted(nanoseconds(log.times["/world/body/camera_0"]))
    assert times == recording.frame_times[::4].tolist()


def test_a_run_without_truth(tmp_path, run):
    class WithoutTruth:
        name, states, landmarks = run.name, run.states, run.landmarks
        truth = {"time": np.array([], np.int64), "position": np.zeros((0, 3)), "quaternion": np.zeros((0, 4))}

    log = logged(tmp_path, WithoutTruth)
    assert not any(entity.startswith("/error") or entity.endswith("truth") for entity, _ in log.rows)
    assert ("/world/body", "translation") in log.rows


def test_times_since_1970(tmp_path, run):
    class Today:
        name, landmarks = run.name, run.landmarks
        states = {**run.states, "time": run.states["time"] + 1_700_000_000_000_000_000}
        truth = {"time": np.array([], np.int64), "position": np.zeros((0, 3)), "quaternion": np.zeros((0, 4))}

    times = logged(tmp_path, Today).times["/world/body"]
    assert times[0].year == 2023


def test_errors(run):
    with pytest.raises(chasles.UsageError, match="every: found 0"):
        log_to_rerun(run, every=0)
    with pytest.raises(chasles.UsageError, match="alignment: found 'se3'"):
        log_to_rerun(run, alignment="se3", stream=rr.RecordingStream("errors"))
