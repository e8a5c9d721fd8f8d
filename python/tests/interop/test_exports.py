"""`chasles export`, read back by the packages that its formats are for. Expected numbers come from states.csv and
summary.json, by the conventions of docs/exports.md."""

import csv
import json
import os
import subprocess

import numpy as np
import pytest

BINARY = os.environ.get("CHASLES_BINARY")
pytestmark = pytest.mark.skipif(BINARY is None, reason="CHASLES_BINARY names no command")


def chasles(*arguments):
    ended = subprocess.run([BINARY, *map(str, arguments)], capture_output=True, text=True)
    assert ended.returncode == 0, ended.stderr


def matrices(position, quaternion):
    """(N, 4, 4) of positions and quaternions x y z w, without a package."""
    x, y, z, w = np.asarray(quaternion, dtype=float).T
    T = np.zeros((len(x), 4, 4))
    T[:, 0, :3] = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], axis=1)
    T[:, 1, :3] = np.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)], axis=1)
    T[:, 2, :3] = np.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], axis=1)
    T[:, :3, 3] = position
    T[:, 3, 3] = 1
    return T


def columns_of(file):
    with open(file) as table:
        rows = list(csv.reader(table))
    return {name: [row[i] for row in rows[1:]] for i, name in enumerate(rows[0])}


def numbers(columns, *names):
    return np.array([columns[name] for name in names], dtype=float).T


class Walk:
    """A rendered walk and its run, with what the tests expect of them."""

    def __init__(self, folder, *scene):
        self.folder, self.recording, self.run = folder, folder / "walk", folder / "run"
        chasles("simulate", "walk", "--images", "--set", "walk_duration=6", *scene, "-o", self.recording, "--quiet")
        chasles("run", self.recording, "-o", self.run, "--quiet")
        self.states = columns_of(self.run / "states.csv")
        self.time_ns = np.array([int(t) for t in self.states["time_ns"]])
        self.world_T_imu = matrices(numbers(self.states, "x", "y", "z"), numbers(self.states, "qx", "qy", "qz", "qw"))
        self.summary = json.loads((self.run / "summary.json").read_text())
        self.imu_T_cam = np.array(self.summary["cameras"][0]["imu_T_cam"])
        # The stamp of the frame of each state, in the table of the recording.
        stamps = columns_of(self.recording / "mav0/cam0/data.csv")
        self.stamps = np.array([int(t) for t in stamps["#timestamp [ns]"]])
        self.frame_of_state = np.abs(self.stamps[:, None] - self.time_ns).argmin(axis=0)

    def export(self, name, output, *more):
        chasles("export", self.run, "--as", name, "-o", self.folder / output, "--quiet", *more)
        return self.folder / output


@pytest.fixture(scope="module")
def walk(tmp_path_factory):
    return Walk(tmp_path_factory.mktemp("walk"))


def test_evo_reads_tum_euroc_and_kitti(walk):
    from evo.tools import file_interface
    for name, read in (("tum", file_interface.read_tum_trajectory_file), ("euroc", file_interface.read_euroc_csv_trajectory)):
        path = read(str(walk.export(name, f"path.{name}")))
        assert np.allclose(path.timestamps, walk.time_ns * 1e-9, atol=1e-9)
        assert np.allclose(np.array(path.poses_se3), walk.world_T_imu, atol=1e-12)
    folder = walk.export("kitti", "kitti")
    poses = np.array(file_interface.read_kitti_poses_file(str(folder / "poses.txt")).poses_se3)
    cameras = walk.world_T_imu @ walk.imu_T_cam
    assert np.allclose(poses, np.linalg.inv(cameras[0]) @ cameras, atol=1e-12)
    assert np.allclose(np.loadtxt(folder / "times.txt"), walk.time_ns * 1e-9, atol=1e-9)
    # Forward is z of the camera: in IMU axes, or inverted, the walk would go another way.
    assert poses[-1, 2, 3] > 0.5 * np.linalg.norm(poses[-1, :3, 3])


def test_the_smoothed_path_is_another(walk):
    from evo.tools import file_interface
    smoothed = columns_of(walk.run / "smoothed.csv")
    path = file_interface.read_tum_trajectory_file(str(walk.export("tum", "smoothed.tum", "--smoothed")))
    assert np.allclose(path.positions_xyz, numbers(smoothed, "x", "y", "z"), atol=1e-12)
    assert not np.allclose(path.positions_xyz, walk.world_T_imu[:, :3, 3], atol=1e-5)


def test_umi_finds_the_pose_of_each_frame(walk):
    """As the pipeline reads the table (scripts_slam_pipeline/06_generate_dataset_plan.py): by pandas."""
    import pandas
    table = pandas.read_csv(walk.export("umi", "camera_trajectory.csv", "--recording", walk.recording))
    assert len(table) == len(walk.stamps)
    assert table["is_lost"].dtype == bool and table["is_keyframe"].dtype == bool
    assert np.allclose(table["timestamp"], (walk.stamps - walk.stamps[0]) * 1e-9)
    tracked = ~table["is_lost"].to_numpy()
    assert np.array_equal(np.flatnonzero(tracked), walk.frame_of_state)
    expected = walk.world_T_imu @ walk.imu_T_cam
    found = matrices(table[["x", "y", "z"]][tracked].to_numpy(), table[["q_x", "q_y", "q_z", "q_w"]][tracked].to_numpy())
    assert np.allclose(found, expected, atol=1e-12)
    assert not np.allclose(found, np.linalg.inv(expected), atol=0.1)


def test_projectaria_tools_reads_trajectory_and_points(walk):
    from projectaria_tools.core import mps
    walk.export("mps", "mps/slam")
    provider = mps.MpsDataProvider(mps.MpsDataPathsProvider(str(walk.folder / "mps")).get_data_paths())
    assert provider.has_closed_loop_poses() and provider.has_semidense_point_cloud()
    # For a missing column the reader returns an empty list without an error, else the rows before a number that
    # it does not read.
    path = mps.read_closed_loop_trajectory(str(walk.folder / "mps/slam/closed_loop_trajectory.csv"))
    assert len(path) == len(walk.time_ns)
    poses = np.array([pose.transform_world_device.to_matrix() for pose in path])
    assert np.allclose(poses, walk.world_T_imu, atol=1e-9)
    assert [round(1e6 * pose.tracking_timestamp.total_seconds()) for pose in path] == (walk.time_ns // 1000).tolist()
    assert np.allclose([pose.gravity_world for pose in path], [0, 0, -9.80665])
    velocity = np.array([pose.device_linear_velocity_device for pose in path])
    world = np.einsum("nij,nj->ni", walk.world_T_imu[:, :3, :3], velocity)
    assert np.allclose(world, numbers(walk.states, "velocity_x", "velocity_y", "velocity_z"), atol=1e-9)
    assert {pose.quality_score for pose in path} == {1.0}
    points = mps.read_global_point_cloud(str(walk.folder / "mps/slam/semidense_points.csv.gz"))
    landmarks = numbers(columns_of(walk.run / "landmarks.csv"), "x", "y", "z", "sigma")
    assert len(points) == len(landmarks)
    assert np.allclose([point.position_world for point in points], landmarks[:, :3], rtol=1e-9)
    stds = np.array([point.distance_std for point in points])
    assert (stds > 0).all() and (stds <= landmarks[:, 3] * 1.0001).all()
    assert {point.graph_uid for point in points} == {pose.graph_uid for pose in path}


def test_without_a_column_projectaria_tools_reads_nothing(walk, tmp_path):
    """Why each column is there."""
    from projectaria_tools.core import mps
    lines = (walk.export("mps", "whole") / "closed_loop_trajectory.csv").read_text().splitlines()
    names = lines[0].split(",")
    for i, name in enumerate(names):
        rows = [line.split(",") for line in lines[:5]]
        cut = tmp_path / f"{name}.csv"
        cut.write_text("\n".join(",".join(row[:i] + row[i + 1:]) for row in rows) + "\n")
        assert mps.read_closed_loop_trajectory(str(cut)) == [], name


def test_nerfstudio_has_the_axes_of_opengl(walk):
    """nerfstudio needs torch, so this test reads its files alone. A point ahead of the camera has a negative z."""
    import meshio
    folder = walk.export("nerfstudio", "nerfstudio", "--recording", walk.recording)
    data = json.loads((folder / "transforms.json").read_text())
    assert len(data["frames"]) == len(walk.time_ns)
    opengl = np.diag([1, -1, -1, 1])
    poses = np.array([frame["transform_matrix"] for frame in data["frames"]])
    assert np.allclose(poses, walk.world_T_imu @ walk.imu_T_cam @ opengl, atol=1e-12)
    names = [(folder / frame["file_path"]).resolve() for frame in data["frames"]]
    assert all(name.is_file() for name in names)
    assert [int(name.stem) for name in names] == walk.stamps[walk.frame_of_state].tolist()
    fx, fy, cx, cy = walk.summary["cameras"][0]["intrinsics"]
    assert (data["fl_x"], data["fl_y"], data["cx"], data["cy"]) == (fx, fy, cx + 0.5, cy + 0.5)
    cloud = meshio.read(folder / data["ply_file_path"])
    landmarks = columns_of(walk.run / "landmarks.csv")
    assert cloud.points == pytest.approx(numbers(landmarks, "x", "y", "z"), rel=1e-6)
    # Landmarks that the last frame has seen are in its image, by nerfstudio's own pinhole.
    now = [int(t) == walk.stamps[-1] for t in landmarks["last_seen_ns"]]
    in_camera = (np.c_[cloud.points[now], np.ones(sum(now))] @ np.linalg.inv(poses[-1]).T)[:, :3]
    u, v = cx + 0.5 + fx * in_camera[:, 0] / -in_camera[:, 2], cy + 0.5 - fy * in_camera[:, 1] / -in_camera[:, 2]
    inside = (in_camera[:, 2] < 0) & (u > 0) & (u < data["w"]) & (v > 0) & (v < data["h"])
    assert sum(now) > 20 and inside.mean() > 0.9
