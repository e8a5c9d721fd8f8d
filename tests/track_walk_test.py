"""studies/track_walk.py on simulated tracks: it finds the white noise and the walk that were added to exact pixels,
whether the poses are known or not, and names a file that is missing or unusable."""

import json
import os
import pathlib
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT))
os.environ["CHASLES_BINARY"] = "/nonexistent/chasles"

try:
    import numpy as np
except ModuleNotFoundError:
    print("skipped: no numpy (tools/deps dev)")
    sys.exit(77)

from studies import adjustment, track_walk
from studies.program import Failed

LENS = np.array([460.0, 457.0, 376.0, 240.0, -0.28, 0.07, 2e-4, 1e-5])
FRAMES, STEP_NS = 60, 50_000_000
WHITE, WALK = 0.1, 0.5


def poses():
    """A camera that sways and turns; the IMU is the camera."""
    t = np.arange(FRAMES) / FRAMES
    p = np.column_stack([2 * t, 0.5 * np.sin(6 * t), 0.3 * np.cos(5 * t)])
    return adjustment.turn(np.column_stack([0.1 * np.sin(4 * t), 0.2 * t, 0.1 * np.cos(3 * t)])), p


def observations(rng):
    """Rows of features.csv: points that are seen in 30 frames each, with a white error and a walk."""
    R, p = poses()
    rows = []
    for landmark in range(250):
        first = int(rng.integers(0, FRAMES - 30))
        at = np.arange(first, first + 30)
        point = p[first + 15] + R[first + 15] @ (rng.uniform([-2, -1, 4], [2, 1, 8]))
        camera = np.einsum("nji,nj->ni", R[at], point - p[at])
        pixel = adjustment.project(camera, LENS)[0]
        steps = WALK * np.sqrt(STEP_NS * 1e-9) * rng.standard_normal((30, 2))
        steps[0] = 0
        pixel += np.cumsum(steps, axis=0) + WHITE * rng.standard_normal((30, 2))
        rows += [(i * STEP_NS, 0, landmark, u, v) for i, (u, v) in zip(at, pixel)]
    return sorted(rows)


def quaternion(R):
    w = np.sqrt(1 + np.trace(R)) / 2
    return [(R[2, 1] - R[1, 2]) / (4 * w), (R[0, 2] - R[2, 0]) / (4 * w), (R[1, 0] - R[0, 1]) / (4 * w), w]


def write_run(folder):
    rng = np.random.default_rng(1)
    rows = [f"{t},{camera},{landmark},{u:.4f},{v:.4f}" for t, camera, landmark, u, v in observations(rng)]
    (folder / "features.csv").write_text("time_ns,camera,landmark,u,v\n" + "\n".join(rows) + "\n")
    R, p = poses()

    def trajectory(name, scatter):
        lines = [" ".join(f"{x:.12f}" for x in [i * STEP_NS * 1e-9, *(p[i] + scatter * rng.standard_normal(3)),
                                                *quaternion(R[i])]) for i in range(FRAMES)]
        (folder / name).write_text("\n".join(lines) + "\n")

    trajectory("truth.tum", 0)
    trajectory("trajectory_smoothed.tum", 0.003)
    summary = {"cameras": [{"imu_T_cam": np.eye(4).tolist(), "intrinsics": LENS[:4].tolist()}]}
    (folder / "summary.json").write_text(json.dumps(summary))
    (folder / "calibration.yaml").write_text("distortion_model: radial-tangential\n"
                                             f"distortion_coefficients: {LENS[4:].tolist()}\n")


class TrackWalk(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.run_folder = pathlib.Path(self.folder.name)
        write_run(self.run_folder)

    def test_finds_the_noise_that_was_added(self):
        for truth in (True, False):
            with self.subTest(truth=truth):
                found = track_walk.measured(self.run_folder, self.run_folder, truth)
                self.assertEqual(found["tracks"], 250)
                self.assertAlmostEqual(found["walk"] / WALK, 1, delta=0.1)
                self.assertAlmostEqual(found["white"] / WHITE, 1, delta=0.15)
                self.assertAlmostEqual(found["median"] / WALK, 1, delta=0.15)

    def test_projection_has_its_derivatives(self):
        rng = np.random.default_rng(2)
        points = rng.uniform([-1, -1, 2], [1, 1, 4], (5, 3))
        pixel, by_point, by_lens = adjustment.project(points, LENS)
        for i in range(3):
            step = np.zeros(3)
            step[i] = 1e-6
            numeric = (adjustment.project(points + step, LENS)[0] - pixel) / 1e-6
            np.testing.assert_allclose(by_point[:, :, i], numeric, rtol=1e-4, atol=1e-3)
        for i in range(len(LENS)):
            step = np.zeros(len(LENS))
            step[i] = 1e-6
            numeric = (adjustment.project(points, LENS + step)[0] - pixel) / 1e-6
            np.testing.assert_allclose(by_lens[:, :, i], numeric, rtol=1e-4, atol=1e-3)

    def test_bad_input_is_named(self):
        calibration = self.run_folder / "calibration.yaml"
        calibration.write_text("distortion_model: equidistant\ndistortion_coefficients: [0, 0, 0, 0]\n")
        with self.assertRaisesRegex(Failed, "calibration.yaml: found distortion_model equidistant, expected none or"):
            track_walk.measured(self.run_folder, self.run_folder, False)
        calibration.unlink()
        with self.assertRaisesRegex(Failed, "found neither .*sensor.yaml nor .*calibration.yaml, expected"):
            track_walk.measured(self.run_folder, self.run_folder, False)
        (self.run_folder / "features.csv").unlink()
        with self.assertRaisesRegex(Failed, "features.csv is missing, expected a run with --keep-images 1"):
            track_walk.measured(self.run_folder, self.run_folder, False)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
