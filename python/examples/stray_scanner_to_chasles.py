#!/usr/bin/env python3
"""A recording of the iPhone app Stray Scanner becomes a folder that `chasles run` reads.

    pip install av pandas scipy
    stray_scanner_to_chasles.py 71de12f9 walk && chasles run walk -o run
    stray_scanner_to_chasles.py 71de12f9 walk 0.03 0.06 0     the camera's place in the axes of the IMU [m]

The folder has rgb.mp4, times.txt, imu.csv, calibration.yaml and arkit.tum, by the clock of the phone. The app writes
other things than its data specification states, and than one would expect:

- The video's own times are made up, 1/60 s apart: the times of the pictures are in odometry.csv. The first picture is
  stamped before the begin of the video, so no program shows it: what is shown as picture k belongs to row k + 1.
- Accelerations are in g, by some versions in m/s^2, and a phone that is still shows them downward: the specific force
  is their opposite.
- An acceleration and a rate with one time may have been measured a sample apart.

The axes are Core Motion's and ARKit's. Held upright, with the screen towards you, the IMU has x to the right, y up and
z towards you. The image lies on its side: its right is down (-y), its lower edge left (-x). The camera's place is
unknown, and a walk of some seconds shows little of it: state it, or run with --set calibrate_extrinsics=true --set
initial_extrinsic_translation_sigma=0.1. The intrinsics are those of the last picture, and the readout of the rolling
shutter is not written (--set readout_time=S). arkit.tum has ARKit's poses of the IMU, in a world with z up. They are no
truth: `chasles evaluate run walk/arkit.tum` compares both.
"""
import json
import shutil
import sys
from pathlib import Path

import av
import numpy
import pandas
from scipy.spatial.transform import Rotation

# Apple states no noise of its IMUs. An assumption: the densities of Bosch's BMI270, an IMU for small devices (its data
# sheet BST-BMI270-DS000-07: 160 ug/sqrt(Hz), 0.007 deg/s/sqrt(Hz)), and biases that walk as those of Aria's glasses.
RIG = {"accelerometer_noise_density": 1.57e-3, "accelerometer_random_walk": 3.43e-4, "format": "chasles-recording-1",
       "gyroscope_noise_density": 1.22e-4, "gyroscope_random_walk": 2.27e-5, "imu_convention": "instant"}
NAMES = {"timestamp": "t [s]", "alpha_x": "wx", "alpha_y": "wy", "alpha_z": "wz", "a_x": "ax", "a_y": "ay", "a_z": "az"}
CAM_R_IMU = Rotation.from_matrix([[0, -1, 0], [-1, 0, 0], [0, 0, -1]])
LEVEL = Rotation.from_euler("x", 90, degrees=True)  # ARKit's world has y up

if len(sys.argv) not in (3, 6):
    sys.exit(__doc__)
scan, folder, imu_p_cam = Path(sys.argv[1]), Path(sys.argv[2]), numpy.array(sys.argv[3:] or [0, 0, 0], float)
try:
    imu = pandas.read_csv(scan / "imu.csv", skipinitialspace=True, usecols=[*NAMES]).dropna().rename(columns=NAMES)
    path = pandas.read_csv(scan / "odometry.csv", skipinitialspace=True, usecols="timestamp x y z qx qy qz qw".split())
    (fx, _, cx), (_, fy, cy), _ = numpy.loadtxt(scan / "camera_matrix.csv", delimiter=",").tolist()
    with av.open(str(scan / "rgb.mp4")) as video:
        size = video.streams.video[0].width, video.streams.video[0].height
        shown = sum(packet.size > 0 and not packet.is_discard for packet in video.demux(video=0))
except (OSError, KeyError, TypeError, ValueError, IndexError) as error:
    sys.exit(f"{scan}: expected imu.csv, odometry.csv, camera_matrix.csv and rgb.mp4 of Stray Scanner: {error!r}")
if not len(path) - 1 <= shown <= len(path):
    sys.exit(f"{scan}: odometry.csv has {len(path)} rows, rgb.mp4 shows {shown} pictures; expected as many or one less")
# In g, half of the forces are about 1 long; in m/s^2 they are 9.8 long.
imu[["ax", "ay", "az"]] *= -9.80665 if (imu[["ax", "ay", "az"]] ** 2).sum(axis=1).median() < 9 else -1
cam_T_imu = numpy.block([[CAM_R_IMU.as_matrix(), -CAM_R_IMU.apply(imu_p_cam)[:, None]], [numpy.zeros(3), 1]]).tolist()
camera = {"resolution": size, "intrinsics": [fx, fy, cx, cy], "distortion_model": "none", "cam_T_imu": cam_T_imu}
world_R_imu = LEVEL * Rotation.from_quat(path[["qx", "qy", "qz", "qw"]]) * CAM_R_IMU
positions = LEVEL.apply(path[["x", "y", "z"]]) - world_R_imu.apply(imu_p_cam)
folder.mkdir(parents=True)
shutil.copy(scan / "rgb.mp4", folder)
(folder / "calibration.yaml").write_text(json.dumps({**RIG, "name": folder.name, "cameras": [camera]}))  # JSON is YAML
numpy.savetxt(folder / "times.txt", path["timestamp"][-shown:], "%.9f")
imu.to_csv(folder / "imu.csv", columns=[*NAMES.values()], index=False)
numpy.savetxt(folder / "arkit.tum", numpy.column_stack([path["timestamp"], positions, world_R_imu.as_quat()]), "%.9f")
