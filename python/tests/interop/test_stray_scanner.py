"""python/examples/stray_scanner_to_chasles.py, over a rendered walk in the form that the app's source writes (strayrobots/scanner:
IMUEncoder, OdometryEncoder, VideoEncoder): H.265 by PyAV, stamped as the app stamps it, accelerations in g that point down."""

import json
import re
import shutil
from fractions import Fraction

import numpy as np
import pytest

av = pytest.importorskip("av")
pytest.importorskip("pandas")
pytest.importorskip("scipy")
from PIL import Image  # noqa: E402
from scipy.spatial.transform import Rotation  # noqa: E402

from conversions import BINARY, chasles, run_example, table  # noqa: E402

pytestmark = pytest.mark.skipif(BINARY is None, reason="CHASLES_BINARY names no command")

BOOT = 43210.5  # when the walk begins, by the clock of the phone [s]
FRAME_RATE, TICKS = 20, 60
G = 9.80665
# ARKit: the camera's x goes from the phone's front camera to its home button, y to the right of a phone held upright, z out
# of the screen. The rows of the image go down, so the app turns y and z. Columns are axes of the image in those of the phone.
PHONE_R_CAM = np.column_stack([[0, -1, 0], [-1, 0, 0], [0, 0, -1]])


def convert(*arguments):
    return run_example("stray_scanner_to_chasles.py", *arguments)


def write(file, header, rows):
    file.write_text("\n".join([header, *(", ".join(map(str, row)) for row in rows), ""]))


class Scan:
    """The walk as it was rendered, and as the app would have recorded it."""

    def __init__(self, folder):
        self.folder, self.walk, self.scan, self.made = folder, folder / "walk", folder / "71de12f9", folder / "made"
        scene = {"walk_duration": 10, "frame_rate": FRAME_RATE, "image_width": 400, "image_height": 300, "focal_length": 240,
                 "center_u": 198.7, "center_v": 151.2, "camera_tilt_x": 0.02, "camera_tilt_z": -0.03}
        sets = [word for name, value in scene.items() for word in ("--set", f"{name}={value}")]
        chasles("simulate", "walk", "--images", *sets, "-o", self.walk, "--quiet")
        stated = re.search(r"data: \[([^\]]*)\]", (self.walk / "mav0/cam0/sensor.yaml").read_text())[1]
        self.imu_T_cam = np.array(stated.split(","), float).reshape(4, 4)
        self.phone_R_imu = PHONE_R_CAM @ self.imu_T_cam[:3, :3].T
        self.place = self.phone_R_imu @ self.imu_T_cam[:3, 3]  # of the camera, in the axes of the phone
        self.samples = np.array(table(self.walk / "mav0/imu0/data.csv"), float)
        self.samples[:, 1:4] = self.samples[:, 1:4] @ self.phone_R_imu.T
        self.samples[:, 4:7] = self.samples[:, 4:7] @ self.phone_R_imu.T
        truth = np.array(table(self.walk / "mav0/state_groundtruth_estimate0/data.csv"), float)
        self.frames = np.array([int(row[0]) for row in table(self.walk / "mav0/cam0/data.csv")])
        self.truth = truth[[np.abs(truth[:, 0] - t).argmin() for t in self.frames], 1:8]
        self.scan.mkdir()
        self.write_tables()
        self.write_video()
        self.converted = convert(self.scan, self.made, *self.place)

    def write_tables(self, scale=-1 / G):
        seconds = BOOT + 1e-9 * self.samples[:, 0]
        write(self.scan / "imu.csv", "timestamp, a_x, a_y, a_z, alpha_x, alpha_y, alpha_z",
              np.column_stack([seconds, scale * self.samples[:, 4:7], self.samples[:, 1:4]]).tolist())
        positions, imus = self.truth[:, :3], Rotation.from_quat(self.truth[:, [4, 5, 6, 3]])
        level = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])  # y up
        places = (positions + imus.apply(self.imu_T_cam[:3, 3])) @ level.T
        turns = (Rotation.from_matrix(level) * imus * Rotation.from_matrix(self.imu_T_cam[:3, :3])).as_quat()
        rows = [[BOOT + 1e-9 * t, f"{i:06}", *place, *turn]
                for i, (t, place, turn) in enumerate(zip(self.frames.tolist(), places.tolist(), turns.tolist()))]
        write(self.scan / "odometry.csv", "timestamp, frame, x, y, z, qx, qy, qz, qw", rows)
        (self.scan / "camera_matrix.csv").write_text("240.0, 0.0, 198.7\n0.0, 240.0, 151.2\n0.0, 0.0, 1.0")

    def write_video(self):
        """Stamped by a number that begins with -1, in ticks of 1/60 s."""
        with av.open(str(self.scan / "rgb.mp4"), "w") as video:
            options = {"x265-params": "log-level=error", "preset": "ultrafast", "crf": "12"}
            stream = video.add_stream("libx265", rate=TICKS, options=options)
            stream.width, stream.height, stream.pix_fmt = 400, 300, "yuv420p"
            stream.time_base = stream.codec_context.time_base = Fraction(1, TICKS)
            for i, time in enumerate(self.frames):
                grey = np.array(Image.open(self.walk / f"mav0/cam0/data/{time}.png"))
                frame = av.VideoFrame.from_ndarray(grey, format="gray").reformat(format="yuv420p")
                frame.pts, frame.time_base = TICKS // FRAME_RATE * i - 1, Fraction(1, TICKS)
                video.mux(stream.encode(frame))
            video.mux(stream.encode())


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    return Scan(tmp_path_factory.mktemp("stray"))


def test_samples_times_and_poses_arrive(scan):
    assert scan.converted.returncode == 0, scan.converted.stderr
    imu = np.array(table(scan.made / "imu.csv"), float)
    assert np.abs(imu[:, 0] - BOOT - 1e-9 * scan.samples[:, 0]).max() < 1e-8
    assert np.abs(imu[:, 1:] - scan.samples[:, 1:]).max() < 1e-8
    times = np.loadtxt(scan.made / "times.txt")
    assert np.abs(times - BOOT - 1e-9 * scan.frames[1:]).max() < 1e-8  # no program shows the first picture
    poses = np.loadtxt(scan.made / "arkit.tum")
    expected = Rotation.from_quat(scan.truth[:, [4, 5, 6, 3]]) * Rotation.from_matrix(scan.phone_R_imu.T)
    assert np.abs(poses[:, 1:4] - scan.truth[:, :3]).max() < 1e-6
    assert (expected.inv() * Rotation.from_quat(poses[:, 4:])).magnitude().max() < 1e-6
    camera = json.loads((scan.made / "calibration.yaml").read_text())["cameras"][0]
    assert np.abs(np.linalg.inv(camera["cam_T_imu"])[:3] - np.column_stack([PHONE_R_CAM, scan.place])).max() < 1e-12


def test_the_run_is_that_of_the_walk(scan):
    """Within 3 cm of 7 m, after a rotation and a translation: a run's heading is that of the IMU's axes. The pictures have their
    true times, so the time offset needs no estimation."""
    paths = []
    for recording in (scan.walk, scan.made):
        run = scan.folder / f"run_{recording.name}"
        chasles("run", recording, "-o", run, "--quiet", "--as-recorded", "--set", "time_offset=0", "--set",
                "calibrate_time_offset=false")
        paths.append(np.loadtxt(run / "trajectory.tum"))
    original, made = paths
    made[:, 0] -= BOOT
    at = np.column_stack([np.interp(made[:, 0], original[:, 0], original[:, i]) for i in (1, 2, 3)])
    at, path = at - at.mean(axis=0), made[:, 1:4] - made[:, 1:4].mean(axis=0)
    turn, _ = Rotation.align_vectors(at, path)
    assert len(made) > 0.8 * len(scan.frames) and np.linalg.norm(np.diff(at, axis=0), axis=1).sum() > 6
    assert np.linalg.norm(turn.apply(path) - at, axis=1).max() < 0.03


def test_accelerations_in_metres_are_those_in_g(scan, tmp_path):
    """As versions before 2025 wrote them. A last row that the app did not finish is left out."""
    before = (scan.scan / "imu.csv").read_text()
    scan.write_tables(scale=-1)
    with open(scan.scan / "imu.csv", "a") as table_of_imu:
        table_of_imu.write("43221.0, 0.1")
    assert convert(scan.scan, tmp_path / "metres").returncode == 0
    (scan.scan / "imu.csv").write_text(before)
    found = np.array(table(tmp_path / "metres/imu.csv"), float)
    assert np.abs(found[:, 1:] - scan.samples[:, 1:]).max() < 1e-8


def test_bad_input_says_what_was_found_and_expected(scan, tmp_path):
    def message(*arguments):
        ended = convert(*arguments)
        assert ended.returncode == 1
        return ended.stderr

    def changed(file, text):
        copy = tmp_path / f"copy_of_{file}"
        shutil.copytree(scan.scan, copy)
        (copy / file).write_text(text)
        return message(copy, tmp_path / "new")

    expected = "expected imu.csv, odometry.csv, camera_matrix.csv and rgb.mp4 of Stray Scanner"
    odometry = (scan.scan / "odometry.csv").read_text()
    assert expected in message(tmp_path / "nothing", tmp_path / "new")
    assert expected in changed("rgb.mp4", "no video")
    assert f"{expected}: ValueError(" in changed("imu.csv", "t, x\n1, 2\n")
    assert expected in changed("camera_matrix.csv", "1, 2\n3, 4\n")
    cut = "\n".join(odometry.split("\n")[:-10])
    assert f"odometry.csv has {len(scan.frames) - 9} rows, rgb.mp4 shows" in changed("odometry.csv", cut)
    assert f"File exists: '{scan.made}'" in message(scan.scan, scan.made)
    assert "stray_scanner_to_chasles.py 71de12f9 walk" in message(scan.scan)
    assert not (tmp_path / "new").exists()
