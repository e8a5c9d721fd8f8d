#!/usr/bin/env python3
"""A recording of Project Aria's glasses (VRS) becomes a folder that `chasles run` reads.

    pip install projectaria-tools
    aria_to_chasles.py walk.vrs walk && chasles run walk -o run
    aria_to_chasles.py gen2.vrs gen2 slam-front-left slam-front-right       the cameras of Aria Gen 2

The folder has images/cam0, images/cam1, ... named by their times [ns], gyro.csv and accel.csv of imu-right, and
calibration.yaml, by the clock of the device. Pixels stay as they are: fisheye624 is Aria's FISHEYE624, and in both the
centre of the first pixel is (0, 0). Samples are rectified. The time offset that the calibration states for a sensor is
taken off its times: the filters of imu-right delay forces by 3 ms and rates by 4 ms. The cameras must have this lens
and global shutters, as the SLAM cameras have. The run's path is that of imu-right; get_imu_calib("imu-right") has its
place on the device.
"""
import json
import sys
from pathlib import Path

import numpy
from PIL import Image
from projectaria_tools.core import data_provider

# White noise and bias instability of imu-right by Project Aria's page "IMU noise model": 80 ug/sqrt(Hz), 35 ug,
# 0.01 deg/s/sqrt(Hz), 0.0013 deg/s. It has no random walk: let a bias change by its instability in a second.
rig = {"accelerometer_noise_density": 7.85e-4, "accelerometer_random_walk": 3.43e-4, "format": "chasles-recording-1",
       "gyroscope_noise_density": 1.75e-4, "gyroscope_random_walk": 2.27e-5, "imu_convention": "instant", "cameras": []}

if len(sys.argv) < 3:
    sys.exit(__doc__)
vrs, folder, cameras = sys.argv[1], Path(sys.argv[2]), sys.argv[3:] or ["camera-slam-left", "camera-slam-right"]
provider = data_provider.create_vrs_data_provider(vrs)
streams = {label: provider and provider.get_stream_id_from_label(label) for label in [*cameras, "imu-right"]}
sensors = {label: i and provider.get_sensor_calibration(i) for label, i in streams.items()}
if lacking := [label for label, i in streams.items() if not (sensors[label] and provider.get_num_data(i))]:
    sys.exit(f"{vrs}: expected a VRS file of Aria, found no data with a calibration of {lacking}")
imu, imu_stream = sensors["imu-right"].imu_calibration(), streams["imu-right"]
folder.mkdir(parents=True)
for number, label in enumerate(cameras):
    lens, images = sensors[label].camera_calibration(), folder / f"images/cam{number}"
    f, cx, cy, *coefficients = lens.get_projection_params().tolist()
    cam_T_imu = (lens.get_transform_device_camera().inverse() @ imu.get_transform_device_imu()).to_matrix().tolist()
    rig["cameras"].append({"resolution": lens.get_image_size().tolist(), "intrinsics": [f, f, cx, cy],
                           "distortion_model": lens.get_model_name().name.lower(), "distortion_coeffs": coefficients,
                           "timeshift_cam_imu": -lens.get_time_offset_sec_device_camera(), "cam_T_imu": cam_T_imu})
    images.mkdir(parents=True)
    for i in range(provider.get_num_data(streams[label])):
        image, record = provider.get_image_data_by_index(streams[label], i)
        Image.fromarray(image.to_numpy_array()).save(images / f"{record.capture_timestamp_ns}.png")
(folder / "calibration.yaml").write_text(json.dumps({**rig, "name": folder.name}))  # JSON is YAML
samples = [provider.get_imu_data_by_index(imu_stream, i) for i in range(provider.get_num_data(imu_stream))]
for name, delay, rectified in [
        ("gyro", imu.get_time_offset_sec_device_gyro(), lambda s: imu.raw_to_rectified_gyro(s.gyro_radsec)),
        ("accel", imu.get_time_offset_sec_device_accel(), lambda s: imu.raw_to_rectified_accel(s.accel_msec2))]:
    rows = [(s.capture_timestamp_ns - 1e9 * delay, *rectified(s)) for s in samples if s.gyro_valid and s.accel_valid]
    numpy.savetxt(folder / f"{name}.csv", rows, "%.0f,%.9f,%.9f,%.9f", header="time_ns,x,y,z", comments="")
