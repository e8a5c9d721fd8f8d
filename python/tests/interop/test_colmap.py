"""`chasles export --as colmap`, read by pycolmap. Expected numbers come from states.csv and summary.json."""

import json

import numpy as np
import pytest

from test_exports import BINARY, Walk, columns_of, matrices, numbers

pytestmark = pytest.mark.skipif(BINARY is None, reason="CHASLES_BINARY names no command")

#: Few and small images, for speed.
SMALL = [word for assignment in ("image_width=376", "image_height=240", "focal_length=240", "center_u=187.5", "center_v=119.5", "frame_rate=10")
         for word in ("--set", assignment)]
#: The lenses that COLMAP has: coefficients for the scene of a walk, and COLMAP's name.
LENSES = [("none", "", "PINHOLE"), ("radtan", "-0.28 0.07 0.0002 0.00002", "OPENCV"),
          ("radtan", "-0.28 0.07 0.0002 0.00002 0.01", "FULL_OPENCV"),
          ("equidistant", "0.02 -0.004 0.003 -0.001", "OPENCV_FISHEYE"), ("fov", "0.9", "FOV"),
          ("division", "-0.2", "DIVISION"), ("eucm", "0.6 1.1", "EUCM"),
          ("fisheye624", "0.02 -0.01 0.004 -0.002 0.0005 -0.00005 0.001 -0.0007 0.0004 -0.0002 0.0003 0.0001",
           "RAD_TAN_THIN_PRISM_FISHEYE")]


@pytest.fixture(scope="module")
def pair(tmp_path_factory):
    return Walk(tmp_path_factory.mktemp("pair"), "--set", "cameras=2")


def reprojection_errors(model):
    """By COLMAP's own projections, for each point the length of its errors."""
    errors = {}
    for point_id, point in model.points3D.items():
        for element in point.track.elements:
            image = model.image(element.image_id)
            projected = image.project_point(point.xyz)
            assert projected is not None, "a point is behind its camera"
            error = np.linalg.norm(projected - image.points2D[element.point2D_idx].xy)
            errors.setdefault(point_id, []).append(error)
    return errors


@pytest.mark.parametrize("name", ["colmap", "colmap-text"])
def test_pycolmap_has_our_reprojection_errors_and_poses(pair, name):
    import pycolmap
    folder = pair.export(name, name, "--recording", pair.recording, "--smoothed")
    model = pycolmap.Reconstruction(str(folder))
    assert model.num_cameras() == 2 and model.num_rigs() == 1
    assert model.num_points3D() > 100 and model.num_frames() > 4
    errors = reprojection_errors(model)
    assert set(errors) == set(model.points3D)
    for point_id, point in model.points3D.items():
        assert np.mean(errors[point_id]) == pytest.approx(point.error, abs=1e-6)
    # With the pixels half a pixel off, or poses the other way, they would be larger.
    assert np.mean(np.concatenate(list(errors.values()))) < 0.3
    smoothed = columns_of(pair.run / "smoothed.csv")
    world_T_imu = matrices(numbers(smoothed, "x", "y", "z"), numbers(smoothed, "qx", "qy", "qz", "qw"))
    time_ns = np.array([int(t) for t in smoothed["time_ns"]])
    for number, camera in model.cameras.items():
        fx, fy, cx, cy = pair.summary["cameras"][number - 1]["intrinsics"]
        assert camera.params.tolist() == [fx, fy, cx + 0.5, cy + 0.5]
    imu_T_cam = [np.array(camera["imu_T_cam"]) for camera in pair.summary["cameras"]]
    for image in model.images.values():
        stem = image.name.rsplit("/", 1)[1].split(".")[0]
        camera = int(image.name.split("/")[1][3:])
        assert image.camera_id == camera + 1 and (pair.recording / image.name).is_file()
        state = np.abs(time_ns - int(stem)).argmin()
        expected = np.linalg.inv(world_T_imu[state] @ imu_T_cam[camera])
        assert np.allclose(image.cam_from_world().matrix(), expected[:3], atol=1e-9)
    # One grey value for all three colours, and not the same for all points.
    colours = np.array([point.color for point in model.points3D.values()])
    assert (colours == colours[:, :1]).all() and len(np.unique(colours)) > 10


def test_pycolmap_reads_the_priors_of_the_database(pair):
    import pycolmap
    folder = pair.export("colmap", "priors", "--recording", pair.recording)
    model = pycolmap.Reconstruction(str(folder))
    database = pycolmap.Database.open(str(folder / "database.db"))
    try:
        assert {image.image_id: image.name for image in database.read_all_images()} == {
            image_id: image.name for image_id, image in model.images.items()}
        assert {frame.frame_id for frame in database.read_all_frames()} == set(model.frames)
        rig, = database.read_all_rigs()
        sensor, = rig.non_ref_sensors
        assert np.allclose(rig.sensor_from_rig(sensor).matrix(), model.rig(1).sensor_from_rig(sensor).matrix())
        priors = database.read_all_pose_priors()
        assert len(priors) == model.num_images()
        for prior in priors:
            image = model.image(prior.corr_data_id.id)
            assert prior.coordinate_system == pycolmap.PosePriorCoordinateSystem.CARTESIAN
            assert np.allclose(prior.position, image.projection_center(), atol=1e-9)
            assert prior.has_position_cov()
            # Of the camera: that of the IMU, but for the lever arm.
            stem = image.name.rsplit("/", 1)[1].split(".")[0]
            state = np.abs(pair.time_ns - int(stem)).argmin()
            sigma = np.array([float(pair.states[f"cov_{i}{i}"][state]) for i in (3, 4, 5)]) ** 0.5
            assert np.allclose(np.sqrt(np.diag(prior.position_covariance)), sigma, rtol=0.5, atol=1e-3)
            down = image.cam_from_world().rotation.matrix() @ [0, 0, -1]
            assert np.allclose(prior.gravity, down, atol=1e-9)
    finally:
        database.close()


@pytest.mark.parametrize("lens, coefficients, model_name", LENSES)
def test_pycolmap_projects_as_our_lenses_do(tmp_path, lens, coefficients, model_name):
    """The points of tracks that our projections have made lie where COLMAP's do."""
    import pycolmap
    scene = ["--set", f"distortion={lens}"]
    for i, coefficient in enumerate(coefficients.split()):
        scene += ["--set", f"distortion_{i + 1}={coefficient}"]
    walk = Walk(tmp_path, *SMALL, *scene)
    model = pycolmap.Reconstruction(str(walk.export("colmap", "model", "--recording", walk.recording)))
    assert model.camera(1).model_name == model_name
    for point_id, lengths in reprojection_errors(model).items():
        assert np.mean(lengths) == pytest.approx(model.point3D(point_id).error, abs=1e-6)


def size_of(png):
    header = png.read_bytes()[:24]
    assert header.startswith(b"\x89PNG")
    return int.from_bytes(header[16:20], "big"), int.from_bytes(header[20:24], "big")


def test_a_lens_that_colmap_does_not_have_is_undistorted(tmp_path):
    import pycolmap
    walk = Walk(tmp_path, *SMALL, *(word for one in ("distortion=ds", "distortion_1=-0.2", "distortion_2=0.55", "cameras=2")
                                    for word in ("--set", one)))
    folder = walk.export("colmap", "model", "--recording", walk.recording, "--undistort", "--smoothed")
    model = pycolmap.Reconstruction(str(folder))
    assert {camera.model_name for camera in model.cameras.values()} == {"PINHOLE"}
    errors = reprojection_errors(model)
    for point_id, lengths in errors.items():
        assert np.mean(lengths) == pytest.approx(model.point3D(point_id).error, abs=1e-6)
    assert np.mean(np.concatenate(list(errors.values()))) < 0.5
    for image in model.images.values():
        assert size_of(folder / "images" / image.name) == (376, 240)
        for point in image.points2D:
            assert 0 < point.xy[0] < 376 and 0 < point.xy[1] < 240
    data = json.loads((walk.export("nerfstudio", "nerf", "--recording", walk.recording, "--undistort") / "transforms.json")
                      .read_text())
    assert (data["camera_model"], data["k1"]) == ("OPENCV", 0)
    assert data["fl_x"] == pytest.approx(model.camera(1).params[0])
    assert all(size_of(walk.folder / "nerf" / frame["file_path"]) == (376, 240) for frame in data["frames"])
    assert len(data["frames"]) == len(walk.time_ns)
