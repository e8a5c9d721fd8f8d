"""`chasles calibrate convert`, read by the programs of its formats: OpenCV, pycolmap, and PyYAML as Kalibr and ROS use it.
Expected pixels come from the formulas of docs/calibration-conventions.md."""

import json
import math
import os
import subprocess

import numpy as np
import pytest

BINARY = os.environ.get("CHASLES_BINARY")
pytestmark = pytest.mark.skipif(BINARY is None, reason="CHASLES_BINARY names no command")

WIDTH, HEIGHT, FX, FY, CX, CY = 640, 480, 311.25, 309.0, 322.0, 237.5
OFFSETS = [0.0125, -0.0055]
NOISE = {"accelerometer_noise_density": 0.01, "accelerometer_random_walk": 0.0002, "gyroscope_noise_density": 1e-05,
         "gyroscope_random_walk": 4e-06}
#: Points in front of a camera, up to 45 degrees from its axis.
POINTS = np.array([[x, y, z] for x in (-0.9, -0.3, 0.0, 0.4, 0.8) for y in (-0.7, 0.0, 0.5) for z in (1.0, 2.5)])
RADTAN = [-0.28, 0.07, 0.0002, 0.00002]
LENSES = {
    "none": ("none", []),
    "radtan4": ("radtan", RADTAN),
    "radtan5": ("radtan", [*RADTAN, -0.01]),
    "radtan8": ("radtan", [0.52, -2.7, 0.0008, -0.0003, 1.6, 0.39, -2.5, 1.52]),
    "radtan12": ("radtan", [0.52, -2.7, 0.0008, -0.0003, 1.6, 0.39, -2.5, 1.52, 0.0012, -0.0004, -0.0009, 0.0003]),
    "equidistant": ("equidistant", [0.02, -0.004, 0.003, -0.001]),
    "ds": ("ds", [-0.21, 0.59]),
    "eucm": ("eucm", [0.62, 1.08]),
    "omni": ("omni", [1.6, -0.12, 0.05, 0.001, -0.0005]),
    "fov": ("fov", [0.93]),
    "division": ("division", [-0.2]),
    "fisheye624": ("fisheye624", [0.04, -0.02, -0.012, 0.014, -0.0042, 0.0005, -0.00049, 0.00021, -0.0006, 0.00008, 0.0004,
                                  -0.00011]),
}


def motion(axis, angle, translation):
    """The 4 x 4 matrix of a rotation about an axis and a translation."""
    axis = np.array(axis) / np.linalg.norm(axis)
    skew = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    T = np.eye(4)
    T[:3, :3] += math.sin(angle) * skew + (1 - math.cos(angle)) * skew @ skew
    T[:3, 3] = translation
    return T


CAM0_T_IMU = motion([1, 2, -1], 1.1, [0.05, -0.11, 0.02])
CAM_T_IMU = [CAM0_T_IMU, motion([0, 1, 0.2], 0.3, [-0.2, 0.01, 0.03]) @ CAM0_T_IMU]


def chasles(*arguments):
    done = subprocess.run([BINARY, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def distorted(model, k, points):
    """The plane's points of directions in front of the camera, by the formulas of docs/calibration-conventions.md."""
    x, y = points[:, 0] / points[:, 2], points[:, 1] / points[:, 2]
    r = np.hypot(x, y)
    if model == "none":
        return np.stack([x, y], axis=1)
    if model == "omni":
        down = 1 + k[0] * np.sqrt(1 + r**2)
        return distorted("radtan", k[1:], np.stack([x / down, y / down, np.ones_like(x)], axis=1))
    if model == "radtan":
        k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4 = [*k, *[0.0] * (12 - len(k))]
        D = (1 + k1 * r**2 + k2 * r**4 + k3 * r**6) / (1 + k4 * r**2 + k5 * r**4 + k6 * r**6)
        return np.stack([x * D + 2 * p1 * x * y + p2 * (r**2 + 2 * x**2) + s1 * r**2 + s2 * r**4,
                         y * D + p1 * (r**2 + 2 * y**2) + 2 * p2 * x * y + s3 * r**2 + s4 * r**4], axis=1)
    theta, r = np.arctan(r), np.where(r > 0, r, 1)
    if model == "equidistant":
        scale = theta * (1 + sum(c * theta**(2 * i + 2) for i, c in enumerate(k))) / r
    elif model == "eucm":
        scale = 1 / (k[0] * np.sqrt(k[1] * r**2 + 1) + 1 - k[0])
    elif model == "fov":
        scale = np.arctan(2 * r * math.tan(k[0] / 2)) / (k[0] * r)
    elif model == "division":  # the root of lambda r r'^2 - r' + r = 0 that is r without distortion
        scale = 2 / (1 + np.sqrt(1 - 4 * k[0] * r**2))
    elif model == "fisheye624":
        scale = theta * (1 + sum(c * theta**(2 * i + 2) for i, c in enumerate(k[:6]))) / r
        qx, qy = x * scale, y * scale
        q2, (p0, p1, s0, s1, s2, s3) = qx**2 + qy**2, k[6:]
        return np.stack([qx + p0 * (q2 + 2 * qx**2) + 2 * p1 * qx * qy + s0 * q2 + s1 * q2**2,
                         qy + 2 * p0 * qx * qy + p1 * (q2 + 2 * qy**2) + s2 * q2 + s3 * q2**2], axis=1)
    return np.stack([x * scale, y * scale], axis=1)


class Converted:
    """Two cameras of a lens and an IMU, as calibration.yaml, converted."""

    def __init__(self, folder, lens):
        self.model, self.coefficients = LENSES[lens]
        self.folder = folder / "converted"
        text = "format: chasles-recording-1\nname: two\nimu_convention: instant\ncameras:\n"
        for cam_T_imu, offset in zip(CAM_T_IMU, OFFSETS):
            text += (f"  - resolution: [{WIDTH}, {HEIGHT}]\n    intrinsics: [{FX}, {FY}, {CX}, {CY}]\n"
                     f"    distortion_model: {self.model}\n    distortion_coeffs: {self.coefficients}\n"
                     f"    cam_T_imu: {cam_T_imu.tolist()}\n    timeshift_cam_imu: {offset}\n")
        text += "".join(f"{key}: {value!r}\n" for key, value in NOISE.items())
        file = folder / "calibration.yaml"
        file.write_text(text)
        self.out = chasles("calibrate", "convert", file, "-o", self.folder, "--imu-rate", 200)

    def pixels(self):
        return distorted(self.model, self.coefficients, POINTS) * [FX, FY] + [CX, CY]


def convert(lens, folder, name):
    """The conversion, where the format has the lens."""
    converted = Converted(folder, lens)
    if lens in LENSES_OF[name]:
        return converted
    assert not (converted.folder / name.lower()).exists()
    assert f"{name}'s file is not written" in converted.out and f"{converted.model}" in converted.out
    return None


LENSES_OF = {
    "Kalibr": {"none", "radtan4", "equidistant", "ds", "eucm", "omni", "fov"},
    "ROS": {"none", "radtan4", "radtan5", "radtan8", "equidistant"},
    "OpenCV": {"none", "radtan4", "radtan5", "radtan8", "radtan12", "equidistant", "omni"},
    "Basalt": {"none", "radtan4", "radtan5", "radtan8", "equidistant", "ds", "eucm", "fov"},
    "COLMAP": {"none", "radtan4", "radtan5", "radtan8", "equidistant", "eucm", "fov", "division", "fisheye624"},
}
each_lens = pytest.mark.parametrize("lens", LENSES)


@each_lens
def test_opencv_projects_the_same_pixels(lens, tmp_path):
    import cv2
    converted = convert(lens, tmp_path, "OpenCV")
    if converted is None:
        return
    for number, (cam_T_imu, offset) in enumerate(zip(CAM_T_IMU, OFFSETS)):
        file = cv2.FileStorage(str(converted.folder / f"opencv/cam{number}.yaml"), cv2.FILE_STORAGE_READ)
        K, D = file.getNode("cameraMatrix").mat(), file.getNode("distCoeffs").mat()
        R, T = file.getNode("R").mat(), file.getNode("T").mat()
        assert file.getNode("image_width").real() == WIDTH and file.getNode("image_height").real() == HEIGHT
        assert file.getNode("time_offset").real() == offset
        assert np.allclose(file.getNode("R_imu").mat(), cam_T_imu[:3, :3], atol=1e-12)
        assert np.allclose(file.getNode("T_imu").mat()[:, 0], cam_T_imu[:3, 3], atol=1e-12)
        # The first camera's coordinates of the points; R and T lead to those of this one.
        first = (np.linalg.inv(cam_T_imu @ np.linalg.inv(CAM0_T_IMU)) @ np.c_[POINTS, np.ones(len(POINTS))].T).T[:, :3]
        model, rvec = file.getNode("model").string(), cv2.Rodrigues(R)[0]
        if model == "pinhole":
            pixels = cv2.projectPoints(first, rvec, T, K, D)[0]
        elif model == "fisheye":
            pixels = cv2.fisheye.projectPoints(first[:, None], rvec, T, K, D)[0]
        else:
            assert model == "omnidir"
            pixels = cv2.omnidir.projectPoints(first[:, None], rvec, T, K, file.getNode("xi").real(), D)[0]
            pixels = pixels.reshape(-1, 1, 2)
        assert np.allclose(pixels[:, 0], converted.pixels(), atol=1e-9)


@each_lens
def test_pycolmap_projects_to_half_a_pixel_more(lens, tmp_path):
    import pycolmap
    converted = convert(lens, tmp_path, "COLMAP")
    if converted is None:
        return
    model = tmp_path / "model"  # COLMAP reads cameras.txt as a part of one
    model.mkdir()
    (model / "cameras.txt").write_text((converted.folder / "colmap/cameras.txt").read_text())
    for name in ("images.txt", "points3D.txt"):
        (model / name).write_text("")
    cameras = pycolmap.Reconstruction(str(model)).cameras
    assert sorted(cameras) == [1, 2]
    for camera in cameras.values():
        assert (camera.width, camera.height) == (WIDTH, HEIGHT)
        pixels = np.array([camera.img_from_cam(point) for point in POINTS])
        assert np.allclose(pixels - 0.5, converted.pixels(), atol=1e-9)
    # The remark has the pose of the second camera, as COLMAP writes poses: from the first to it.
    words = (converted.folder / "colmap/cameras.txt").read_text().split("cam2_from_cam1: ")[1].split("\n")[0].split()
    w, x, y, z, *translation = (float(word) for word in words)
    cam1_T_cam0 = CAM_T_IMU[1] @ np.linalg.inv(CAM0_T_IMU)
    assert np.allclose(pycolmap.Rotation3d([x, y, z, w]).matrix(), cam1_T_cam0[:3, :3], atol=1e-12)
    assert np.allclose(translation, cam1_T_cam0[:3, 3], atol=1e-12)


@each_lens
def test_pyyaml_reads_kalibrs_files_as_kalibr_does(lens, tmp_path):
    import yaml
    converted = convert(lens, tmp_path, "Kalibr")
    if converted is None:
        return
    chain = yaml.safe_load((converted.folder / "kalibr/camchain-imucam.yaml").read_text())
    assert list(chain) == ["cam0", "cam1"]
    for camera, cam_T_imu, offset in zip(chain.values(), CAM_T_IMU, OFFSETS):
        # What kalibr_common/ConfigReader.py checks: types, and the numbers of coefficients.
        own = {"omni": 1, "ds": 2, "eucm": 2}.get(camera["camera_model"], 0)
        assert camera["camera_model"] == ("pinhole" if own == 0 else converted.model)
        assert len(camera["intrinsics"]) == 4 + own and all(isinstance(k, float) for k in camera["intrinsics"])
        counts = {"radtan": 4, "equidistant": 4, "fov": 1, "none": 0}
        assert len(camera["distortion_coeffs"]) == counts[camera["distortion_model"]]
        assert all(isinstance(k, float) for k in camera["distortion_coeffs"])
        assert camera["resolution"] == [WIDTH, HEIGHT] and isinstance(camera["rostopic"], str)
        assert isinstance(camera["timeshift_cam_imu"], float) and camera["timeshift_cam_imu"] == offset
        assert np.allclose(camera["T_cam_imu"], cam_T_imu, atol=1e-12)
        assert camera["intrinsics"][own:] == [FX, FY, CX, CY]
        assert camera["intrinsics"][:own] + camera["distortion_coeffs"] == converted.coefficients
    assert np.allclose(chain["cam1"]["T_cn_cnm1"], CAM_T_IMU[1] @ np.linalg.inv(CAM0_T_IMU), atol=1e-12)
    imu = yaml.safe_load((converted.folder / "kalibr/imu.yaml").read_text())
    assert {key: imu[key] for key in NOISE} == NOISE and imu["update_rate"] == 200 and imu["rostopic"] == "/imu0"


@each_lens
def test_ros_camera_info_has_the_documented_keys(lens, tmp_path):
    import cv2
    import yaml
    converted = convert(lens, tmp_path, "ROS")
    if converted is None:
        return
    for number, (cam_T_imu, offset) in enumerate(zip(CAM_T_IMU, OFFSETS)):
        text = (converted.folder / f"ros/cam{number}.yaml").read_text()
        info = yaml.safe_load(text)
        # As camera_calibration_parsers reads it.
        matrix = {key: np.array(info[key]["data"]).reshape(info[key]["rows"], info[key]["cols"])
                  for key in ("camera_matrix", "distortion_coefficients", "rectification_matrix", "projection_matrix")}
        K, D = matrix["camera_matrix"], matrix["distortion_coefficients"]
        assert (info["image_width"], info["image_height"], info["camera_name"]) == (WIDTH, HEIGHT, f"cam{number}")
        assert D.shape == (1, {"plumb_bob": 5, "rational_polynomial": 8, "equidistant": 4}[info["distortion_model"]])
        assert (matrix["rectification_matrix"] == np.eye(3)).all()
        assert (matrix["projection_matrix"] == np.c_[K, np.zeros(3)]).all()
        zero = np.zeros(3)
        if info["distortion_model"] == "equidistant":
            pixels = cv2.fisheye.projectPoints(POINTS[:, None], zero, zero, K, D)[0]
        else:
            pixels = cv2.projectPoints(POINTS, zero, zero, K, D)[0]
        assert np.allclose(pixels[:, 0], converted.pixels(), atol=1e-9)
        # The transform of the remark: parent imu, child the camera.
        assert f"parent imu and the child cam{number}" in text and f"the camera + {offset} s" in text
        place = [float(word) for word in text.split("translation x y z [m]: ")[1].split("\n")[0].split()]
        assert np.allclose(place, np.linalg.inv(cam_T_imu)[:3, 3], atol=1e-12)


@each_lens
def test_basalts_json_has_the_keys_of_its_reader(lens, tmp_path):
    converted = convert(lens, tmp_path, "Basalt")
    if converted is None:
        return
    whole = json.loads((converted.folder / "basalt/calibration.json").read_text())
    assert list(whole)[0] == "value0"  # cereal takes the first value of the file
    value = whole["value0"]
    for pose, lens_of, size, cam_T_imu in zip(value["T_imu_cam"], value["intrinsics"], value["resolution"], CAM_T_IMU):
        imu_T_cam = np.linalg.inv(cam_T_imu)
        assert np.allclose([pose[key] for key in ("px", "py", "pz")], imu_T_cam[:3, 3], atol=1e-12)
        x, y, z, w = (pose[key] for key in ("qx", "qy", "qz", "qw"))
        forward = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]
        assert np.allclose(forward, imu_T_cam[:3, 2], atol=1e-12)
        assert size == [WIDTH, HEIGHT]
        intrinsics = list(lens_of["intrinsics"].values())
        assert intrinsics[:4] == [FX, FY, CX, CY]
        assert intrinsics[4:4 + len(converted.coefficients)] == converted.coefficients
        assert not any(intrinsics[4 + len(converted.coefficients):])
    counts = {"calib_accel_bias": 9, "calib_gyro_bias": 12, "accel_noise_std": 3, "gyro_noise_std": 3, "accel_bias_std": 3,
              "gyro_bias_std": 3}
    assert {key: len(value[key]) for key in counts} == counts
    assert value["accel_noise_std"] == [NOISE["accelerometer_noise_density"]] * 3
    assert value["gyro_bias_std"] == [NOISE["gyroscope_random_walk"]] * 3
    assert value["imu_update_rate"] == 200 and value["vignette"] == []
    # One offset for both cameras, with a sentence.
    assert value["cam_time_offset_ns"] == round(1e9 * sum(OFFSETS) / 2) and "up to 18 ms" in converted.out


@pytest.mark.parametrize("source", ["kalibr", "kalibr/camchain-imucam.yaml", "basalt", "basalt/calibration.json", "calibration.yaml"])
def test_a_converted_calibration_converts_again(source, tmp_path):
    first = Converted(tmp_path, "equidistant")
    chasles("calibrate", "convert", first.folder / source, "-o", tmp_path / "again", "--imu-rate", 200, "--quiet")
    for name in ("ros/cam0.yaml", "opencv/cam1.yaml", "colmap/cameras.txt"):
        lines = [[line for line in (folder / name).read_text().splitlines() if not line.startswith(("#", "T", "R", "   data", "time"))]
                 for folder in (first.folder, tmp_path / "again")]
        assert lines[0] == lines[1]


def test_the_output_must_be_new(tmp_path):
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "file").touch()
    done = subprocess.run([BINARY, "calibrate", "convert", tmp_path / "none.yaml", "-o", tmp_path / "there"], capture_output=True, text=True)
    assert done.returncode == 1 and "is there and not empty, expected a new folder" in done.stderr
