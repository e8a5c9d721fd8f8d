"""python/examples/aria_to_chasles.py, over a VRS file that projectaria-tools reads, with a calibration that it wrote. The
recording is a rendered walk with two fisheye lenses; the IMU is skewed, biased and late, as Aria's is."""

import json
import re
import subprocess

import numpy as np
import pytest

pytest.importorskip("projectaria_tools")
from PIL import Image  # noqa: E402
from projectaria_tools.core import calibration  # noqa: E402
from projectaria_tools.core.sophus import SE3  # noqa: E402

from conversions import BINARY, chasles, run_example, table  # noqa: E402
from vrs_file import write_vrs  # noqa: E402

pytestmark = pytest.mark.skipif(BINARY is None, reason="CHASLES_BINARY names no command")

# k0 to k5, p0, p1, s0 to s3, about those of a SLAM camera of Aria Gen 1.
LENS = [-0.0269, 0.102, -0.0718, 0.0125, 0.00124, -0.000415, 0.00055, 0.00058, -0.00123, -0.00039, -0.0006, 0.00001]
SIZE, FOCAL, CENTRE = (400, 300), 151.0, (199.3, 150.2)
SKEW_OF_FORCES = np.array([[1.003, -0.0015, -0.0017], [0, 1.0002, -0.0029], [0, 0, 0.9973]])
SKEW_OF_RATES = np.array([[1.001, 0.0044, -0.0004], [-0.0046, 0.9993, -0.0019], [-0.0013, -0.0009, 1.0046]])
BIAS_OF_FORCES, BIAS_OF_RATES = np.array([0.02, 0.04, -0.06]), np.array([0.002, -0.003, 0.001])
INTERVAL, CAMERA_OFFSET = 0.005, 0.0007  # of the samples; of the stamps of images [s]
BEGIN = 100_000_000_000  # when the walk begins, by the clock of the device [ns]
DEVICE_T_IMU = SE3.exp(np.array([0.05, -0.102, -0.086]), np.array([0.3, -1.9, 0.6]))[0]


def convert(*arguments):
    return run_example("aria_to_chasles.py", *arguments)


class Glasses:
    """The walk as it was rendered, as a VRS file, and as the script made it of that."""

    def __init__(self, folder):
        self.folder, self.walk, self.vrs, self.made = folder, folder / "walk", folder / "aria.vrs", folder / "made"
        lens = {f"distortion_{i + 1}": k for i, k in enumerate(LENS)} | {"distortion": "fisheye624", "focal_length": FOCAL}
        scene = lens | {"walk_duration": 10, "cameras": 2, "image_width": SIZE[0], "image_height": SIZE[1],
                        "center_u": CENTRE[0], "center_v": CENTRE[1]}
        sets = [word for name, value in scene.items() for word in ("--set", f"{name}={value}")]
        chasles("simulate", "walk", "--images", *sets, "-o", self.walk, "--quiet")
        self.samples = np.array(table(self.walk / "mav0/imu0/data.csv"), float)
        self.stamps = [int(row[0]) for row in table(self.walk / "mav0/cam0/data.csv")]
        self.calibration = self.calibrated()
        tags = {"calib_json": self.json(), "device_type": "Aria"}
        write_vrs(self.vrs, tags, [self.images(0), self.images(1)], self.raw_samples())
        self.converted = convert(self.vrs, self.made)

    def imu_T_cam(self, camera):
        stated = re.search(r"data: \[([^\]]*)\]", (self.walk / f"mav0/cam{camera}/sensor.yaml").read_text())[1]
        return np.array(stated.split(","), float).reshape(4, 4)

    def calibrated(self):
        cameras, fisheye = {}, np.array([FOCAL, *CENTRE, *LENS])
        for number, label in enumerate(["camera-slam-left", "camera-slam-right"]):
            device_T_cam = DEVICE_T_IMU @ SE3.from_matrix(self.imu_T_cam(number))
            cameras[label] = calibration.CameraCalibration(
                label, calibration.CameraModelType.FISHEYE624, fisheye, device_T_cam, *SIZE, None, 1.4, "serial")
        pinhole = np.array([100.0, 100, 99, 99, 0, 0, 0, 0])
        cameras["camera-et-left"] = calibration.CameraCalibration(
            "camera-et-left", calibration.CameraModelType.KANNALA_BRANDT_K3, pinhole, DEVICE_T_IMU, 200, 200, None, 0.75, "serial")
        # Forces are one interval late, and rates two.
        imu = calibration.ImuCalibration(
            "imu-right", SKEW_OF_FORCES, BIAS_OF_FORCES, SKEW_OF_RATES, BIAS_OF_RATES, DEVICE_T_IMU, INTERVAL, 2 * INTERVAL)
        origin = calibration.DeviceCadExtrinsics(calibration.DeviceVersion.Gen1, "DVT-S", "camera-slam-left")
        return calibration.DeviceCalibration(cameras, {"imu-right": imu}, {}, {}, {}, origin, "DVT-S", "camera-slam-left",
                                             calibration.DeviceVersion.Gen1)

    def json(self):
        stated = json.loads(calibration.device_calibration_to_json_string(self.calibration))
        for camera in stated["CameraCalibrations"]:
            camera["TimeOffsetSec_Device_Camera"] = CAMERA_OFFSET
        return json.dumps(stated)

    def images(self, camera):
        folder = self.walk / f"mav0/cam{camera}/data"
        return [(BEGIN + t + round(1e9 * CAMERA_OFFSET), np.array(Image.open(folder / f"{t}.png"))) for t in self.stamps]

    def raw_samples(self):
        """A stamp has the rate of two intervals ago and the force of one. One sample is not valid."""
        imu = self.calibration.get_imu_calib("imu-right")
        rates, forces = self.samples[:-1, 1:4], self.samples[1:, 4:7]
        stamps = [BEGIN + int(t) + round(2e9 * INTERVAL) for t in self.samples[:-1, 0]]
        return [(t, imu.rectified_to_raw_accel(force), imu.rectified_to_raw_gyro(rate), int(i != 7))
                for i, (t, force, rate) in enumerate(zip(stamps, forces, rates))]


@pytest.fixture(scope="module")
def glasses(tmp_path_factory):
    return Glasses(tmp_path_factory.mktemp("aria"))


def test_times_samples_and_pixels_arrive(glasses):
    assert glasses.converted.returncode == 0, glasses.converted.stderr
    float32 = 2e-6  # a VRS has the samples in 32 bits, up to 20 m/s^2
    kept = np.arange(len(glasses.samples) - 1) != 7
    for name, first, axes in (("gyro", 0, slice(1, 4)), ("accel", 1, slice(4, 7))):
        found = np.array(table(glasses.made / f"{name}.csv"), float)
        expected = glasses.samples[first:][: len(kept)][kept]
        assert (found[:, 0] == BEGIN + expected[:, 0]).all()
        assert np.abs(found[:, 1:] - expected[:, axes]).max() < float32
    for camera, stated in enumerate(json.loads((glasses.made / "calibration.yaml").read_text())["cameras"]):
        shift = round(1e9 * stated["timeshift_cam_imu"])
        assert [stamp + shift - BEGIN for stamp, _ in glasses.images(camera)] == glasses.stamps
        files = sorted((glasses.made / f"images/cam{camera}").iterdir(), key=lambda file: int(file.stem))
        for file, (stamp, pixels) in zip(files, glasses.images(camera), strict=True):
            assert int(file.stem) == stamp and (np.array(Image.open(file)) == pixels).all()


def test_chasles_and_projectaria_tools_have_the_same_pixels(glasses):
    """Points through the cameras that the converted folder calibrates, by both programs: lens, pixel centres, extrinsics."""
    seen = glasses.folder / "seen"
    chasles("simulate", "hallway", "--cameras", glasses.made, "--set", "cameras=2", "--set", "pixel_sigma=0",
            "--set", "sections=1", "--set", "hall_length=4", "-o", seen, "--quiet")
    points = {int(row[0]): np.array(row[1:], float) for row in table(seen / "landmarks_truth.csv")}
    poses = np.loadtxt(seen / "truth.tum")
    cameras = [glasses.calibration.get_camera_calib(f"camera-slam-{side}") for side in ("left", "right")]
    worst = [[], []]
    for time, camera, landmark, *pixel in np.array(table(seen / "pixels.csv"), float):
        pose = poses[np.abs(poses[:, 0] - time * 1e-9).argmin()]
        world_T_imu = SE3.from_quat_and_translation(pose[7], pose[4:7], pose[1:4])
        lens = cameras[int(camera)]
        cam_T_world = lens.get_transform_device_camera().inverse() @ DEVICE_T_IMU @ world_T_imu.inverse()
        expected = lens.project_no_checks(np.ravel(cam_T_world @ points[int(landmark)]))
        worst[int(camera)].append(np.abs(np.array(pixel) - np.ravel(expected)).max())
    assert min(map(len, worst)) > 100 and max(map(max, worst)) < 1e-6


def test_the_run_is_that_of_the_walk(glasses):
    """As far as the noise allows: it is stated as Aria's, and not as that of the walk."""
    paths = []
    for recording in (glasses.walk, glasses.made):
        run = glasses.folder / f"run_{recording.name}"
        chasles("run", recording, "-o", run, "--quiet")
        paths.append(np.loadtxt(run / "trajectory.tum")[:, 1:4])
    original, made = paths
    assert np.linalg.norm(np.diff(original, axis=0), axis=1).sum() > 6
    assert original.shape == made.shape and np.linalg.norm(original - made, axis=1).max() < 0.08


def test_a_lens_that_chasles_lacks_is_named(glasses, tmp_path):
    stated = json.loads(glasses.json())
    cameras = {camera["Label"]: camera for camera in stated["CameraCalibrations"]}
    cameras["camera-slam-left"]["Projection"] = cameras["camera-et-left"]["Projection"]
    write_vrs(tmp_path / "other.vrs", {"calib_json": json.dumps(stated), "device_type": "Aria"}, [glasses.images(0)[:2]],
              glasses.raw_samples()[:9])
    assert convert(tmp_path / "other.vrs", tmp_path / "made", "camera-slam-left").returncode == 0
    ended = subprocess.run([BINARY, "run", tmp_path / "made", "-o", tmp_path / "run"], capture_output=True, text=True, timeout=60)
    assert ended.returncode == 2 and "kannala_brandt_k3" in ended.stderr and "fisheye624" in ended.stderr, ended.stderr


def test_bad_input_says_what_was_found_and_expected(glasses, tmp_path):
    def message(*arguments):
        ended = convert(*arguments)
        assert ended.returncode == 1
        return ended.stderr

    new = tmp_path / "new"
    (tmp_path / "text.vrs").write_text("no VRS")
    images, samples = glasses.images(0)[:2], glasses.raw_samples()[:9]
    write_vrs(tmp_path / "uncalibrated.vrs", {"device_type": "Aria"}, [images], samples)
    write_vrs(tmp_path / "still.vrs", {"calib_json": glasses.json(), "device_type": "Aria"}, [images, images], [])
    expected = "expected a VRS file of Aria, found no data with a calibration of"
    for name in ("none", "text", "uncalibrated"):
        assert f"{name}.vrs: {expected} ['camera-slam-left', " in message(tmp_path / f"{name}.vrs", new)
    assert f"{expected} ['imu-right']" in message(tmp_path / "still.vrs", new)
    assert f"{expected} ['camera-slam-up']" in message(glasses.vrs, new, "camera-slam-left", "camera-slam-up")
    assert f"File exists: '{glasses.made}'" in message(glasses.vrs, glasses.made)
    assert "aria_to_chasles.py walk.vrs walk" in message(glasses.vrs)
    assert not new.exists()
