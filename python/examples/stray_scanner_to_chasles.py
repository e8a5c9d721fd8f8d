#!/usr/bin/env python3
"""A recording of the iPhone app Stray Scanner becomes a folder that `chasles run` reads.

    pip install av numpy scipy
    stray_scanner_to_chasles.py 71de12f9 walk && chasles run walk -o run
    stray_scanner_to_chasles.py 71de12f9 walk 0.03 0.06 0     the camera's place in the axes of the IMU [m]

The folder has rgb.mp4, times.txt, imu.csv, calibration.yaml and arkit.tum, by the clock of the phone. The app writes other
things than its data specification states, and than one would expect:

- The video's own times are made up, 1/60 s apart: the times of the pictures are in odometry.csv. The first picture is
  stamped before the begin of the video, so no program shows it: what is shown as picture k belongs to row k + 1.
- Accelerations are in g, by some versions in m/s^2, and a phone that is still shows them downward: the specific force
  is their opposite.
- An acceleration and a rate with one time may have been measured a sample apart.

The axes are Core Motion's and ARKit's. Held upright, with the screen towards you, the IMU has x to the right, y up and z
towards you. The image lies on its side: its right is down (-y), its lower edge left (-x). The camera's place is unknown, and a
walk of some seconds shows little of it: state it, or run with --set calibrate_extrinsics=true --set
initial_extrinsic_translation_sigma=0.1. The intrinsics are those of the last picture, and the readout of the rolling shutter
is not written (--set readout_time=S). arkit.tum has ARKit's poses of the IMU, in a world with z up. They are no truth:
`chasles evaluate run walk/arkit.tum` compares both.
"""
import csv
import json
import math
import pathlib
import shutil
import sys

import av
import numpy
from scipy.spatial.transform import Rotation

# Noise densities of a phone's IMU by its data sheet (Bosch BMI270); the walks of its biases, which that has not, as Aria's.
NOISE = {"accelerometer_noise_density": 160e-6 * 9.81, "accelerometer_random_walk": 3.5e-5 * 9.81,
         "gyroscope_noise_density": math.radians(7e-3), "gyroscope_random_walk": math.radians(1.3e-3)}
CAM_R_IMU = numpy.array([[0, -1, 0], [-1, 0, 0], [0, 0, -1]])


def columns(file, names):
    with open(file, newline="") as table:
        return numpy.array([[float(row[name]) for name in names.split()] for row in csv.DictReader(table, skipinitialspace=True)])


if len(sys.argv) not in (3, 6):
    sys.exit(__doc__)
scan, folder, imu_p_cam = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), numpy.array(sys.argv[3:] or [0, 0, 0], float)
if folder.exists():
    sys.exit(f"{folder}: exists already")
try:
    imu = columns(scan / "imu.csv", "timestamp alpha_x alpha_y alpha_z a_x a_y a_z")
    path = columns(scan / "odometry.csv", "timestamp x y z qx qy qz qw")
    (fx, _, cx), (_, fy, cy), _ = numpy.loadtxt(scan / "camera_matrix.csv", delimiter=",").tolist()
    with av.open(str(scan / "rgb.mp4")) as video:
        size = video.streams.video[0].width, video.streams.video[0].height
        shown = sum(packet.size > 0 and not packet.is_discard for packet in video.demux(video=0))
except (OSError, KeyError, TypeError, ValueError, IndexError) as error:
    sys.exit(f"{scan}: expected imu.csv, odometry.csv, camera_matrix.csv and rgb.mp4 of Stray Scanner: {error!r}")
if not len(path) - 1 <= shown <= len(path):
    sys.exit(f"{scan}: odometry.csv has {len(path)} rows, and rgb.mp4 shows {shown} pictures; expected as many, or one less")
cam_T_imu = numpy.block([[CAM_R_IMU, -CAM_R_IMU @ imu_p_cam[:, None]], [numpy.zeros(3), 1]])
camera = {"resolution": size, "intrinsics": [fx, fy, cx, cy], "distortion_model": "none", "cam_T_imu": cam_T_imu.tolist()}
rig = {"format": "chasles-recording-1", "name": folder.name, "cameras": [camera], "imu_convention": "instant", **NOISE}
in_g = numpy.median(numpy.linalg.norm(imu[:, 4:], axis=1)) < 3
imu[:, 4:] *= -9.80665 if in_g else -1
level = Rotation.from_euler("x", 90, degrees=True)  # ARKit's world has y up
world_R_cam = level * Rotation.from_quat(path[:, 4:])
positions = level.apply(path[:, 1:4]) + world_R_cam.apply(cam_T_imu[:3, 3])
orientations = (world_R_cam * Rotation.from_matrix(CAM_R_IMU)).as_quat()
folder.mkdir(parents=True)
shutil.copy(scan / "rgb.mp4", folder)
(folder / "calibration.yaml").write_text(json.dumps(rig))  # JSON is YAML
(folder / "times.txt").write_text("".join(f"{time:.9f}\n" for time in path[-shown:, 0]))
numpy.savetxt(folder / "imu.csv", imu, "%.9f", ",", header="time [s],wx,wy,wz,ax,ay,az", comments="")
numpy.savetxt(folder / "arkit.tum", numpy.column_stack([path[:, 0], positions, orientations]), "%.9f")
