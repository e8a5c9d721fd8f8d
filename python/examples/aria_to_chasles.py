#!/usr/bin/env python3
"""A recording of Project Aria's glasses (VRS) becomes a folder that `chasles run` reads.

    pip install projectaria-tools
    aria_to_chasles.py walk.vrs walk && chasles run walk -o run
    aria_to_chasles.py gen2.vrs gen2 slam-front-left slam-front-right       the cameras of Aria Gen 2

The folder has images/cam0, images/cam1, ... named by their times [ns], gyro.csv and accel.csv of imu-right, and
calibration.yaml, by the clock of the device. Pixels stay as they are: fisheye624 is Aria's FISHEYE624, and in both the
centre of the first pixel is (0, 0). Samples are rectified. The time offset that the calibration states for a sensor is
taken off its times: the filters of imu-right delay forces by 3 ms and rates by 4 ms. The cameras must have global
shutters, as the SLAM cameras have. The run's path is that of imu-right; get_imu_calib("imu-right") has its place on the
device.
"""
import json
import math
import pathlib
import sys

from PIL import Image
from projectaria_tools.core import calibration, data_provider

# White noise and bias instability of imu-right by Project Aria's page "IMU noise model", in g and degrees. It has no random
# walk: let a bias change by its instability in a second.
NOISE = {"accelerometer_noise_density": 0.8e-4 * 9.81, "accelerometer_random_walk": 3.5e-5 * 9.81,
         "gyroscope_noise_density": math.radians(1e-2), "gyroscope_random_walk": math.radians(1.3e-3)}

if len(sys.argv) < 3:
    sys.exit(__doc__)
recording, folder, cameras = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3:] or ["camera-slam-left", "camera-slam-right"]
provider = data_provider.create_vrs_data_provider(recording)
device = provider and provider.get_device_calibration()
if not device or folder.exists():
    sys.exit(f"{folder}: exists already" if device else f"{recording}: expected a VRS file with Aria's calibration, found none")
streams = {label: provider.get_stream_id_from_label(label) for label in [*cameras, "imu-right"]}
lenses, imu = {label: device.get_camera_calib(label) for label in cameras}, device.get_imu_calib("imu-right")
usable = [label for label, lens in lenses.items() if lens and lens.get_model_name() == calibration.CameraModelType.FISHEYE624]
usable += ["imu-right"] if imu else []
if lacking := [label for label, i in streams.items() if label not in usable or not i or not provider.get_num_data(i)]:
    sys.exit(f"{recording}: has no data of {lacking}, or no calibration with FISHEYE624; it calibrates {device.get_all_labels()}")
rig = {"format": "chasles-recording-1", "name": folder.name, "cameras": [], "imu_convention": "instant", **NOISE}
for number, (label, lens) in enumerate(lenses.items()):
    f, cx, cy, *coefficients = lens.get_projection_params().tolist()
    cam_T_imu = lens.get_transform_device_camera().inverse() @ imu.get_transform_device_imu()
    rig["cameras"].append({"resolution": lens.get_image_size().tolist(), "intrinsics": [f, f, cx, cy],
                           "distortion_model": "fisheye624",
                           "distortion_coeffs": coefficients, "timeshift_cam_imu": -lens.get_time_offset_sec_device_camera(),
                           "cam_T_imu": cam_T_imu.to_matrix().tolist()})
    (folder / f"images/cam{number}").mkdir(parents=True)
    for i in range(provider.get_num_data(streams[label])):
        image, record = provider.get_image_data_by_index(streams[label], i)
        Image.fromarray(image.to_numpy_array()).save(folder / f"images/cam{number}/{record.capture_timestamp_ns}.png")
(folder / "calibration.yaml").write_text(json.dumps(rig))  # JSON is YAML
samples = [provider.get_imu_data_by_index(streams["imu-right"], i) for i in range(provider.get_num_data(streams["imu-right"]))]
rates = [(s.capture_timestamp_ns, imu.raw_to_rectified_gyro(s.gyro_radsec)) for s in samples if s.gyro_valid]
forces = [(s.capture_timestamp_ns, imu.raw_to_rectified_accel(s.accel_msec2)) for s in samples if s.accel_valid]
for name, axes, delay, values in [("gyro", "wx,wy,wz", imu.get_time_offset_sec_device_gyro(), rates),
                                  ("accel", "ax,ay,az", imu.get_time_offset_sec_device_accel(), forces)]:
    rows = (f"{time - round(1e9 * delay)},{','.join(map(str, value))}\n" for time, value in values)
    (folder / f"{name}.csv").write_text(f"time_ns,{axes}\n" + "".join(rows))
